"""A base for what is closed at the end of a `with`.

It has no abstract method: Drake's classes, which some of these are too, have another metaclass.
"""

from typing import Self


class Closing:
    """Closed at the end of a `with`, whatever happened in it."""

    __slots__ = ()

    def close(self) -> None:
        """Give back what this holds; may be called again."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
