"""A play-out buffer against jitter, loss and reordering."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from mmt_drake.analysis.jumps import Jumps, jumps_beside
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent, percent
from mmt_drake.diagrams.experiments.changes import NOISE, sensing
from mmt_drake.diagrams.experiments.comparison import Cases, Comparison, ComparisonFindings, Recordings
from mmt_drake.diagrams.experiments.findings import normal_of, ratio_of
from mmt_drake.diagrams.experiments.targets import BUFFER_COSTS, JUMP, PLANT_JUMP
from mmt_drake.diagrams.stations.renderers import ImpedanceReflection
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario, updates_name
from mmt_drake.diagrams.studies.figures import Reached
from mmt_drake.estimation.output_error.options import OutputErrorOptions
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


def cases(seed: int, seconds: float | None) -> Mapping[str, Scenario]:
    """Set-up 1 over each network, contact switched beside the operator, no update of the parameters felt as a jump."""
    base = replace(load_scenario("setup1"), seed=seed, switching="operator", duration=seconds or _LENGTH_S)
    base = replace(base, estimator=OutputErrorOptions(), renderer=ImpedanceReflection(updates=RateLimited()))
    base = sensing(NOISE)(base)
    return {name: replace(base, to_telerobot=way, to_operator=way) for name, way in _WAYS.items()}


def judge(found: Cases, recordings: Recordings) -> ComparisonFindings:
    """Errors, and jumps of the rendered force and of the plant's that the constant delay does not have."""
    headers = ["network", "updates", *(f"{name} [%]" for name in BAND_NAMES.values()), "z [%]"]
    headers += ["more than constant [points]", "rendered jump [% of RMS]", "plant's jump [% of RMS]"]
    rows: list[list[Cell]] = []
    figures: dict[str, dict[str, object]] = {}
    sentences, reached = [], []
    for name, case in found.items():
        row: list[Cell] = [name, updates_name(case.scenario)]
        row += [in_percent(ratio_of(case.metrics.rendered_error_true, band)) for band in BAND_NAMES]
        row.append(in_percent(normal_of(case.metrics.rendered_error_true)))
        if name in _BESIDE:
            beside = _BESIDE[name]
            more = _more(found, name, beside)
            jumps = {
                force: jumps_beside(recordings[name], recordings[beside], force)
                for force in ("rendered_force", "true_force")
            }
            row += [in_percent(more), *(in_percent(jump.ratio) for jump in jumps.values())]
            figures[name] = {
                "beside": beside,
                "more_error": more,
                "rendered_jumps": jumps["rendered_force"].to_json(),
                "plant_jumps": jumps["true_force"].to_json(),
            }
            sentences.append(_told(name, beside, more, jumps["rendered_force"], jumps["true_force"]))
            reached += [
                Reached(name, target, value, updates=updates_name(case.scenario))
                for target, value in (
                    (BUFFER_COSTS, more),
                    (JUMP, jumps["rendered_force"].ratio),
                    (PLANT_JUMP, jumps["true_force"].ratio),
                )
            ]
        else:
            row += [None, None, None]
        rows.append(row)
    caption = (
        "Error of the rendered force against the plant's without noise, in contact, after the wind-up phase. A jump is "
        "a change within one tick that the run at constant delay does not have."
    )
    return ComparisonFindings([Table(headers, rows, caption)], sentences, reached, figures)


def _more(found: Cases, name: str, beside: str) -> float | None:
    """By how much an error is larger than another, both ratios."""
    ours, theirs = (ratio_of(found[case].metrics.rendered_error_true) for case in (name, beside))
    return None if ours is None or theirs is None else ours - theirs


def _told(name: str, beside: str, more: float | None, rendered: Jumps, plant: Jumps) -> str:
    points = "by an unknown amount" if more is None else f"{100.0 * more:+.3g} percentage points"
    most, jump = (percent(target.to_reach) for target in (BUFFER_COSTS, JUMP))
    return (
        f"{name}: the rendered force is {points} further off than at {beside} (to reach: at most {most}). Its largest "
        f"jump beside that run is {percent(rendered.ratio)} of the RMS force (to reach: at most {jump}), the plant's "
        f"{percent(plant.ratio)}."
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
