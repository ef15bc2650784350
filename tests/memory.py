"""The memory that a computation takes."""

import tracemalloc
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


def peak_of(compute: Callable[[], T]) -> tuple[T, int]:
    """What it gives, and the most that it took at once [B]."""
    tracemalloc.start()
    try:
        return compute(), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
