"""Experiments 1 and 3 of the thesis: what is run, and what is to be reached."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from mmt_drake.diagrams.proof.experiments import targets
from mmt_drake.diagrams.proof.experiments.changes import NOISE, at_once, sensing
from mmt_drake.diagrams.proof.experiments.runs import Cases
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.diagrams.stations.estimators import EstimatorOptions
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.regrouping import EQUATIONS
from mmt_drake.network.config import ChannelConfig

FREEZE_AFTER_S: Final = 5.0
"""Contact time [s] after which the parameters of figures 11 and 31 stand still."""

MAIN: Final = "thesis_rls_all"
"""The case that figures are drawn from: eq. 30 with all of its equations."""
FROZEN: Final = "frozen_5s"
"""The same with parameters frozen after `FREEZE_AFTER_S` of contact."""

SETTLE_S: Final = 0.5
"""Time [s] after each touch for which the estimator waits in the case below, while its filters settle."""
ESTIMATOR_OPTIONS: Final[Mapping[str, EstimatorOptions]] = {
    "thesis_rls": RlsOptions(),
    "settled_rls": RlsOptions(settle=SETTLE_S),
    "output_error": OutputErrorOptions(in_plane="per_axis"),
}
"""The estimators that are held beside each other, on the thesis's object: friction of each axis by itself."""

SETTLED: Final = "settled_0.5s"
"""Not the thesis's: nothing is learned while the filters still hold samples from before the touch."""

SECOND_DETECTOR: Final = "second_detector"
"""The same, and the renderer's model is switched by a second contact detector beside the operator, as the thesis
recommends."""
WITHOUT_DELAY: Final = "second_detector_no_delay"
"""The same without the delay, to compare with."""

OUTPUT_ERROR: Final = "output_error"
"""The estimator whose model runs freely instead of the thesis's; with a delay the second detector beside it."""
OUTPUT_ERROR_WITHOUT_DELAY: Final = "output_error_no_delay"
"""The same without the delay, to compare with."""

DELAYED: Final = {SECOND_DETECTOR: WITHOUT_DELAY, OUTPUT_ERROR: OUTPUT_ERROR_WITHOUT_DELAY}
"""Cases that shall not feel the delay -> the same without it."""

NOT_THE_THESIS_S: Final = (FROZEN, SETTLED, *DELAYED, *DELAYED.values())
"""Cases that differ from it in more than how eq. 30 is solved."""


_ONE = dict.fromkeys((8, 9, 10, 24, 25, 26, 27, 28, 29, 30), MAIN) | dict.fromkeys((11, 31), FROZEN)
FIGURES: Final = {1: dict(sorted(_ONE.items())), 3: dict.fromkeys((14, 35), MAIN)}
"""Experiment -> numbers of the thesis's figures -> case that is drawn."""
SCENARIOS: Final = {1: "setup1", 3: "setup1-delay"}


def thesis_cases(number: int, seed: int = 0, seconds: float | None = None) -> dict[str, Scenario]:
    """Name of a case of experiment 1 or 3 -> what is built for it.

    One per way of solving eq. 30, one that waits after each touch, one with the estimator whose model runs freely,
    and one frozen where it is drawn. With a delay the former has a second contact detector beside the operator and
    noise in its sensors, there is one more with that detector and the estimator that waits, and both are run
    without the delay too.

    Args:
        number: 1 or 3.
        seed: of everything random.
        seconds: how long to run; the scenario's duration by default.

    Raises:
        BadInput: seed or seconds out of range.
    """
    base = replace(at_once(SCENARIOS[number]), seed=seed)
    if seconds is not None:
        base = replace(base, duration=seconds)
    made = {
        f"thesis_rls_{equations}": replace(base, estimator=replace(base.rls, equations=equations))
        for equations in EQUATIONS
    }
    made[SETTLED] = replace(base, estimator=replace(base.rls, settle=SETTLE_S))
    made[OUTPUT_ERROR] = replace(base, estimator=ESTIMATOR_OPTIONS["output_error"])
    if base.to_telerobot != ChannelConfig():
        made[SECOND_DETECTOR] = replace(made[SETTLED], switching="operator")
        made[OUTPUT_ERROR] = sensing(NOISE)(replace(made[OUTPUT_ERROR], switching="operator"))
        for far, near in DELAYED.items():
            made[near] = replace(made[far], to_telerobot=ChannelConfig(), to_operator=ChannelConfig())
    if FROZEN in FIGURES[number].values():
        made[FROZEN] = replace(base, estimator=replace(base.rls, freeze_after=FREEZE_AFTER_S))
    return made


def figures_to_reach(cases: Cases) -> list[Reached]:
    """The figures of every case of experiment 1 or 3."""
    found: list[Reached] = []
    delayed = any(case.metrics.delay_s > 0.0 for case in cases.values())
    rendered = targets.RENDERED_DELAYED if delayed else targets.RENDERED
    for name, case in cases.items():
        metrics = case.metrics
        found += targets.bands(name, case.true_error, rendered)
        found += targets.estimated(name, metrics.estimated_error)
        found.append(targets.stable(name, metrics, by_prior=name.startswith(OUTPUT_ERROR)))
        if delayed:
            found += targets.answered(name, metrics, case.scenario.step)
            if DELAYED.get(name) in cases:
                more = case.further_off(cases[DELAYED[name]])
                found.append(Reached(name, targets.DELAY_COSTS, None if more is None else abs(more)))
    return found
