"""A clock for runs on emulated devices."""

import threading
import time

_MOST = 0.003  # [s] that it advances by from one look at it to the next


class PatientClock:
    """The monotonic clock without its leaps, for a machine that takes the processor away now and then.

    A supervisor ends such a pause with an overrun, as it must: no scenario can allow one of more than `STOP_WITHIN`.
    Where there is no hand on the device, a run may go on instead. From any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._seen = self._now = time.monotonic()

    def __call__(self) -> float:
        """The time [s]."""
        with self._lock:
            seen = time.monotonic()
            self._now += min(seen - self._seen, _MOST)
            self._seen = seen
            return self._now
