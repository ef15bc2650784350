"""The latest replay of a recording, kept for the tracks of its other axes."""

import threading
from collections.abc import Callable
from typing import Any, TypeVar

from mmt_drake.diagnosis.signals.smoother import Smoothed

T = TypeVar("T")


class LatestReplay(threading.local):
    """The latest replay of each thread, which the tracks of a recording's other axes ask for again."""

    _recording: Smoothed | None = None
    _numbers: object = None
    _found: Any = None

    def of(self, recording: Smoothed, numbers: object, replay: Callable[[], T]) -> T:
        """What `replay` makes of a recording with a model's numbers, if it is not the latest already."""
        if self._recording is not recording or self._numbers != numbers:
            self._found = replay()
            self._recording, self._numbers = recording, numbers
        found: T = self._found
        return found
