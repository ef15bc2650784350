"""A base for what is closed at the end of a `with`."""

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from typing import Self


class Closing:
    """Closed at the end of a `with`, whatever happened in it.

    Attributes:
        close: gives back what this holds, and may be called again; each class has its own. (An abstract method is not
            to be had: Drake's classes, which some of these are too, have another metaclass.)
    """

    __slots__ = ()
    close: Callable[[], None]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def close_all(things: Iterable[Closing]) -> None:
    """Close each, from the last to the first, whatever becomes of one of them."""
    with ExitStack() as closing:
        for thing in things:
            closing.callback(thing.close)
