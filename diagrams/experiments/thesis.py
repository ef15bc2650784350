"""Experiments 1 and 3 of the thesis: what is run, and what was measured of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from mmt_drake.analysis.metrics import Metrics
from mmt_drake.diagrams.experiments.changes import NOISE, sensing
from mmt_drake.diagrams.experiments.runs import MeasuredRun, run_cases
from mmt_drake.diagrams.experiments.targets import (
    DELAY_COSTS,
    RENDERED,
    RENDERED_DELAYED,
    answered,
    bands,
    estimated,
    stable,
)
from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario, operator_name, updates_name
from mmt_drake.diagrams.studies.figures import Reached, to_json
from mmt_drake.diagrams.studies.study import Progress
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.regrouping import EQUATIONS
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import Recording

FREEZE_AFTER_S: Final = 5.0
"""Contact time [s] after which the parameters of figures 11 and 31 stand still."""

MAIN: Final = "thesis_rls_all"
"""The case that figures are drawn from: eq. 30 with all of its equations."""
FROZEN: Final = "frozen_5s"
"""The same with parameters frozen after `FREEZE_AFTER_S` of contact."""

SETTLE_S: Final = 0.5
"""Time [s] after each touch for which the estimator waits in the case below, while its filters settle."""
SETTLED: Final = "settled_0.5s"
"""Not the thesis's: nothing is learned while the filters still hold samples from before the touch."""

SECOND_DETECTOR: Final = "second_detector"
"""The same, and the renderer's model is switched by a second contact detector beside the operator, as the thesis
recommends."""
WITHOUT_DELAY: Final = "second_detector_no_delay"
"""The same without the delay, to compare with."""

OUTPUT_ERROR: Final = "output_error"
"""The estimator whose model runs freely in the place of the thesis's; with a delay the second detector beside it."""
OUTPUT_ERROR_WITHOUT_DELAY: Final = "output_error_no_delay"
"""The same without the delay, to compare with."""

DELAYED: Final = {SECOND_DETECTOR: WITHOUT_DELAY, OUTPUT_ERROR: OUTPUT_ERROR_WITHOUT_DELAY}
"""Cases that shall not feel the delay -> the same without it."""

NOT_THE_THESIS_S: Final = (FROZEN, SETTLED, *DELAYED, *DELAYED.values())
"""Cases that differ from it in more than how eq. 30 is solved."""


@dataclass(frozen=True)
class Plan:
    """One experiment of the thesis.

    Attributes:
        number: the thesis's.
        title: what it asks.
        scenario: name of the shipped scenario.
        figures: numbers of the thesis's figures -> case that is drawn.
    """

    number: int
    title: str
    scenario: str
    figures: dict[int, str]

    def cases(self, *, seed: int = 0, seconds: float | None = None, own_length: bool = False) -> dict[str, Scenario]:
        """Name of a case -> what is built for it.

        One per way of solving eq. 30, one that waits after each touch, one with the estimator whose model runs freely,
        and one frozen where it is drawn. With a delay the former has a second contact detector beside the operator and
        noise in its sensors, there is one more with that detector and the estimator that waits, and both are run
        without the delay too.

        Args:
            seed: of everything random.
            seconds: how long to run; the scenario's duration by default.
            own_length: the hand's recording says how long, unless `seconds` does.

        Raises:
            BadInput: seed or seconds out of range.
        """
        base = replace(load_scenario(self.scenario), seed=seed)
        if seconds is not None or own_length:
            base = replace(base, duration=seconds)
        made = {
            f"thesis_rls_{equations}": replace(base, estimator=replace(base.rls, equations=equations))
            for equations in EQUATIONS
        }
        made[SETTLED] = replace(base, estimator=replace(base.rls, settle=SETTLE_S))
        made[OUTPUT_ERROR] = replace(base, estimator=OutputErrorOptions())
        if base.to_telerobot != ChannelConfig():
            made[SECOND_DETECTOR] = replace(made[SETTLED], switching="operator")
            made[OUTPUT_ERROR] = sensing(NOISE)(replace(made[OUTPUT_ERROR], switching="operator"))
            for far, near in DELAYED.items():
                made[near] = replace(made[far], to_telerobot=ChannelConfig(), to_operator=ChannelConfig())
        if FROZEN in self.figures.values():
            made[FROZEN] = replace(base, estimator=replace(base.rls, freeze_after=FREEZE_AFTER_S))
        return made


_ONE = dict.fromkeys((8, 9, 10, 24, 25, 26, 27, 28, 29, 30), MAIN) | dict.fromkeys((11, 31), FROZEN)

