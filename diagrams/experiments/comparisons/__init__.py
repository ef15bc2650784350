"""Comparisons beyond the thesis: runs of one motion that differ in one thing.

`COMPARISONS` has them by name; `run_comparison` runs and measures one, `write_comparison` leaves its page.
"""

from diagrams.experiments.comparisons.bands import BANDS
from diagrams.experiments.comparisons.comparison import Compared, Comparison, run_comparison, write_comparison
from diagrams.experiments.comparisons.estimators import ESTIMATORS, with_estimator
from diagrams.experiments.comparisons.network import NETWORK
from diagrams.experiments.comparisons.peers import PEERS
from diagrams.experiments.comparisons.updates import UPDATES

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
