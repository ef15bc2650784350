"""What a station has where its object may be carried: a grip, and how the object hangs in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydrake.systems.framework import System

from mmt_drake.errors import BadInput
from mmt_drake.quantities import Checked, Quantity
from mmt_drake.systems.carried_reflection import CarriedReflection
from mmt_drake.systems.grip_script import GripScript
from mmt_drake.systems.load_estimator import LoadEstimator
from mmt_drake.systems.on_table import Hang

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site


@dataclass(frozen=True)
class Carrying(Checked):
    """A telerobot with a gripper, and a hand that closes and opens it.

    Attributes:
        hang: how the object hangs in the grip.
        closes, opens: when a scripted hand does so, after the start of each cycle of its motion [s].
        grip: force of the closed grip [N].
        height: of the object above the table, as it is known beforehand [m]: its centre is believed in the middle until
            it is told; null: it is not known. Of several objects the camera tells it.

    Raises:
        BadInput: a value out of range, or a grip that opens before it closes.
    """

    hang: Hang = field(default_factory=Hang)
    closes: Annotated[float, Quantity("s")] = 7.0
    opens: Annotated[float, Quantity("s")] = 17.5
    grip: Annotated[float, Quantity("N", 1.0, 100.0)] = 10.0
    height: Annotated[float | None, Quantity("m", 0.01, 1.0)] = None

    CALLED: ClassVar = "carrying"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.opens > self.closes:
            expected = f"after it closes, at {self.closes:g} s"
            raise BadInput("carrying", at="opens", found=self.opens, expected=expected)


def load(site: Site) -> System | None:
    """The telerobot's estimator of what it carries."""
    return None if site.scenario.carrying is None else LoadEstimator(period=site.step)


def carried(site: Site) -> System | None:
    """What the operator feels of an object off the table."""
    chosen = site.scenario.carrying
    if chosen is None:
        return None
    seen, updates = site.scenario.several is not None, site.scenario.renderer.updates
    return CarriedReflection(period=site.step, updates=updates, height=chosen.height or 0.0, seen=seen)


def grip_script(site: Site) -> System | None:
    """The grip of a hand that has no trigger."""
    chosen = site.scenario.carrying
    if chosen is None or site.person.system.HasOutputPort("grip"):
        return None
    return GripScript(chosen.closes, chosen.opens, chosen.grip, site.person.duration)
