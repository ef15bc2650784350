"""Comparisons beyond the thesis: runs that differ in one thing; `COMPARISONS` has them by name."""

from mmt_drake.diagrams.proof.experiments.comparisons.bands import BANDS
from mmt_drake.diagrams.proof.experiments.comparisons.estimators import ESTIMATORS
from mmt_drake.diagrams.proof.experiments.comparisons.network import NETWORK
from mmt_drake.diagrams.proof.experiments.comparisons.peers import PEERS
from mmt_drake.diagrams.proof.experiments.comparisons.updates import UPDATES

COMPARISONS = {comparison.name: comparison for comparison in (ESTIMATORS, NETWORK, UPDATES, PEERS, BANDS)}
STUDIES = {name: comparison.study for name, comparison in COMPARISONS.items()}
