"""Statistics of values of which some, or all, may not be known."""

from collections.abc import Callable, Iterable
from typing import Any


def of_known(statistic: Callable[[list[float]], Any], values: Iterable[float | None]) -> float | None:
    """A statistic of the values that are known; None where none is."""
    known = [value for value in values if value is not None]
    return float(statistic(known)) if known else None
