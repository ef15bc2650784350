"""A browser that goes away, or does not read any more: the hand does not notice."""

import random
import socket
import struct
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from urllib.parse import urlsplit

from mmt_drake.diagrams.proof.faults.injection import Tally, emulated_omega
from mmt_drake.diagrams.proof.faults.session import FORCE, Session
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.viewer.charts import page
from mmt_drake.viewer.viewer import Viewer

_WATCHED = 60  # ticks


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """Both ways in which a browser can leave."""
    omega = emulated_omega(folder)
    for kind, leave in KINDS.items():
        yield try_kind(kind, leave, omega, moments, folder / "viewer.mcap")


def try_kind(
    kind: str, leave: Callable[[socket.socket], None], omega: EmulatedOmega, moments: int, record: Path
) -> Row:
    """One kind, in one session; each browser is another one."""
    draw, tally = random.Random(kind), Tally(FORCE)
    with ExitStack() as browsers, Viewer(page()) as viewer, Session(omega, record, meshcat=viewer) as session:
        tally.armed(session, "at the start")
        for moment in range(moments):
            browser = browsers.enter_context(_browser(viewer.url))
            session.go(draw.randrange(40))
            tally.begin(session)
            leave(browser)
            session.go(_WATCHED)
            on_for = tally.force_for(session, moment)
            if not session.armed:
                tally.surprise(session, moment, on_for)
    tally.recorded(session, record)
    return tally.row(kind, "viewer", moments)


def _browser(url: str) -> socket.socket:
    """The viewer's stream of events, as its page opens it, with a small window for what it is sent."""
    at = urlsplit(url)
    browser = socket.socket()
    browser.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    browser.connect((at.hostname or "127.0.0.1", at.port or 80))
    browser.sendall(f"GET {at.path}events HTTP/1.1\r\nHost: {at.netloc}\r\n\r\n".encode())
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
