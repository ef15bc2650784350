"""The pace of a run, as signals of its diagram."""

from mmt_drake.realtime.pace import Pace
from mmt_drake.systems.leaf import LeafSystem


class PaceReport(LeafSystem):
    """Shows how a paced run keeps to the wall clock, so that it can be recorded and watched.

    .. pydrake_system::

        name: PaceReport
        output_ports:
        - lateness
        - overruns

    - `lateness` (1): how long after it was due the present tick began [s].
    - `overruns` (1): how many ticks before it were not done when the next was due.

    The pace is outside the Context, as the wall clock is.

    Args:
        pace: that `advance_paced` keeps.
    """

    def __init__(self, pace: Pace) -> None:
        super().__init__()
        self.declare_function("lateness", 1, lambda t: pace.late)
        self.declare_function("overruns", 1, lambda t: float(pace.overruns))
