"""Settings of the arm: which one, what it holds, how it yields, and how far it may go."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mmt_drake.ceilings import Bound, refuse_beyond
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.rotation import rotation_matrix
from mmt_drake.hw.safety.limits import BOX, OURS, REACH
from mmt_drake.quantities import Checked, Force, Length, Quantity, Speed, Time
from mmt_drake.systems.cartesian_impedance import Impedance

Triple = tuple[float, float, float]
RealTime = Literal["enforce", "ignore"]

_ROBOT = "Franka Robotics, robot and interface specifications"
_CONTACT = "ISO/TS 15066, face, the weakest part of a body that may be touched"
_HAND = "ISO/TS 15066, hands and fingers"


@dataclass(frozen=True)
class FrankaSettings(Checked):
    """One arm that pulls its tip to where it is commanded, like a spring and a damper.

    The table frame is at `table` in the arm's base frame, turned by `rotation`.

    Attributes:
        address: of the robot, a name or a number.
        realtime: `enforce` refuses to run without a real-time kernel, `ignore` is for trying out.
        table: origin of the table frame in the base frame [m],
        rotation: and roll, pitch, yaw of it [deg].
        tip: of the probe, in the frame of the nominal end effector [m].
        load_mass: what the arm carries beyond the end effector that its own interface knows [kg]; the robot takes this
            weight off the force that it estimates. What the probe compensation takes off must not contain it again.
        load_centre: of that mass, in the flange's frame [m].
        impedance: how it yields, as the simulated arm; its springs must not be without stiffness.
        pull: greatest force of the spring along each axis [N].
        force: force at the tip at which the arm stops [N], its estimate's offset included.
        collision_force, collision_torque: at which the robot's own reflex stops it [N], [N m].
        speed: greatest speed of a set-point [m/s],
        tip_speed: and of the tip itself [m/s].
        low, high: corners of the box in which set-points must stay, table frame [m].
        approach: speed at which the tip comes to the first set-point [m/s].
        jump: greatest distance between set-points [m].
        gap: longest time without a new reading [s].
        hold_after: without a set-point for so long the arm holds its place [s],
        stop_after: and after so long it stops [s].
        stop_ramp: time in which a stop takes its torques back [s].
        stop_within: longest time that a stop takes [s].

    Raises:
        BadInput: a number that is not finite, out of its range or beyond its bound, a box without room.
    """

    address: str
    realtime: Annotated[RealTime, Bound(order=get_args(RealTime))] = "enforce"
    table: Triple = (0.5, 0.0, 0.2)
    rotation: Triple = (0.0, 0.0, 0.0)
    tip: Triple = (0.0, 0.0, 0.0)
    load_mass: Annotated[float, Quantity("kg"), Bound(3.0, "kg", f"payload; {_ROBOT}", fact=True)] = 0.0
    load_centre: Triple = (0.0, 0.0, 0.0)
    impedance: Impedance = field(default_factory=Impedance)
    pull: Annotated[Force, Bound(65.0, "N", _CONTACT)] = 30.0
    force: Annotated[Force, Bound(65.0, "N", _CONTACT)] = 25.0
    collision_force: Annotated[Force, Bound(140.0, "N", _HAND)] = 40.0
    collision_torque: Annotated[float, Quantity("N m", positive=True), Bound(87.0, "N m", _ROBOT)] = 40.0
    speed: Annotated[Speed, Bound(1.7, "m/s", _ROBOT)] = 0.5
    tip_speed: Annotated[Speed, Bound(1.7, "m/s", _ROBOT)] = 0.75
    low: Annotated[Triple, Bound(REACH, "m", "reach of the arm")] = (-0.2, -0.2, -0.05)
    high: Annotated[Triple, Bound(REACH, "m", "reach of the arm")] = (0.2, 0.2, 0.3)
    approach: Annotated[Speed, Bound(0.25, "m/s", "ISO 10218-1, reduced speed")] = 0.05
    jump: Annotated[Length, Bound(0.05, "m", OURS)] = 0.02
    gap: Annotated[Time, Bound(0.5, "s", OURS)] = 0.050
    hold_after: Annotated[Time, Bound(0.1, "s", OURS)] = 0.020
    stop_after: Annotated[Time, Bound(2.0, "s", OURS)] = 0.5
    stop_ramp: Annotated[Time, Bound(0.5, "s", OURS)] = 0.1
    stop_within: Annotated[Time, Bound(1.0, "s", OURS)] = 0.5

    CALLED: ClassVar = "franka"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("stiffness", "rotational_stiffness"):
            check_number("franka", f"impedance.{name}", getattr(self.impedance, name), least=0.0, open_interval=True)
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise BadInput("franka", at="low, high", found=(self.low, self.high), expected=BOX)
        for name, other in (("hold_after", "stop_after"), ("stop_ramp", "stop_within")):
            if getattr(self, name) >= getattr(self, other):
                raise BadInput("franka", at=name, found=getattr(self, name), expected=f"less than {other}")
        if not self.address:
            raise BadInput("franka", at="address", found="nothing", expected="the robot's name or number")
        refuse_beyond(self, "franka")

    def rotation_matrix(self) -> NDArray[np.float64]:
        """(3, 3) from the table frame to the base frame, R = Rz(yaw) Ry(pitch) Rx(roll)."""
        return rotation_matrix(self.rotation)
