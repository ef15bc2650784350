"""What is run in each experiment: scenarios, and which of the thesis's figures they answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from mmt_drake.diagrams.experiments.changes import NOISE, sensing
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.errors import BadInput
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
