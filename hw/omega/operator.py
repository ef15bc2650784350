"""The operator's hand on a haptic device, with the ports of a simulated hand."""

import time
from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, State

from mmt_drake.closing import Closing
from mmt_drake.hw.omega.driver import OmegaDriver
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.systems.leaf import LeafSystem


class OmegaOperator(LeafSystem, Closing):
    """A person's hand on a Force Dimension device.

    At each tick the device is read *before* any other system is updated (an unrestricted update comes first in a step
    of Drake's), so the force sent at the end of that tick answers the motion read at its start: no tick lies between.

    The driver limits force and fails to zero by itself (`OmegaDriver`); if ticks stop coming, the device's own watchdog
    turns it off; and it is brought to rest when this system is closed, at the latest when Python collects it with its
    diagram, some time after the last reference went, or the program ends. It takes a force as it comes otherwise: put a
    `SafetySupervisor` before it (`mmt_drake.hw.safety.supervised`).

    .. pydrake_system::

        name: OmegaOperator
        input_ports:
        - force
        output_ports:
        - motion
        - device

    Ports:

    - `force` (3): rendered force [N], table frame.
    - `motion` (6): position [m] and velocity [m/s] of the hand, table frame; where it was last while a reading fails.
    - `device` (3): fault code (0: well; else `describe_fault`), time of the latest reading [s] by a clock that is never
      set, and 1 while the clutch holds the position (else 0).

    The device, and what its driver knows, is outside the Context: a cloned Context shares it.

    Args:
        settings: which device, and how it lies on the table.
        period: of the ticks [s].
        clock: of the readings [s].

    Raises:
        MissingDependency, DeviceError: as `OmegaDevice`.
    """

    def __init__(
        self,
        settings: OmegaSettings | None = None,
        *,
        period: float = 1e-3,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self._driver = driver = OmegaDriver(settings, clock)
        #: The device itself, for its name, pose and what it says about forces.
        self.device = driver.device
        (self._force,) = self.declare_inputs("force")
        self.DeclareStateOutputPort("motion", self.DeclareDiscreteState(driver.motion))
        self.DeclareStateOutputPort("device", self.DeclareDiscreteState(driver.state))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._read)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._send)

    def request_forces(self) -> None:
        """Have the device's motors turned on again after it turned them off; a person's decision, from any thread."""
        self._driver.request_forces()

    def close(self) -> None:
        """Bring the device to rest; ticks after that report a fault."""
        self._driver.close()

    def _read(self, context: Context, state: State) -> None:
        self._driver.read()
        values = state.get_mutable_discrete_state()
        values.get_mutable_value(0)[:] = self._driver.motion
        values.get_mutable_value(1)[:] = self._driver.state

    def _send(self, context: Context, state: DiscreteValues) -> None:
        try:
            force = self._force.Eval(context)
        except BaseException:  # whatever it is, and Ctrl-C too: no force stays on while it is dealt with
            self._driver.send(np.zeros(3))
            raise
        self._driver.send(force)
