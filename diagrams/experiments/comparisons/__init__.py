"""Comparisons beyond the thesis: runs of one motion that differ in one thing; `COMPARISONS` has them by name."""

from typing import Final

from mmt_drake.diagrams.experiments.comparison import study_of_runs
from mmt_drake.diagrams.experiments.comparisons.bands import BANDS
from mmt_drake.diagrams.experiments.comparisons.estimators import ESTIMATORS
from mmt_drake.diagrams.experiments.comparisons.network import NETWORK
from mmt_drake.diagrams.experiments.comparisons.peers import PEERS
from mmt_drake.diagrams.experiments.comparisons.updates import UPDATES
from mmt_drake.diagrams.studies.study import OF_A_RUN

COMPARISONS = {comparison.name: comparison for comparison in (ESTIMATORS, NETWORK, UPDATES, PEERS, BANDS)}

_ELSEWHERE: Final = {"estimators": ("seconds", "seed", "estimator"), "bands": ("seconds", "seed")}
"""Their cases differ in their motion."""
STUDIES: Final = {
    name: study_of_runs(comparison, _ELSEWHERE.get(str(name), OF_A_RUN)) for name, comparison in COMPARISONS.items()
}
