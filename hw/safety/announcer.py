"""Tells a person what the supervisor does."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from hw.safety.reasons import describe


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
