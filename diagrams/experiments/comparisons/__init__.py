"""Comparisons beyond the thesis: runs of one motion that differ in one thing.

`COMPARISONS` has them by name; `run_comparison` runs and measures one, `report` leaves its page.
"""

from mmt_drake.diagrams.experiments.comparisons.bands import BANDS
from mmt_drake.diagrams.experiments.comparisons.comparison import Compared, Comparison, report_of, run_comparison
from mmt_drake.diagrams.experiments.comparisons.estimators import ESTIMATORS, with_estimator
from mmt_drake.diagrams.experiments.comparisons.network import NETWORK
from mmt_drake.diagrams.experiments.comparisons.peers import PEERS
from mmt_drake.diagrams.experiments.comparisons.updates import UPDATES

COMPARISONS = {comparison.name: comparison for comparison in (ESTIMATORS, NETWORK, UPDATES, PEERS, BANDS)}


def chosen(name: str, estimator: str | None = None) -> Comparison:
    """The comparison of this name, of one estimator alone where that is named."""
    return COMPARISONS[name] if estimator is None else with_estimator(COMPARISONS[name], estimator)


__all__ = [
    "COMPARISONS",
    "ESTIMATORS",
    "Compared",
    "Comparison",
    "chosen",
    "report_of",
    "run_comparison",
    "with_estimator",
]
