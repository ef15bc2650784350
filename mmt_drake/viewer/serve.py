"""The process behind `viewer`: gives the page to whoever knows its address, and takes sliders from that page alone.

It is what a web page of anybody's, and any program of this machine, can talk to; so it believes nothing. A request is
answered if its Host is this server's (a name that an attacker's DNS points here is another one), its Origin is none or
this server's, and its address begins with the token; a slider is moved by a request whose Origin is this server's. All
else is dropped and counted. What is held for a browser is bounded, however slowly it reads.

On standard input, a socket, the run says what is shown, and reads where sliders stand; standard output has the port,
and at the end the counts. It ends where its input ends, and needs nothing but Python's own library.
"""

import asyncio
import hmac
import json
import os
import pickle
import socket
import struct
import sys
from base64 import b64encode
from collections import Counter, deque
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from typing import Any

PATIENCE = 5.0  # [s] with half a request, and with a browser that reads nothing
LARGEST_HEAD, LARGEST_BODY = 1 << 16, 1 << 10  # [bytes]; cookies of other servers on this machine come along
MOST_CONNECTIONS, MOST_STREAMS = 256, 16
_BATCHES = 512  # of samples that are kept for a page that is opened later
_SLIDERS_EVERY, _REFUSED_EVERY = 0.01, 0.5  # [s]
NO_PORT = 3  # exit status: the port that was asked for cannot be had
_SAFE = (
    "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n"
    "Content-Security-Policy: default-src 'self' 'unsafe-inline' data: blob:; object-src 'none'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'\r\nConnection: close\r\n"
)


class Refused(Exception):
    """A request that is dropped: what it is answered, and why, in words of ours."""

    def __init__(self, status: HTTPStatus, why: str) -> None:
        super().__init__(why)
        self.status, self.why = status, why


class Request:
    """The head of a request, as far as it is needed.

    Args:
        head: with the empty line that ends it.

    Raises:
        Refused: it is none.
    """

    def __init__(self, head: bytes) -> None:
        first, *lines = head.decode("latin-1").removesuffix("\r\n\r\n").split("\r\n")
        words, fields = first.split(" "), [line.partition(":") for line in lines]
        names = [name.lower() for name, _, _ in fields]
        broken = any(not (name.isascii() and colon) or name != name.strip() for name, colon, _ in fields)
        if broken or len(words) != 3 or not words[2].startswith("HTTP/1.") or "transfer-encoding" in names:
            raise Refused(HTTPStatus.BAD_REQUEST, "unreadable")
        for name in ("host", "origin", "content-length"):
            if names.count(name) > 1:
                raise Refused(HTTPStatus.BAD_REQUEST, "unreadable")
        self.method, self.path = words[:2]
        self._fields = {name: value.strip() for name, (_, _, value) in zip(names, fields, strict=True)}

    def __getitem__(self, name: str) -> str | None:
        return self._fields.get(name)

    @property
    def length(self) -> int:
        """Of what follows [bytes]."""
        said = self["content-length"] or "0"
        if not (said.isascii() and said.isdigit()):
            raise Refused(HTTPStatus.BAD_REQUEST, "unreadable")
        if len(said) > 6 or int(said) > LARGEST_BODY:
            raise Refused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "too large")
        return int(said)


