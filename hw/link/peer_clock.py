"""The peer's time in ours."""

STEP = 250_000_000
"""Two clocks count as set against each other where they are off by more than this [ns]."""

_SPAN = 2_000_000_000  # over which the quickest packet is sought [ns]: clocks that drift by 1e-4 part by 0.2 ms
_AGREE = 20  # packets that must agree that the clocks were set; so many late ones in a row are no reordering


class PeerClock:
    """Maps the peer's times of sending to ours by the quickest packets of the last seconds.

    The offset is the least of (arrival - sent): clock difference plus shortest transit. It follows drift, and a clock
    that was set (a machine that slept, a peer that moved) after `_AGREE` packets.

    Args:
        step: by which a packet is off [ns] that shows that the clocks were set, or that the way has become longer, if
            those behind it agree.

    Attributes:
        steps: how often the clocks were seen to be set.
    """

    __slots__ = ("_begun", "_far", "_least", "_previous", "_step", "steps")

    def __init__(self, step: int = STEP) -> None:
        self._step = step
        self.steps = 0
        self._begun = False
        self._far = 0
        self._least = self._previous = (0, 0)  # when its span began, the least offset of it

    @property
    def offset(self) -> int:
        """Our time less the peer's, shortest transit included [ns]; 0 before the first packet."""
        return min(self._least[1], self._previous[1])

    def note(self, sent: int, arrived: int) -> bool:
        """Take a packet's times in.

        Args:
            sent: on the peer's clock [ns].
            arrived: on ours [ns].

        Returns:
            Whether this packet showed that the clocks were set: earlier times of the peer mean nothing any more.
        """
        offset = arrived - sent
        if not self._begun:
            self._begun = True
            self._least = self._previous = (arrived, offset)
            return False
        if abs(offset - self.offset) > self._step:
            self._far += 1
            if self._far < _AGREE:
                return False
            self._far = 0
            self.steps += 1
            self._least = self._previous = (arrived, offset)
            return True
        self._far = 0
        if arrived - self._least[0] > _SPAN:
            self._previous, self._least = self._least, (arrived, offset)
        elif offset < self._least[1]:
            self._least = (self._least[0], offset)
        return False
