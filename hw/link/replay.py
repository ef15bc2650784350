"""The window of sequence numbers that tells new packets from replayed ones."""

WINDOW = 1024
"""How far behind the newest a packet may come and still be taken."""


class ReplayWindow:
    """Takes every sequence number once, in any order within `WINDOW` (the sliding window of RFC 4303, 3.4.3)."""

    __slots__ = ("_newest", "_seen")

    def __init__(self) -> None:
        self._newest = -1
        self._seen = 0  # bit k: newest - k has been taken

    @property
    def newest(self) -> int:
        """The largest number taken; -1 before the first."""
        return self._newest

    def is_new(self, sequence: int) -> bool:
        """Whether this number may still be taken."""
        behind = self._newest - sequence
        return behind < 0 or (behind < WINDOW and not self._seen >> behind & 1)

    def take(self, sequence: int) -> None:
        """Take a number that is new; only after the packet proved authentic."""
        behind = self._newest - sequence
        if behind >= 0:
            self._seen |= 1 << behind
            return
        shift = -behind
        self._seen = (self._seen << shift | 1) & _MASK if shift < WINDOW else 1
        self._newest = sequence


_MASK = (1 << WINDOW) - 1
