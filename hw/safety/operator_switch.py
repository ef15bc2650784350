"""The arm switch and the emergency stop, as a person reaches them from a console, a browser or a button."""

import time
from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from mmt_drake.systems.leaf import LeafSystem


class OperatorSwitch(LeafSystem):
    """Two switches that any thread may turn, seen by the diagram within one period.

    A press of `arm` springs back by itself; a further press meanwhile opens it for one period first, so that it is seen
    as one. `stop` stays until `release`; while it is on, `arm` does nothing, nor does it before the run has begun:
    when the switches are read for the first time. A stop counts whenever it came.

    .. pydrake_system::

        name: OperatorSwitch
        output_ports:
        - switches

    - `switches` (2): arm and emergency stop, each 0 or 1.

    Args:
        period: of reading them [s].
        press: how long one press of the arm switch lasts [s].
        clock: for how long the arm switch stays pressed [s]; never set back.
        on_arm: called at each press, in the thread that presses: for a device that must be enabled by itself.
    """

    def __init__(
        self,
        *,
        period: float = 2e-3,
        press: float = 0.1,
        clock: Callable[[], float] = time.monotonic,
        on_arm: Callable[[], object] | None = None,
    ) -> None:
        super().__init__()
        self._clock, self._on_arm, self._press = clock, on_arm, press
        # Each is one assignment, which no other thread can see half done.
        self._pressed_until, self._stopped, self._presses = 0.0, False, 0
        self.DeclareStateOutputPort("switches", self.DeclareDiscreteState(2))
        self.DeclareDiscreteState(np.array([-1.0]))  # presses seen; below 0: it has not been looked yet
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._read)

    def arm(self) -> None:
        """Press the arm switch."""
        if self._stopped:
            return
        if self._on_arm is not None:
            self._on_arm()
        self._pressed_until = self._clock() + self._press
        self._presses += 1

    def stop(self) -> None:
        """Emergency stop; may be called from a signal handler."""
        self._stopped = True

    def release(self) -> None:
        """Undo the emergency stop; the force stays zero until somebody arms."""
        self._pressed_until, self._stopped = 0.0, False

    def _read(self, context: Context, state: DiscreteValues) -> None:
        switches, seen = state.get_mutable_value(0), state.get_mutable_value(1)
        if seen[0] < 0.0:
            self._pressed_until = 0.0
        again = switches[0] == 1.0 and self._presses != seen[0]
        seen[0] = self._presses
        switches[0] = float(self._clock() < self._pressed_until and not again)
        switches[1] = float(self._stopped)
