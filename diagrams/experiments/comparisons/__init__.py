"""Comparisons beyond the thesis: runs of one motion that differ in one thing.

`COMPARISONS` has them by name; `run_comparison` runs and measures one, `write_comparison` leaves its page.
"""

from mmt_drake.diagrams.experiments.comparisons.bands import BANDS
from mmt_drake.diagrams.experiments.comparisons.comparison import Compared, Comparison, run_comparison, write_comparison
from mmt_drake.diagrams.experiments.comparisons.estimators import ESTIMATORS, with_estimator
from mmt_drake.diagrams.experiments.comparisons.network import NETWORK
from mmt_drake.diagrams.experiments.comparisons.peers import PEERS
from mmt_drake.diagrams.experiments.comparisons.updates import UPDATES

COMPARISONS = {comparison.name: comparison for comparison in (ESTIMATORS, NETWORK, UPDATES, PEERS, BANDS)}

__all__ = [
    "COMPARISONS",
    "ESTIMATORS",
    "Compared",
    "Comparison",
    "run_comparison",
    "with_estimator",
    "write_comparison",
]
