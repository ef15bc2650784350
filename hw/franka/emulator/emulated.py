"""The far side of an emulated arm: what it meets, its faults, what it does."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from mmt_drake.closing import Closing
from mmt_drake.errors import MissingDependency, MmtError

_GET_IT = "get it with: pip install 'franky-sim>=1.0.4'"
_ROOT = Path(__file__).resolve().parents[3]


class EmulatedFranka(Closing):
    """A simulated arm in a process of its own, which ends with this object.

    Raises:
        MissingDependency: the simulator is not installed.
        MmtError: it does not start.
    """

    def __init__(self) -> None:
        if importlib.util.find_spec("franky_sim") is None:
            raise MissingDependency(f"franka emulator: Python package franky-sim not found; {_GET_IT}")
        command = [sys.executable, "-m", "mmt_drake.hw.franka.emulator"]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, cwd=_ROOT, stdin=pipe, stdout=pipe, text=True)
        #: Where it serves.
        self.address: str = self._answer()["address"]

    def set(self, **members: Any) -> dict[str, Any]:
        """Change what it meets or what is wrong with it, the members of `server.World`; gives what `get` does."""
        return self._ask({"set": members})

    def reset(self) -> None:
        """Nothing wrong, and the arm at rest where it began."""
        self._ask({"reset": True})

    def get(self) -> dict[str, Any]:
        """What it does: `position` (3) and `velocity` (3) of the tip in the base frame, `torque` (7), `mode`, ..."""
        return self._ask({})

    def close(self) -> None:
        """End the process; the connection dies with it."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.communicate()

    def _ask(self, request: dict[str, Any]) -> dict[str, Any]:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        return self._answer()

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            self.close()
            raise MmtError("franka emulator: it ended")
        answer: dict[str, Any] = json.loads(line)
        return answer
