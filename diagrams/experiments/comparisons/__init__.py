"""Comparisons beyond the thesis: runs of one motion that differ in one thing.

`COMPARISONS` has them by name; `run_comparison` runs and measures one, `report` leaves its page.
"""

from typing import Final

from mmt_drake.diagrams.experiments.comparisons.bands import BANDS
from mmt_drake.diagrams.experiments.comparisons.comparison import Comparison, report_of, run_comparison
from mmt_drake.diagrams.experiments.comparisons.estimators import ESTIMATORS, with_estimator
from mmt_drake.diagrams.experiments.comparisons.network import NETWORK
from mmt_drake.diagrams.experiments.comparisons.peers import PEERS
from mmt_drake.diagrams.experiments.comparisons.updates import UPDATES
from mmt_drake.diagrams.studies.study import OF_A_RUN, Asked, Progress, Report, Study

COMPARISONS = {comparison.name: comparison for comparison in (ESTIMATORS, NETWORK, UPDATES, PEERS, BANDS)}


def chosen(name: str, estimator: str | None = None) -> Comparison:
    """The comparison of this name, of one estimator alone where that is named."""
    return COMPARISONS[name] if estimator is None else with_estimator(COMPARISONS[name], estimator)


def _study(name: str, takes: tuple[str, ...] = OF_A_RUN) -> Study:
    def steps(asked: Asked) -> float:
        return len(chosen(name, asked.estimator).cases(asked.seed, asked.seconds))

    def run(asked: Asked, progress: Progress) -> Report:
        return report_of(run_comparison(chosen(name, asked.estimator), **asked.of_a_run(), progress=progress))

    return Study(f"{name}, runs", takes, steps, run)


_ELSEWHERE: Final = {"estimators": ("seconds", "seed", "estimator"), "bands": ("seconds", "seed")}
"""Their cases differ in their motion."""
STUDIES: Final = {name: _study(name, _ELSEWHERE.get(name, OF_A_RUN)) for name in COMPARISONS}
