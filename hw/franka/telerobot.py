"""An arm that follows set-points and feels what it touches, with the ports of a simulated one."""

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
    - `age` (1): of what is commanded [s]; a tick's set-point is from now where it is not connected.
    - `switches` (2), as an `OperatorSwitch` has them: arm, 1 while a person presses it, which asks for control, and
      emergency stop: anything but 0 stops. May stay unconnected.
    - `motion` (6): where the tip is [m], and its velocity [m/s]; where it was last while readings fail.
    - `raw_measurement` (9): position [m], velocity [m/s], and the force on the tip as the robot estimates it [N]: its
      offset, and the weight and inertia of what the robot does not know of, are still in it.
    - `device` (3): fault code (0: well; else `describe_fault`), time of the latest reading [s] by a clock that is never
      set, and 1 while the arm does not follow the set-points (else 0).

    The arm, and what its driver knows, is outside the Context: a cloned Context shares it.

    Args:
        settings: which arm, and how it is set up.
        period: of the ticks [s].

    Raises:
        MissingDependency, DeviceError: as `FrankaArm`.
    """

    def __init__(self, settings: FrankaSettings, *, period: float = 1e-3) -> None:
        super().__init__()
        self._driver = driver = FrankaDriver(settings)
        self.declare_inputs("commanded", "age", "switches", optional=("age", "switches"))
        self._pressed = True  # a switch that is stuck asks for nothing
        latest = driver.latest
        measured = np.concatenate([latest.motion, latest.force])
        for name, first in (("motion", latest.motion), ("raw_measurement", measured), ("device", latest.device)):
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(first))
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
        commanded, age, switches = self.inputs_at(context)
        if switches is not None:
            arm, stop = switches
            self._driver.emergency_stop(stop != 0.0)
            if arm == 1.0 and not self._pressed:
                self._driver.request_control()
            self._pressed = arm != 0.0
        self._driver.send(commanded, 0.0 if age is None else float(age[0]))
