"""A play-out buffer against jitter, loss and reordering."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from mmt_drake.analysis.jumps import jumps_beside
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagrams.proof.experiments.changes import noisy, rendering
from mmt_drake.diagrams.proof.experiments.comparison import CaseFindings, Comparison, Findings, findings_of
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun
from mmt_drake.diagrams.proof.experiments.targets import BUFFER_COSTS, JUMP, PLANT_JUMP
from mmt_drake.diagrams.proof.experiments.thesis import ESTIMATOR_OPTIONS
from mmt_drake.diagrams.proof.studies.study import Asked, Reached
from mmt_drake.diagrams.stations.scenario import Scenario, updates_name
from mmt_drake.network.config import ChannelConfig
from mmt_drake.rendering.updates import RateLimited

DELAY_S: Final = 0.12
PLAYOUT_S: Final = 0.2
"""Time from sending to playing [s]: the latest packets but those held back twice are there, and their followers."""

ROUGH: Final = ChannelConfig(delay=DELAY_S, jitter=0.04, loss=0.1, reordering=0.05, reordering_delay=0.02)
"""Uniform jitter of 40 ms, a tenth lost, one of twenty held back by another 20 ms."""

_WAYS: Final = {
    "constant_120ms": ChannelConfig(delay=DELAY_S),
    "newest_wins": ROUGH,
    "constant_200ms": ChannelConfig(delay=PLAYOUT_S),
    "playout_200ms": replace(ROUGH, playout=PLAYOUT_S),
}
_BESIDE: Final = {"newest_wins": "constant_120ms", "playout_200ms": "constant_200ms"}
"""A network -> the one without jitter and loss that it is held against."""

_LENGTH_S: Final = 40.0


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """Set-up 1 over each network, contact switched beside the operator, no update of the parameters felt as a jump."""
    base = noisy("setup1", seed=asked.seed, duration=asked.seconds or _LENGTH_S, switching="operator")
    base = rendering(updates=RateLimited())(replace(base, estimator=ESTIMATOR_OPTIONS["output_error"]))
    return {name: replace(base, to_telerobot=way, to_operator=way) for name, way in _WAYS.items()}


def judge(found: Cases) -> Findings:
    """Errors, and jumps of the rendered force and of the plant's that the constant delay does not have."""
    headers = ["network", "updates", *(f"{name} [%]" for name in BAND_NAMES.values()), "z [%]"]
    headers += ["more than constant [points]", "rendered jump [% of RMS]", "plant's jump [% of RMS]"]
    caption = (
        "Error of the rendered force against the plant's without noise, in contact, after the wind-up phase. A jump is "
        "a change within one tick that the run at constant delay does not have."
    )
    return findings_of({name: _judged(case, found) for name, case in found.items()}, headers, caption)


def _judged(case: MeasuredRun, found: Cases) -> CaseFindings:
    error, beside = case.true_error, _BESIDE.get(case.name)
    row: list[Cell] = [case.name, updates_name(case.scenario), *(in_percent(error.tangential[b]) for b in BAND_NAMES)]
    row.append(in_percent(error.normal["all"]))
    if beside is None:
        return CaseFindings([*row, None, None, None])
    more = case.further_off(found[beside])
    rendered, plant = (
        jumps_beside(case.samples, found[beside].samples, force) for force in ("rendered_force", "true_force")
    )
    figures = {
        "beside": beside,
        "more_error": more,
        "rendered_jumps": rendered.to_json(),
        "plant_jumps": plant.to_json(),
    }
    judged = ((BUFFER_COSTS, more), (JUMP, rendered.ratio), (PLANT_JUMP, plant.ratio))
    return CaseFindings(
        [*row, *(in_percent(value) for _, value in judged)],
        figures,
        [Reached(case.name, target, value) for target, value in judged],
    )


NETWORK: Final = Comparison(
    name="network",
    title="Does a play-out buffer make a rough network as good as a constant delay?",
    lead=(
        "Set-up 1, its sensors with noise, over 120 ms, uniform +- 40 ms, 10 % loss and 5 % reordering both ways: the "
        "newest packet wins, or a play-out buffer of 200 ms with interpolation. Beside each the constant delay that "
        "it should be as good as. Parameters come from the estimator whose model runs freely and are taken up with a "
        "limited rate of the force."
    ),
    cases=cases,
    judge=judge,
)
