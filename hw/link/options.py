"""Signals of a link, and its limits."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from mmt_drake.ceilings import Bound, refuse_beyond
from mmt_drake.errors import BadInput
from mmt_drake.hw.safety.limits import OURS
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Quantity

Role = Literal["operator", "telerobot"]
OPERATOR: Role = "operator"
TELEROBOT: Role = "telerobot"
ROLES: tuple[Role, ...] = (OPERATOR, TELEROBOT)

LARGEST_SIGNAL = 128
"""Numbers in one vector at most, so that a packet fits the smallest network's frame (1280 bytes)."""


@dataclass(frozen=True)
class LinkSignal:
    """A vector that crosses the link in one direction.

    Attributes:
        name: of the vector; both sides must agree.
        initial: (n) what is shown before anything has arrived.
        when_lost: (n) what is shown while the peer is lost; NaN: what was shown last is kept.
        may_be_nan: (n) where NaN is a value ('not known yet'). A packet with NaN elsewhere, or an infinity, is refused.
        motion: so many numbers at the front are positions followed by as many velocities; a play-out buffer bridges
            gaps by their cubic, and holds the others.
        may_jump: where it is sent: its source can jump, as a slider does; where it is shown: one that can is taken.
    """

    name: str
    initial: Array
    when_lost: Array = field(default_factory=lambda: np.empty(0))
    may_be_nan: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=np.bool_))
    motion: int = 0
    may_jump: bool = False

    def __post_init__(self) -> None:
        n = self.size
        if not 1 <= n <= LARGEST_SIGNAL:
            raise BadInput("link", at=self.name, found=f"{n} numbers", expected=f"1 to {LARGEST_SIGNAL}")
        if self.motion % 2 or not 0 <= self.motion <= n:
            found = f"{self.motion} numbers of motion among {n}"
            raise BadInput("link", at=self.name, found=found, expected="as many velocities as positions")
        if not self.when_lost.size:
            object.__setattr__(self, "when_lost", np.full(n, np.nan))
        if not self.may_be_nan.size:
            object.__setattr__(self, "may_be_nan", np.zeros(n, dtype=np.bool_))
        for name in ("when_lost", "may_be_nan"):
            if getattr(self, name).shape != (n,):
                found = f"{name} of shape {getattr(self, name).shape}"
                raise BadInput("link", at=self.name, found=found, expected=f"shape ({n},)")

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return int(self.initial.size)


@dataclass(frozen=True)
class LinkOptions(Checked):
    """Limits of one end of a link.

    Attributes:
        timeout: the peer counts as lost when no sample has come for so long [s].
            One that comes later than the quickest by more than this counts as not come.
        oldest: a sample that may be older than this is not applied [s]. How old it may be is known without the peer's
            clock: since the time in our clock that it echoes. It must exceed the round trip.
        playout: what arrives is shown so long after the earliest that it could have come [s]; 0: at once, newest first.
        cloud_points: of a surface at most.
        cloud_interval: between two surfaces whose points differ [s]; one that only moves is sent with every frame.
    """

    timeout: Annotated[float, Quantity("s", 1e-3, 60.0), Bound(2.0, "s", OURS)] = 0.1
    oldest: Annotated[float, Quantity("s", 1e-3, 60.0), Bound(5.0, "s", OURS)] = 0.5
    playout: Annotated[float, Quantity("s", 0.0, 2.0)] = 0.0
    cloud_points: Annotated[int, Quantity("", 1, 100_000, whole=True)] = 5000
    cloud_interval: Annotated[float, Quantity("s", 0.01, 3600.0)] = 0.5

    CALLED: ClassVar = "link"

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_beyond(self, "link")
