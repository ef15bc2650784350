"""Browsers that misbehave, played by a bare socket."""

import errno
import json
import socket
from urllib.parse import urlsplit


class Address:
    """Where a viewer's page is, taken apart."""

    def __init__(self, url: str) -> None:
        place = urlsplit(url)
        self.host, self.path, self.port = place.netloc, place.path, place.port


def connect(url: str, window: int | None = None) -> socket.socket:
    """A connection, with a small window for what it is sent if so wanted."""
    connection = socket.socket()
    connection.settimeout(20.0)
    if window is not None:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, window)
    connection.connect(("127.0.0.1", Address(url).port))
    return connection


def head(url: str, first: str, **fields: str) -> bytes:
    """A request's head, as a browser sends it to `url`; fields replace or add to it."""
    lines = {"Host": Address(url).host, **fields}
    return "\r\n".join(
        [f"{first} HTTP/1.1", *(f"{k.replace('_', '-')}: {v}" for k, v in lines.items()), "", ""]
    ).encode()


def move(url: str, name: str, value: object, **fields: str) -> bytes:
    """The request that moves a slider; fields as for `head`."""
    body = json.dumps({"name": name, "value": value}).encode()
    fields = {"Origin": f"http://{Address(url).host}", "Content_Length": str(len(body)), **fields}
    return head(url, f"POST {Address(url).path}sliders", **fields) + body


def status(url: str, sent: bytes) -> int:
    """What a request is answered; 0: nothing, the connection is closed."""
    with connect(url) as connection:
        try:
            connection.sendall(sent)
            connection.shutdown(socket.SHUT_WR)
            answer = connection.recv(4096)
        except OSError as error:
            if isinstance(error, ConnectionError) or error.errno == errno.ENOTCONN:
                return 0
            raise
        return int(answer.split()[1]) if answer else 0


def stream(url: str, window: int | None = None) -> socket.socket:
    """The events of a viewer; nothing of them has been read."""
    connection = connect(url, window)
    connection.sendall(head(url, f"GET {Address(url).path}events"))
    return connection