class Server:
    """The things that are shown, and those who look.

    Args:
        settings: `token` of the address, the `page`, and the file of the `script` that draws it.
        run: which is told of moved sliders, and of how many look.
    """

    def __init__(self, settings: dict[str, Any], run: asyncio.StreamWriter) -> None:
        self._token, self._run = settings["token"].encode(), run
        self._pages = {"": ("text/html", settings["page"].encode())}
        self._pages["meshcat.js"] = ("text/javascript", Path(settings["script"]).read_bytes())
        self._hosts: tuple[str, ...] = ()
        self._shown: dict[Any, tuple[int, bytes]] = {}  # by what it is of, in the order in which it first came
        self._version = 0
        self._batches: deque[bytes] = deque(maxlen=_BATCHES)
        self._sampled = 0  # batches, ever
        self._changed = asyncio.Event()
        self._sliders: dict[str, dict[str, Any]] = {}
        self._moved: dict[str, float] = {}  # what the run does not know yet
        self._telling = self._counting = False
        self._connections = self._streams = 0
        self.refused: Counter[str] = Counter()

    def listen_at(self, port: int) -> None:
        """Note where browsers believe to be."""
        self._hosts = (f"127.0.0.1:{port}", f"localhost:{port}")

    def show(self, messages: dict[Any, dict[str, Any]]) -> None:
        """Take in what the run draws: each message replaces the one with its key, but samples come one by one."""
        for key, message in messages.items():
            if message["type"] == "samples":
                if message["fresh"]:
                    self._batches.clear()
                self._sampled += 1
                self._batches.append(_written(message))
                continue
            if message["type"] == "slider":
                self._sliders[message["name"]] = message
            self._version += 1
            self._shown[key] = self._version, _written(message)
        changed, self._changed = self._changed, asyncio.Event()
        changed.set()

    async def answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One connection, from its first byte to its end."""
        self._connections += 1
        try:
            if self._connections <= MOST_CONNECTIONS:
                await self._answer(reader, writer)
            else:
                self._count("too many connections")
        except (OSError, TimeoutError):
            pass  # it has gone, or stopped reading
        finally:
            self._connections -= 1
            if writer.transport.get_write_buffer_size():
                writer.transport.abort()
            else:
                writer.close()

    async def _answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            request, body = await self._request(reader)
            if request is None:
                return
            page = self._checked(request)
            if request.method == "POST" and page == "sliders":
                self._move(body)
                await _reply(writer, HTTPStatus.NO_CONTENT)
            elif request.method == "GET" and page == "events":
                await self._stream(writer)
            elif request.method == "GET" and page in self._pages:
                await _reply(writer, HTTPStatus.OK, *self._pages[page])
            else:
                raise Refused(HTTPStatus.NOT_FOUND, "no such page")
        except Refused as error:
            self._count(error.why)
            await _reply(writer, error.status, "text/plain", f"{error.why}\n".encode())

    async def _request(self, reader: asyncio.StreamReader) -> tuple[Request | None, bytes]:
        """A whole request in time; None if not a byte of one has come."""
        first = b""
        try:
            async with asyncio.timeout(PATIENCE):
                first = await reader.read(1)
                if not first:
                    return None, b""
                request = Request(first + await reader.readuntil(b"\r\n\r\n"))
                return request, await reader.readexactly(request.length)
        except TimeoutError:
            if not first:  # a browser opens connections before it needs them
                return None, b""
            raise Refused(HTTPStatus.REQUEST_TIMEOUT, "too slow") from None
        except asyncio.IncompleteReadError:
            raise Refused(HTTPStatus.BAD_REQUEST, "unreadable") from None
        except asyncio.LimitOverrunError:
            raise Refused(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "too large") from None

    def _checked(self, request: Request) -> str:
        """The page that is asked for, by somebody who may."""
        if request["host"] not in self._hosts:
            raise Refused(HTTPStatus.MISDIRECTED_REQUEST, "foreign host")
        ours = f"http://{request['host']}"
        if request["origin"] not in ((ours,) if request.method == "POST" else (ours, None)):
            raise Refused(HTTPStatus.FORBIDDEN, "foreign origin")
        token, slash, page = request.path.removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode("latin-1"), self._token) or not slash:
            raise Refused(HTTPStatus.NOT_FOUND, "no token")
        return page

    def _move(self, body: bytes) -> None:
        """Move a slider: `{"name": ..., "value": ...}`."""
        try:
            said = json.loads(body)
            slider, value = self._sliders[said["name"]], said["value"]
            believed = type(value) in (int, float) and slider["least"] <= value <= slider["greatest"]
        except (ValueError, TypeError, KeyError, RecursionError):
            believed = False
        if not believed:
            raise Refused(HTTPStatus.BAD_REQUEST, "no slider's value")
        slider = {**slider, "value": float(value)}
        self.show({("slider", slider["name"]): slider})
        self._moved[slider["name"]] = slider["value"]
        self._tell_soon()

    def _tell_soon(self) -> None:
        if not self._telling:
            self._telling = True
            asyncio.get_running_loop().call_later(_SLIDERS_EVERY, self._tell_run)

    def _tell_run(self) -> None:
        """Tell the run which sliders were moved, and how many look; once it has taken in what it was told before."""
        self._telling = bool(self._run.transport.get_write_buffer_size())
        if self._telling:
            asyncio.get_running_loop().call_later(_SLIDERS_EVERY, self._tell_run)
        else:
            self._run.write(json.dumps({"moved": self._moved, "looking": self._streams}).encode() + b"\n")
            self._moved = {}

    def _count(self, why: str) -> None:
        self.refused[why] += 1
        if not self._counting:
            self._counting = True
            asyncio.get_running_loop().call_later(_REFUSED_EVERY, self._tell_pages)

    def _tell_pages(self) -> None:
        self._counting = False
        self.show({"refused": {"type": "refused", "count": self.refused.total()}})

    async def _stream(self, writer: asyncio.StreamWriter) -> None:
        """Server-sent events: what is shown now, then what changes, as fast as it is read."""
        if self._streams >= MOST_STREAMS:
            raise Refused(HTTPStatus.SERVICE_UNAVAILABLE, "too many connections")
        self._streams += 1
        self._tell_soon()
        try:
            writer.transport.set_write_buffer_limits(0)
            writer.write(_head(HTTPStatus.OK, "text/event-stream") + b"retry: 1000\n\n")
            version = sampled = 0
            while True:
                changed = self._changed
                new = [message for at, message in self._shown.values() if at > version]
                missed = min(self._sampled - sampled, len(self._batches))
                new += list(self._batches)[len(self._batches) - missed :]
                version, sampled = self._version, self._sampled
                writer.write(b"data: [" + b",".join(new) + b"]\n\n" if new else b":\n\n")
                async with asyncio.timeout(PATIENCE):
                    await writer.drain()
                with suppress(TimeoutError):  # then a sign of life is due, which shows whether anybody is there
                    async with asyncio.timeout(PATIENCE):
                        await changed.wait()
        finally:
            self._streams -= 1
            self._tell_soon()


def _written(message: dict[str, Any]) -> bytes:
    return json.dumps(message, default=lambda numbers: b64encode(numbers).decode()).encode()


def _head(status: HTTPStatus, kind: str) -> bytes:
    return f"HTTP/1.1 {status.value} {status.phrase}\r\nContent-Type: {kind}; charset=utf-8\r\n{_SAFE}\r\n".encode()


async def _reply(writer: asyncio.StreamWriter, status: HTTPStatus, kind: str = "text/plain", body: bytes = b"") -> None:
    writer.transport.set_write_buffer_limits(0)
    writer.write(_head(status, kind) + body)
    async with asyncio.timeout(PATIENCE):
        await writer.drain()


async def main() -> int:
    """Serve until standard input ends; gives the exit status."""
    asyncio.get_running_loop().set_exception_handler(lambda *_: None)  # the terminal is the run's
    said, run = await asyncio.open_connection(sock=socket.socket(fileno=0))

    async def hear() -> Any:
        return pickle.loads(await said.readexactly(*struct.unpack("<I", await said.readexactly(4))))

    settings = await hear()
    server = Server(settings, run)
    try:
        listening = await asyncio.start_server(server.answer, "127.0.0.1", settings["port"], limit=LARGEST_HEAD)
    except OSError:
        return NO_PORT
    port = listening.sockets[0].getsockname()[1]
    server.listen_at(port)
    os.write(1, b"%d\n" % port)
    with suppress(asyncio.IncompleteReadError, OSError):
        while True:
            server.show(await hear())
    with suppress(OSError):  # the run was killed
        os.write(1, json.dumps(server.refused).encode())
    return 0


if __name__ == "__main__":
    sys.exit(asyncio.run(main()))
