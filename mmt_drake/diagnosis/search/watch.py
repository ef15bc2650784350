"""How long a search may take, and what it had no time for."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable

Told = Callable[[str], None]
Key = frozenset[str]


class Watch:
    """The clock of a search.

    Args:
        told: is told what is being tried.
        seconds: after so long nothing new is begun.
    """

    def __init__(self, told: Told = lambda _: None, seconds: float = math.inf) -> None:
        self.told = told
        self._end = time.monotonic() + seconds
        self._missed: dict[str, None] = {}

    def is_late(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() > self._end

    def miss(self, what: Iterable[str]) -> None:
        """Note what there was no time for."""
        self._missed.update(dict.fromkeys(what))

    @property
    def missed(self) -> tuple[str, ...]:
        """What there was no time for: effects, sets of them in words."""
        return tuple(self._missed)
