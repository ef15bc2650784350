"""A browser that goes away, or does not read any more: the hand does not notice."""

import random
import socket
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import urlsplit

from mmt_drake.diagrams.faults.session import FORCE, PERIOD, Session, emulated_omega
from mmt_drake.diagrams.faults.table import Row
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.recording import load
from mmt_drake.viewer.charts import page
from mmt_drake.viewer.viewer import Viewer

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
    draw = random.Random(kind)
    greatest, wrong = 0.0, []
    browsers: list[socket.socket] = []
    with Viewer(page()) as viewer, Session(omega, record, meshcat=viewer) as session:
        if not session.arm():
            wrong.append(f"cannot be armed: {session.told()}")
        for moment in range(moments):
            browsers.append(_browser(viewer.url))
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
    """The viewer's stream of events, as its page opens it, with a small window for what it is sent."""
    place = urlsplit(url)
    browser = socket.socket()
    browser.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    browser.connect((place.hostname or "127.0.0.1", place.port or 80))
    browser.sendall(f"GET {place.path}events HTTP/1.1\r\nHost: {place.netloc}\r\n\r\n".encode())
    if b" 200 " not in browser.recv(256):
        raise ConnectionError(f"{url} has no events")
    return browser


def _killed(browser: socket.socket) -> None:
    """The connection is reset, as when a browser is killed or its machine switched off."""
    browser.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    browser.close()


def _stalled(browser: socket.socket) -> None:
    """It stays and reads nothing any more."""


KINDS: dict[str, Callable[[socket.socket], None]] = {"viewer gone": _killed, "viewer reads no more": _stalled}
