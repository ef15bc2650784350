"""An arm that follows set-points and feels what it touches, with the ports of a simulated one."""

import time
from collections.abc import Callable
from types import ModuleType

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, State

from mmt_drake.closing import Closing
from mmt_drake.hw.franka.driver import FrankaDriver
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.systems.leaf import LeafSystem


class FrankaTelerobot(LeafSystem, Closing):
    """The tip of a Franka, pulled to where it is commanded.

    At each tick the latest reading is taken *before* any other system is updated, and the set-point is handed over at
    its end; neither waits for the robot. What watches over the arm is the driver's thread (`FrankaDriver`), which goes
    on when ticks do not. Nothing moves before a person asks for it, by `request_control` or by a switch.

    .. pydrake_system::

        name: FrankaTelerobot
        input_ports:
        - commanded
        - age
        - switches
        output_ports:
        - motion
        - raw_measurement
        - device

    Ports (table frame):

    - `commanded` (6): where the tip should be [m], and its velocity [m/s].
    - `age` (1): of what is commanded [s]. Only there if asked for; a tick's set-point is from now otherwise.
    - `switches` (2), as an `OperatorSwitch` has them: arm, 1 while a person presses it, which asks for control, and
      emergency stop: anything but 0 stops. Only there if asked for.
    - `motion` (6): where the tip is [m], and its velocity [m/s]; where it was last while readings fail.
    - `raw_measurement` (9): position [m], velocity [m/s], and the force on the tip as the robot estimates it [N]: its
      offset, and the weight and inertia of what the robot does not know of, are still in it.
    - `device` (3): fault code (0: well; else `describe_fault`), time of the latest reading [s] by a clock that is never
      set, and 1 while the arm does not follow the set-points (else 0).

    The arm, and what its driver knows, is outside the Context: a cloned Context shares it.

    Args:
        settings: which arm, and how it is set up.
        period: of the ticks [s].
        aged: whether there is a port `age`.
        switched: whether there is a port `switches`.
        franky: the library; found by itself by default.
        clock: of readings and set-points [s].

    Raises:
        MissingDependency, DeviceError: as `FrankaArm`.
    """

    def __init__(
        self,
        settings: FrankaSettings,
        *,
        period: float = 1e-3,
        aged: bool = False,
        switched: bool = False,
        franky: ModuleType | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self.set_name("FrankaTelerobot")
        self._driver = driver = FrankaDriver(settings, franky, clock)
        self._commanded = self.DeclareVectorInputPort("commanded", 6)
        self._age = self.DeclareVectorInputPort("age", 1) if aged else None
        self._switches = self.DeclareVectorInputPort("switches", 2) if switched else None
        self._pressed = True  # a switch that is stuck asks for nothing
        latest = driver.latest
        measured = np.concatenate([latest.motion, latest.force])
        self.DeclareStateOutputPort("motion", self.DeclareDiscreteState(latest.motion))
        self.DeclareStateOutputPort("raw_measurement", self.DeclareDiscreteState(measured))
        self.DeclareStateOutputPort("device", self.DeclareDiscreteState(latest.device))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._read)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._send)

    def request_control(self) -> None:
        """Have the arm recover and follow set-points; a person's decision, from any thread."""
        self._driver.request_control()

    def close(self) -> None:
        """Bring the arm to rest and disconnect; ticks after that report a fault."""
        self._driver.close()

    def _read(self, context: Context, state: State) -> None:
        latest, values = self._driver.latest, state.get_mutable_discrete_state()
        values.get_mutable_value(0)[:] = latest.motion
        values.get_mutable_value(1)[:6] = latest.motion
        values.get_mutable_value(1)[6:] = latest.force
        values.get_mutable_value(2)[:] = latest.device

    def _send(self, context: Context, state: DiscreteValues) -> None:
        if self._switches is not None:
            arm, stop = self._switches.Eval(context)
            self._driver.emergency_stop(stop != 0.0)
            if arm == 1.0 and not self._pressed:
                self._driver.request_control()
            self._pressed = arm != 0.0
        age = 0.0 if self._age is None else float(self._age.Eval(context)[0])
        self._driver.send(self._commanded.Eval(context), age)
