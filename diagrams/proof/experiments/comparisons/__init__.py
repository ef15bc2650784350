"""Comparisons beyond the thesis: runs that differ in one thing; `COMPARISONS` has them by name."""

from mmt_drake.diagrams.proof.experiments.comparisons.any_surface import SURFACES
from mmt_drake.diagrams.proof.experiments.comparisons.bands import BANDS
from mmt_drake.diagrams.proof.experiments.comparisons.estimators import ESTIMATORS
from mmt_drake.diagrams.proof.experiments.comparisons.network import NETWORK
from mmt_drake.diagrams.proof.experiments.comparisons.peers import PEERS
from mmt_drake.diagrams.proof.experiments.comparisons.plants import COMPARED_PLANTS
from mmt_drake.diagrams.proof.experiments.comparisons.updates import UPDATES

_ALL = (ESTIMATORS, COMPARED_PLANTS, NETWORK, UPDATES, PEERS, BANDS, SURFACES)
COMPARISONS = {comparison.name: comparison for comparison in _ALL}
STUDIES = {name: comparison.study for name, comparison in COMPARISONS.items()}
