"""Options of the foreign object beyond the parameters that every flexible object has."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

from mmt_drake.foreign.numbers import Numbers
from mmt_drake.quantities import Checked, Quantity, Stiffness

_Instant = Annotated[float | None, Quantity("s")]


@dataclass(frozen=True)
class ForeignLaws(Checked):
    """Laws that no estimator here knows of; the defaults leave all of them out.

    Attributes:
        k3: cubic contact spring, k3 |d|^2 d [N/m^3], >= 0.
        hunt_crossley: contact damping that grows with the deflection, b2 (1 + hunt_crossley |d|) [1/m].
        wall: where a wall stands, met moving along + of either axis, in displacement of the body [m]; null: nowhere.
        wall_k: its stiffness [N/m].
        ground_k: spring from the body to the world [N/m] that is there from `ground_time` on, unstretched at x_m = 0.
        ground_time: [s]; null: never.
        mass_factor: by which the mass changes at `mass_time`, the velocity continuous; above 0.
        mass_time: [s]; null: never.
        k2_factor: by which k2 changes at `k2_time`; above 0.
        k2_time: [s]; null: never.

    Raises:
        BadInput: a value outside its range.
    """

    k3: Annotated[float, Quantity("N/m^3")] = 0.0
    hunt_crossley: Annotated[float, Quantity("1/m")] = 0.0
    wall: Annotated[float | None, Quantity("m")] = None
    wall_k: Stiffness = 2000.0
    ground_k: Stiffness = 100.0
    ground_time: _Instant = None
    mass_factor: Annotated[float, Quantity("", positive=True)] = 2.0
    mass_time: _Instant = None
    k2_factor: Annotated[float, Quantity("", positive=True)] = 1.3
    k2_time: _Instant = None

    CALLED: ClassVar = "laws"

    def added_to(self, numbers: Numbers) -> Numbers:
        """The numbers of an object with these laws."""
        return numbers._replace(
            k3=self.k3,
            hunt_crossley=self.hunt_crossley,
            stop_position=self.wall or 0.0,
            stop_stiffness=0.0 if self.wall is None else self.wall_k,
            ground_k=0.0 if self.ground_time is None else self.ground_k,
            ground_time=_instant(self.ground_time),
            dm=0.0 if self.mass_time is None else (self.mass_factor - 1.0) * numbers.m,
            mass_time=_instant(self.mass_time),
            step_loss=0.0 if self.k2_time is None else 1.0 - self.k2_factor,
            step_time=_instant(self.k2_time),
        )


@dataclass(frozen=True)
class ForeignSensors(Checked):
    """What stands between the true force and motion and what is measured, beside white noise.

    Force: low pass, delay, noise, resolution, in this order. Position: noise, resolution.

    Attributes:
        corner: of the force's first-order low pass [Hz]; null: there is none.
        delay: by which force is later than position [s], 0 to 20 ms.
        force_resolution, position_resolution: steps in which force [N] and position [m] are read; 0: continuous.
        velocity_window: measured velocity is the difference of measured positions over this time [s], a whole number of
            samples; 0: it is measured by itself, with noise of its own.

    Raises:
        BadInput: a value outside its range.
    """

    corner: Annotated[float | None, Quantity("Hz", positive=True)] = None
    delay: Annotated[float, Quantity("s", 0.0, 0.02)] = 0.0
    force_resolution: Annotated[float, Quantity("N")] = 0.0
    position_resolution: Annotated[float, Quantity("m")] = 0.0
    velocity_window: Annotated[float, Quantity("s", 0.0, 0.1)] = 0.0

    CALLED: ClassVar = "sensors"

    @property
    def lag(self) -> float:
        """Time constant of the low pass [s]; 0: there is none."""
        return 0.0 if self.corner is None else 1.0 / (2.0 * math.pi * self.corner)


def _instant(time: float | None) -> float:
    return math.inf if time is None else time
