"""An emulated device, its real driver, a supervisor and a stiff virtual wall in one diagram; time goes tick by tick."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.hw.omega import OmegaOperator, OmegaSettings
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety import OperatorSwitch, SafetyLimits, describe, supervised
from mmt_drake.systems.leaf import LeafSystem

Array = NDArray[np.float64]

PERIOD = 1e-3  # [s]
SETTINGS = OmegaSettings(device=0, calibration="required", force=7.0, origin=(0.0, 0.0, 0.01))
LIMITS = SafetyLimits(force=5.0, power=2.0, speed=0.6, rise=0.02)


class Wall(LeafSystem):
    """F_z = -k z - b v_z below z = 0, k = 400 N/m, b = 2 N s/m, and whatever a trial adds.

    .. pydrake_system::

        name: Wall
        input_ports:
        - motion
        output_ports:
        - force

    - `motion` (6): position [m] and velocity [m/s], table frame.
    - `force` (3): [N].
    """

    def __init__(self) -> None:
        super().__init__()
        self.added = np.zeros(3)
        self._motion = self.DeclareVectorInputPort("motion", 6)
        self.DeclareVectorOutputPort("force", 3, self._calc)

    def _calc(self, context: Context, output: BasicVector) -> None:
        motion = self._motion.Eval(context)
        force = self.added.copy()
        if motion[2] < 0.0:
            force[2] += -400.0 * motion[2] - 2.0 * motion[5]
        output.SetFromVector(force)


class RigClock:
    """The emulated device's, as its driver reads it.

    Attributes:
        offset: added to it [s].
    """

    def __init__(self, omega: EmulatedOmega) -> None:
        self._omega, self.offset = omega, 0.0

    def __call__(self) -> float:
        return self._omega.get("clock") + self.offset


class OmegaRig:
    """A session with an emulated hand that presses and strokes; nothing happens but in `go`.

    Attributes:
        omega: the far side of the device.
        wall: what is felt; a trial may add to it.
        switch: the person's.
        operator: the system of the driver.
        clock: the driver's.

    Args:
        omega: a fresh one.
        settings: of the driver.
        limits: of the supervisor.
    """

    def __init__(self, omega: EmulatedOmega, settings: OmegaSettings = SETTINGS, limits: SafetyLimits = LIMITS) -> None:
        self.omega, self.clock = omega, RigClock(omega)
        omega.set(target_z=-0.018, swing_x=0.01, swing_y=0.007, swing_z=0.006, swing_hz=1.7)
        self.operator = OmegaOperator(settings, clock=self.clock)
        self.switch = OperatorSwitch(
            period=2e-3, press=0.01, clock=lambda: omega.get("clock"), on_arm=self.operator.request_forces
        )
        self._diagram = supervised(self.operator, limits, watched={"peer": 0.05}, switch=self.switch)
        builder = DiagramBuilder()
        builder.AddSystem(self._diagram)
        self.wall = builder.AddSystem(Wall())
        self._age = builder.AddSystem(ConstantVectorSource([0.001]))
        builder.Connect(self._diagram.GetOutputPort("motion"), self.wall.GetInputPort("motion"))
        builder.Connect(self.wall.GetOutputPort("force"), self._diagram.GetInputPort("force"))
        builder.Connect(self._age.get_output_port(), self._diagram.GetInputPort("ages"))
        self.simulator = Simulator(builder.Build())
        self.simulator.Initialize()
        self.go(3)

    def go(self, ticks: int, each: Callable[[int], object] | None = None) -> Array:
        """So many ticks; `each` is called before each one. Gives what the motors did (ticks, 3) [N], device frame."""
        applied = np.empty((ticks, 3))
        for i in range(ticks):
            if each is not None:
                each(i)
            self.simulator.AdvanceTo(self.simulator.get_context().get_time() + PERIOD)
            self.omega.advance(PERIOD)
            applied[i] = self.omega.vector("applied")
        return applied

    def arm(self) -> bool:
        """A person presses the switch, and the force comes back; gives whether it does."""
        self.go(6)
        self.switch.arm()
        self.go(34)
        return bool(self.status[0])

    def set_age(self, age: float) -> None:
        """Age of the peer's latest packet [s]."""
        context = self._age.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self._age.get_mutable_source_value(context).SetFromVector([age])

    def _eval(self, system: System, port: str) -> Array:
        context = system.GetMyContextFromRoot(self.simulator.get_context())
        return np.array(system.GetOutputPort(port).Eval(context))

    @property
    def status(self) -> Array:
        """(6) of the supervisor."""
        return self._eval(self._diagram, "status")

    @property
    def motion(self) -> Array:
        """(6) of the hand, table frame."""
        return self._eval(self._diagram, "motion")

    @property
    def device(self) -> Array:
        """(3) of the driver."""
        return self._eval(self.operator, "device")

    def told(self) -> str:
        """The supervisor's status in words."""
        return describe(self.status, ("peer",))

    def close(self) -> None:
        """Give the device back."""
        self.operator.close()
