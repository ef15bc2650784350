"""Tells a person what a supervisor or a device does."""

from collections.abc import Callable, Sequence

from pydrake.systems.framework import Context, DiscreteValues

from mmt_drake.hw.safety.reasons import describe
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.leaf import LeafSystem

_PERIOD = 0.02  # [s]


class _Announcer(LeafSystem):
    """Says something in words whenever what matters of an input is new."""

    def _announce(self, tell: Callable[[str], None], words: Callable[[Array], str], changing: int) -> None:
        """Look at the input now and then; its first `changing` numbers matter."""
        self._tell, self._words, self._changing = tell, words, changing
        self._said: tuple[float, ...] = ()
        # Not a publish event, which comes a period early and has everything computed twice.
        self.DeclarePeriodicDiscreteUpdateEvent(_PERIOD, 0.0, self._look)

    def _look(self, context: Context, state: DiscreteValues) -> None:
        (value,) = self.inputs_at(context)
        now = tuple(value[: self._changing])
        if now != self._said:
            self._said = now
            self._tell(f"{context.get_time():.2f} s: {self._words(value)}")


class SafetyAnnouncer(_Announcer):
    """Says in words when a supervisor stops, why, and when it is armed again.

    .. pydrake_system::

        name: SafetyAnnouncer
        input_ports:
        - status

    - `status` (6): as on the port of `SafetySupervisor`.

    Args:
        tell: called with one line, in the thread that runs the diagram, whenever there is something new.
        watched: names of the supervisor's watched ages.
    """

    def __init__(self, tell: Callable[[str], None], watched: Sequence[str] = ()) -> None:
        super().__init__()
        self.declare_inputs("status")
        self._announce(tell, lambda status: describe(status, watched), 3)  # what is limited comes and goes


class DeviceAnnouncer(_Announcer):
    """Says in words when a device's driver reports another fault than before, or none any more.

    .. pydrake_system::

        name: DeviceAnnouncer
        input_ports:
        - device

    - `device` (3): as a driver tells of itself: fault code, time of the latest reading [s], and a flag.

    Args:
        tell: called with one line, in the thread that runs the diagram, whenever there is something new.
        name: of the device.
        describe: a fault code in words.
    """

    def __init__(self, tell: Callable[[str], None], name: str, describe: Callable[[float], str]) -> None:
        super().__init__()
        self.declare_inputs("device")
        self._announce(tell, lambda device: f"{name}: {describe(float(device[0]))}", 1)
