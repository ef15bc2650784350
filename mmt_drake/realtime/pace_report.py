"""The pace of a run, as signals of its diagram."""

from pydrake.systems.framework import BasicVector, Context

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
        self.set_name("PaceReport")
        self._pace = pace
        self.DeclareVectorOutputPort("lateness", 1, self._calc_lateness, {self.time_ticket()})
        self.DeclareVectorOutputPort("overruns", 1, self._calc_overruns, {self.time_ticket()})

    def _calc_lateness(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, self._pace.late)

    def _calc_overruns(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, float(self._pace.overruns))
