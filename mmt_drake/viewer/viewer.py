"""The page of the live view, our own: the scene, charts beside it and sliders.

Drake's Meshcat draws well, and its socket obeys every web page that is open on this machine. So its script draws, and
nothing else of it is used: a process of our own (`serve.py`) gives page and scene, to whoever knows the address alone.
A thread of the run would take the interpreter from it whenever somebody looks. The process ends with the run, however
that ends.
"""

import json
import pickle
import secrets
import socket
import struct
import subprocess
import sys
from array import array
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common import FindResourceOrThrow

from mmt_drake.closing import Closing
from mmt_drake.errors import BadInput
from mmt_drake.viewer.serve import NO_PORT

_PATIENCE = 5.0  # [s] with a server that is to end
_MOST_NUMBERS = 200_000  # of samples that wait for a server that takes none

Message = dict[str, Any]


class Viewer(Closing):
    """A page on a free port of the loopback interface, and what it shows; nobody need look, and no call waits.

    Attributes:
        url: of the page; who knows it may look, and move the sliders.
        drawn: the latest message about each thing, as Meshcat's script takes them; numbers of arrays are bytes.
        values: where each slider stood when `hear` was called last.
        looking: how many browsers showed the page then.
        refused: why requests were dropped -> how many; known once it is closed.

    Args:
        page: HTML.
        port: to be found at; 0: one that is free.

    Raises:
        BadInput: the process cannot be started, or has no port.
    """

    def __init__(self, page: str, port: int = 0) -> None:
        self.drawn: dict[tuple[str, ...], Message] = {}
        self.values: dict[str, float] = {}
        self.looking = 0
        self.refused: dict[str, int] = {}
        self._changed: dict[tuple[str, ...], None] = {}  # of what is drawn
        self._samples: list[float] = []
        self._fresh = False
        self._heard = b""
        self._socket, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-I", "-S", str(Path(__file__).with_name("serve.py"))],
                stdin=theirs.fileno(),
                stdout=subprocess.PIPE,
                bufsize=0,
                process_group=0,  # Ctrl-C is for the run
            )
        self._socket.setblocking(False)
        token = secrets.token_urlsafe(16)
        script = FindResourceOrThrow("drake/geometry/meshcat.js")
        self._unsent = _framed({"token": token, "page": page, "script": script, "port": port})
        with suppress(OSError):  # it has ended; what it says, or does not, tells
            self.flush()
        assert self._process.stdout is not None
        told = self._process.stdout.readline().strip()
        if not told:
            self.close()
            status = self._process.returncode
            found = f"port {port}, which is taken" if status == NO_PORT else f"its server ended with status {status}"
            raise BadInput("viewer", found=found, expected="a free port")
        # By number: what listens at this machine's other addresses may be somebody else.
        self.url = f"http://127.0.0.1:{int(told)}/{token}/"

    def set_object(self, path: str, thing: Message) -> None:
        """Draw a thing (`shapes`) at a path of the scene, in place of what was there."""
        self._draw(("object", path), {"type": "set_object", "path": path, "object": thing})

    def set_transform(self, path: str, matrix: ArrayLike) -> None:
        """Place and stretch what is at a path: (4, 4), finite; lengths in m."""
        columns = np.asarray(matrix, dtype=np.float64).tobytes("F")
        self._draw(("transform", path), {"type": "set_transform", "path": path, "matrix": columns})

    def set_property(self, path: str, name: str, value: bool | list[float]) -> None:
        """Set a property of what is at a path, as `visible` or `color`."""
        message = {"type": "set_property", "path": path, "property": name, "value": value}
        self._draw(("property", path, name), message)

    def set_camera(self, position: tuple[float, float, float], target: tuple[float, float, float]) -> None:
        """Look from a place to another [m]."""
        (x, y, z), (at_x, at_y, at_z) = position, target  # the script's own frame has y up
        self.set_property("/Cameras/default/rotated/<object>", "position", [x, z, -y])
        self._draw(("target",), {"type": "set_target", "value": [at_x, at_z, -at_y]})

    def add_slider(self, name: str, least: float, greatest: float, step: float, value: float) -> None:
        """Put a slider on the page, in place of one with its name."""
        self.values[name] = value
        message = {"type": "slider", "name": name, "least": least, "greatest": greatest, "step": step, "value": value}
        self._draw(("slider", name), message)

    def add_samples(self, values: list[float], *, fresh: bool = False) -> None:
        """Have the charts go on by samples, one after the other; `fresh`: in the place of all before."""
        if fresh:
            self._samples, self._fresh = [], True
        self._samples += values
        if len(self._samples) > _MOST_NUMBERS:  # whole samples go
            del self._samples[: -(_MOST_NUMBERS // len(values)) * len(values)]

    def flush(self) -> None:
        """Send what has changed to the server, unless it is still busy with what came before.

        Raises:
            OSError: it has ended.
        """
        if self._samples and not self._unsent:
            numbers = array("d", self._samples).tobytes()
            self._draw(("samples",), {"type": "samples", "samples": numbers, "fresh": self._fresh})
            self._samples, self._fresh = [], False
        if self._changed and not self._unsent:
            self._unsent = _framed({key: self.drawn[key] for key in self._changed})
            self._changed = {}
        with suppress(BlockingIOError):
            while self._unsent:
                self._unsent = self._unsent[self._socket.send(self._unsent) :]

    def hear(self) -> dict[str, float]:
        """The sliders' present `values`, which stay as they are once the server has ended; and who is `looking`."""
        with suppress(OSError):
            self._heard += self._socket.recv(1 << 16)
        *whole, self._heard = self._heard.split(b"\n")
        for line in whole:
            said = json.loads(line)
            self.values |= said["moved"]
            self.looking = said["looking"]
        return self.values

    def close(self) -> None:
        """End the server. A second call does nothing."""
        self._socket.close()
        if self._process.returncode is None:
            try:
                counts, _ = self._process.communicate(timeout=_PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                counts, _ = self._process.communicate()
            self.refused = json.loads(counts or "{}")

    def _draw(self, key: tuple[str, ...], message: Message) -> None:
        self.drawn[key] = message
        self._changed[key] = None


def _framed(said: object) -> bytes:
    packed = pickle.dumps(said)
    return struct.pack("<I", len(packed)) + packed
