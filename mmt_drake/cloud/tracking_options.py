"""How objects on a table are told apart."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mmt_drake.errors import BadInput
from mmt_drake.quantities import Checked, Delay, Length, Quantity, Time


@dataclass(frozen=True)
class Tracking(Checked):
    """How objects are told apart.

    Attributes:
        fewest: points of a top, at least.
        probe: radius about the probe in which what is above its tip is the probe's [m].
        hides: distance from the probe in which it may hide an object [m].
        lost_after: an object that should be seen and is not is lost after this time [s].
        taken_after: and taken away after this [s]; one that may be hidden after three times that.
        latency: from a cloud to what is told of it [s], less than the time between clouds.

    Raises:
        BadInput: a value out of range.
    """

    fewest: Annotated[int, Quantity("", 3, whole=True)] = 20
    probe: Length = 0.012
    hides: Length = 0.05
    lost_after: Time = 0.15
    taken_after: Time = 1.0
    latency: Delay = 0.02

    CALLED: ClassVar = "tracking"

    def refuse_period(self, period: float, what: str = "tracking", at: str = "latency") -> None:
        """Refuse clouds that come so often [s]: what is told of one must be there before the next.

        Raises:
            BadInput: of `at` in `what`: the latency is as long as that.
        """
        if self.latency >= period:
            raise BadInput(
                what, at=at, found=self.latency, expected=f"0 to below {period:g} s, the time between clouds"
            )