PLANS: Final = {
    1: Plan(1, "Does the whole system work with a simulated object?", "setup1", dict(sorted(_ONE.items()))),
    3: Plan(3, "What does a delay of 400 ms each way do?", "setup1-delay", dict.fromkeys((14, 35), MAIN)),
}


def plan_of(number: int) -> Plan:
    """The plan of an experiment.

    Raises:
        BadInput: there is none of this number.
    """
    if number not in PLANS:
        raise BadInput("experiment", found=number, expected=" or ".join(map(str, PLANS)))
    return PLANS[number]


@dataclass(frozen=True)
class ExperimentResult:
    """All cases of one experiment.

    Attributes:
        number: the thesis's.
        scenario: name of the shipped scenario.
        seed: of everything random.
        operator: name of the scripted motion, or the recording that was replayed.
        cases: in the order of the plan.
    """

    number: int
    scenario: str
    seed: int
    operator: str
    cases: tuple[MeasuredRun, ...]

    def __getitem__(self, name: str) -> MeasuredRun:
        """The case of this name.

        Raises:
            BadInput: there is none.
        """
        for case in self.cases:
            if case.name == name:
                return case
        raise BadInput("experiment", at="case", found=name, expected=", ".join(case.name for case in self.cases))

    @property
    def metrics(self) -> dict[str, Metrics]:
        """Name of a case -> its figures."""
        return {case.name: case.metrics for case in self.cases}

    @property
    def settled(self) -> dict[str, Metrics]:
        """Name of a case -> its figures over the second half of the contact time."""
        return {case.name: case.settled for case in self.cases}

    def to_json(self) -> dict[str, Any]:
        """The document that `experiment --json` prints."""
        return {
            "experiment": self.number,
            "scenario": self.scenario,
            "seed": self.seed,
            "operator": self.operator,
            "cases": [case.to_json() for case in self.cases],
            "figures_to_reach": to_json(figures_to_reach(self)),
        }


def run_experiment(
    number: int,
    *,
    out: str | Path,
    operator: str | Path | Recording | None = None,
    seed: int = 0,
    seconds: float | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
) -> ExperimentResult:
    """Run every case of an experiment and measure it.

    Args:
        number: 1 or 3.
        out: folder for the recordings, `exp1_thesis_rls_all.mcap` and so on; made if need be.
        operator: a recording whose probe motion replaces the scripted strokes; then a run is as long as that.
        seed: of everything random.
        seconds: how long each run is; by default as long as the scenario or the operator's recording says.
        jobs: processes at work at the same time; the numbers do not depend on it. More than one need a script whose
            entry stands under `if __name__ == "__main__"`.
        progress: called with the number of cases done.

    Raises:
        BadInput: no such experiment, a recording that is none, a value out of range, a folder that cannot be made.
    """
    plan = plan_of(number)
    recording = operator if isinstance(operator, Recording | None) else load_operator(operator)
    scenarios = plan.cases(seed=seed, seconds=seconds, own_length=recording is not None)
    files = {name: Path(out) / f"exp{number}_{name}.mcap" for name in scenarios}
    cases = run_cases(scenarios, files, operator=recording, jobs=jobs, progress=progress)
    return ExperimentResult(number, plan.scenario, seed, operator_name(cases[0].scenario, recording), cases)


def figures_to_reach(result: ExperimentResult) -> list[Reached]:
    """The figures of every case of experiment 1 or 3."""
    found: list[Reached] = []
    names = {case.name for case in result.cases}
    delayed = any(case.metrics.delay_s > 0.0 for case in result.cases)
    for case in result.cases:
        name, metrics, updates = case.name, case.metrics, updates_name(case.scenario)
        targets = RENDERED_DELAYED if delayed else RENDERED
        found += bands(name, metrics.rendered_error_true, targets, updates=updates)
        found += estimated(name, metrics.estimated_error, updates=updates)
        found.append(stable(name, metrics, by_prior=name.startswith(OUTPUT_ERROR), updates=updates))
        if not delayed:
            continue
        found += answered(name, metrics, case.scenario.step, updates=updates)
        near = DELAYED.get(name)
        if near in names:
            ours, theirs = _off(case), _off(result[near])
            more = None if ours is None or theirs is None else abs(ours - theirs)
            found.append(Reached(name, DELAY_COSTS, more, None, updates))
    return found


def _off(case: MeasuredRun) -> float | None:
    """Error of the rendered force against the plant's without noise."""
    error = case.metrics.rendered_error_true
    return None if error is None else error.tangential["all"]
