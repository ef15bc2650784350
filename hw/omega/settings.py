"""Settings of the device: which one, how it is set up, and how its workspace lies on the table."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mmt_drake.ceilings import Bound, refuse_beyond
from mmt_drake.errors import BadInput
from mmt_drake.hw.rotation import rotation_matrix
from mmt_drake.hw.safety.limits import OMEGA_7, OURS, STOP_WITHIN
from mmt_drake.quantities import Checked, Force, Quantity

Calibration = Literal["required", "automatic", "none"]

_INDEX = Quantity("", 0, 31, whole=True)
_SCALE = Quantity("", positive=True)
_WATCHDOG_UNIT = 125e-6  # [s]
_STIFFNESS = "both together 25: 500 N/m feel like 12.5 of the 14.5 N/mm of the omega.7 data sheet"
_NO_WATCHDOG = "a process that hangs leaves its last force on the device until it goes on or is ended"


@dataclass(frozen=True)
class Trigger(Checked):
    """The gripper of an Omega.7 as a trigger that closes and opens a grip, on a spring of its own.

    The grip grows evenly from where the trigger is open to where it is closed; the spring opens it.

    Attributes:
        open, closed: its opening where it grips nothing, and where it grips with all its force [m].
        grip: force that it stands for when closed [N].
        stiffness: of its spring [N/m].
        force: greatest force of the spring [N].

    Raises:
        BadInput: a number out of its range or beyond its bound, or a trigger that is closed where it is open.
    """

    open: Annotated[float, Quantity("m", 0.002, 0.05)] = 0.022
    closed: Annotated[float, Quantity("m", 0.0, 0.05)] = 0.006
    grip: Annotated[float, Quantity("N", 1.0, 100.0)] = 10.0
    stiffness: Annotated[float, Quantity("N/m"), Bound(1000.0, "N/m", OURS)] = 150.0
    force: Annotated[Force, Bound(8.0, "N", OMEGA_7)] = 4.0

    CALLED: ClassVar = "trigger"

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_beyond(self, "trigger")
        if not self.closed < self.open:
            raise BadInput("trigger", at="closed", found=self.closed, expected=f"less than open, {self.open:g} m")

    def grip_at(self, gap: float) -> float:
        """Force of the grip at an opening [m] of the trigger [N]."""
        return self.grip * min(max((self.open - gap) / (self.open - self.closed), 0.0), 1.0)

    def spring_at(self, gap: float, gain: float) -> float:
        """Force that opens it [N], by the gain of a supervisor; 0 where one of them is no number."""
        if not (math.isfinite(gap) and 0.0 <= gain <= 1.0):
            return 0.0
        return gain * min(self.stiffness * max(self.open - gap, 0.0), self.force)


@dataclass(frozen=True)
class OmegaSettings(Checked):
    """One haptic device.

    The device's own frame has x towards the operator, y to the operator's right and z up. A point p of it is at
    `origin` + `scale` R (p - `centre`) in the table frame, R = Rz(yaw) Ry(pitch) Rx(roll), until the clutch moves it.

    Attributes:
        library: folder of the vendor's SDK, or of an emulated one, which is code that runs here; null: the one that
            the variable FDSDK names, or an installed one.
        device: index, as the vendor's programs list it; null takes the first one that is free.
        calibration: what is done if the device does not know where it is: `required` refuses to run, `automatic` lets
            it move by itself until it does (keep hands off), `none` goes on with positions that may be wrong.
        gravity_compensation: the device carries the weight of its own arms.
        velocity_window: of the vendor's velocity estimate [s]; it lags by half of it.
        watchdog: after this long without a command the device itself turns its forces off [s]; null leaves it out, for
            a device that has none: nothing then ends the force of a process that hangs.
        force: greatest force that the driver ever sends [N].
        scale: table metres per device metre.
        force_scale: newtons felt per newton rendered.
        rotation: roll, pitch, yaw of the device's frame in the table's [deg].
        centre: a point of the device's workspace, device frame [m],
        origin: and where it is on the table [m].
        clutch_button: the button that is pressed to reposition the hand (0: the closed gripper of an Omega.7); null:
            there is no clutch.
        trigger: the gripper closes and opens a grip, and is then no button; null: it does not.

    Raises:
        BadInput: a number that is not finite, out of its range or beyond its bound.
    """

    library: str | None = None
    device: Annotated[int | None, _INDEX] = None
    calibration: Annotated[Calibration, Bound(order=get_args(Calibration))] = "required"
    gravity_compensation: bool = True
    velocity_window: Annotated[float, Quantity("s", 0.001), Bound(0.020, "s", "the vendor's own default")] = 0.010
    watchdog: Annotated[
        float | None,
        Quantity("s", _WATCHDOG_UNIT),
        Bound(STOP_WITHIN, "s", "a fault is over within 20 ms", without=_NO_WATCHDOG),
    ] = 0.015
    force: Annotated[Force, Bound(12.0, "N", OMEGA_7)] = 8.0
    scale: Annotated[float, _SCALE, Bound(5.0, "", _STIFFNESS)] = 1.0
    force_scale: Annotated[float, _SCALE, Bound(5.0, "", _STIFFNESS)] = 1.0
    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.02)
    clutch_button: Annotated[int | None, _INDEX] = 0
    trigger: Trigger | None = None

    CALLED: ClassVar = "omega"

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_beyond(self, "omega")
        if self.trigger is not None and self.clutch_button == 0:
            expected = "null, or another button: the gripper is the trigger"
            raise BadInput("omega", at="clutch_button", found=0, expected=expected)

    @property
    def watchdog_units(self) -> int:
        """The watchdog in units of the device; 0 is none."""
        return 0 if self.watchdog is None else round(self.watchdog / _WATCHDOG_UNIT)

    def rotation_matrix(self) -> NDArray[np.float64]:
        """(3, 3) R, from the device's frame to the table's."""
        return rotation_matrix(self.rotation)
