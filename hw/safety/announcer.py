"""Tells a person what a supervisor or a device does."""

from collections.abc import Callable, Sequence

from pydrake.systems.framework import Context, DiscreteValues

from mmt_drake.hw.safety.reasons import describe
from mmt_drake.systems.leaf import LeafSystem


class SafetyAnnouncer(LeafSystem):
    """Says in words when a supervisor stops, why, and when it is armed again.

    .. pydrake_system::

        name: SafetyAnnouncer
        input_ports:
        - status

    - `status` (6): as on the port of `SafetySupervisor`.

    Args:
        tell: called with one line, in the thread that runs the diagram, whenever there is something new.
        watched: names of the supervisor's watched ages.
        period: of looking [s].
    """

    def __init__(self, tell: Callable[[str], None], watched: Sequence[str] = (), *, period: float = 0.02) -> None:
        super().__init__()
        self.set_name("SafetyAnnouncer")
        self._tell, self._watched = tell, tuple(watched)
        self._told: tuple[float, ...] = ()
        self._status = self.DeclareVectorInputPort("status", 6)
        # Not a publish event, which comes a period early and has everything computed twice.
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._look)

    def _look(self, context: Context, state: DiscreteValues) -> None:
        status = self._status.Eval(context)
        now = tuple(status[:3])  # what is limited comes and goes
        if now != self._told:
            self._told = now
            self._tell(f"{context.get_time():.2f} s: {describe(status, self._watched)}")


class DeviceAnnouncer(LeafSystem):
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
        period: of looking [s].
    """

    def __init__(
        self, tell: Callable[[str], None], name: str, describe: Callable[[float], str], *, period: float = 0.02
    ) -> None:
        super().__init__()
        self.set_name("DeviceAnnouncer")
        self._tell, self._name, self._describe = tell, name, describe
        self._told: float | None = None
        self._device = self.DeclareVectorInputPort("device", 3)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._look)

    def _look(self, context: Context, state: DiscreteValues) -> None:
        fault = float(self._device.Eval(context)[0])
        if fault != self._told:
            self._told = fault
            self._tell(f"{context.get_time():.2f} s: {self._name}: {self._describe(fault)}")
