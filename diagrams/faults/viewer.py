"""A browser that goes away, or does not read any more: the hand does not notice."""

from __future__ import annotations

import base64
import logging
import random
import socket
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import urlsplit

from pydrake.geometry import Meshcat, MeshcatParams

from mmt_drake.diagrams.faults.emulated import emulated_omega
from mmt_drake.diagrams.faults.row import Row
from mmt_drake.diagrams.faults.session import FORCE, PERIOD, Session
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.recording import load

_WATCHED = 60  # ticks


def try_viewer(moments: int, folder: Path) -> Iterator[Row]:
    """Both ways in which a browser can leave."""
    omega = emulated_omega(folder)
    for kind, leave in KINDS.items():
        yield try_kind(kind, leave, omega, moments, folder / "viewer.mcap")


def try_kind(
    kind: str, leave: Callable[[socket.socket], None], omega: EmulatedOmega, moments: int, record: Path
) -> Row:
    """One kind, in one session; each browser is another one."""
    draw, log = random.Random(kind), logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.WARNING)  # where it listens is of no interest
    meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    log.setLevel(level)
    greatest, wrong = 0.0, []
    browsers: list[socket.socket] = []
    with Session(omega, record, meshcat=meshcat) as session:
        if not session.arm():
            wrong.append(f"cannot be armed: {session.told()}")
        for moment in range(moments):
            browsers.append(_browser(meshcat.web_url()))
            session.go(draw.randrange(40))
            session.begin_moment()
            leave(browsers[-1])
            session.go(_WATCHED)
            force = omega.get("greatest_force")
            greatest = max(greatest, force)
            if not (session.armed and force <= FORCE * (1 + 1e-9)):
                wrong.append(f"{moment}: {session.told()}, {force:.3g} N")
    for browser in browsers:
        browser.close()
    recorded = load(record, forces=False).time
    if len(recorded) != session.tick:
        wrong.append(f"{session.tick} ticks, of which {len(recorded)} were recorded")
    unreadable = (session.tick - 1) * PERIOD - float(recorded[-1])
    return Row(kind, "viewer", moments, greatest, FORCE, unreadable=unreadable, wrong=tuple(wrong))


def _browser(url: str) -> socket.socket:
    """A WebSocket to the viewer, as a browser opens it (RFC 6455), with a small window for what it is sent."""
    place = urlsplit(url)
    browser = socket.socket()
    browser.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    browser.connect((place.hostname or "localhost", place.port or 80))
    key = base64.b64encode(bytes(16)).decode()
    lines = ["GET / HTTP/1.1", f"Host: {place.netloc}", "Upgrade: websocket", "Connection: Upgrade"]
    lines += [f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13", "", ""]
    browser.sendall("\r\n".join(lines).encode())
    if b" 101 " not in browser.recv(256):
        raise ConnectionError(f"{url} takes no WebSocket")
    return browser


def _killed(browser: socket.socket) -> None:
    """The connection is reset, as when a browser is killed or its machine switched off."""
    browser.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    browser.close()


def _stalled(browser: socket.socket) -> None:
    """It stays and reads nothing any more."""


KINDS: dict[str, Callable[[socket.socket], None]] = {"viewer gone": _killed, "viewer reads no more": _stalled}
