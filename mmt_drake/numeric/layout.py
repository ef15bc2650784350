"""Layouts of vectors: where their parts stand."""


class Layout:
    """Gives out the parts of a vector, one after the other, as plain numbers and slices for compiled code.

    Attributes:
        size: of all that has been given out.
    """

    def __init__(self) -> None:
        self.size = 0

    def __call__(self, size: int = 1) -> int:
        """Index at which the next part, of this size, begins."""
        self.size += size
        return self.size - size

    def part(self, size: int) -> slice:
        """The next part, of this size."""
        return slice(self(size), self.size)
