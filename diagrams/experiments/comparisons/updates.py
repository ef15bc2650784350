"""How parameters are taken up: jumps of the force, energy, and what it costs in accuracy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from diagrams.experiments.comparisons.comparison import Cases, Comparison, Judgement, Recordings
from diagrams.experiments.plans import SETTLE_S
from diagrams.scenario import ImpedanceReflection, Scenario, load_scenario
from mmt_drake.analysis.jumps import Jumps, update_jumps
from mmt_drake.analysis.passivity import Returnable, returnable
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import percent, significant
from mmt_drake.recording import Recording
from mmt_drake.rendering.status import APPROACHING, RENDERING, STATUS_NAMES, WAITING
from mmt_drake.rendering.updates import AtOnce, Blended, EnergyPermitting, Policy, RateLimited

_POLICIES: Final[Mapping[str, Policy]] = {
    "at_once": AtOnce(),
    "rate_limited": RateLimited(),
    "blended": Blended(),
    "energy_permitting": EnergyPermitting(),
}


def cases(seed: int, seconds: float | None) -> Mapping[str, Scenario]:
    """Experiment 3 with each policy, and contact switched beside the operator or by the telerobot's late flag."""
    base = replace(load_scenario("setup1-delay"), seed=seed)
    base = replace(base, estimator=replace(base.rls, settle=SETTLE_S), duration=seconds or base.duration)
    made = {}
    for side in ("operator", "telerobot"):
        for name, policy in _POLICIES.items():
            if side == "operator" or name in ("at_once", "energy_permitting"):
                label = name if side == "operator" else f"{name}_late_flag"
                made[label] = replace(base, switching=side, renderer=ImpedanceReflection(updates=policy))
    return made


def judge(found: Cases, recordings: Recordings) -> Judgement:
    """Jumps that the updates make, the energy balance, the error, and what was passed over."""
    headers = ["policy", "first set's jump [N]", "largest later [N]", "large ones", "error [%]", "2nd half [%]"]
    headers += ["least energy balance [mJ]", "passed over [s]"]
    rows: list[list[Cell]] = []
    figures: dict[str, dict[str, object]] = {}
    sentences = []
    for name, case in found.items():
        recording = recordings[name]
        every, later = update_jumps(recording), update_jumps(recording, after_first=True)
        balance, statuses = returnable(recording), _seconds_by_status(recording)
        passed = sum(seconds for what, seconds in statuses.items() if what in _PASSED_OVER)
        errors = (error.rendered_error.tangential["all"] for error in (case.metrics, case.settled))
        row: list[Cell] = [name, every.largest, later.largest, later.large]
        rows.append(
            [*row, *(None if error is None else 100.0 * error for error in errors), 1e3 * balance.least, passed]
        )
        figures[name] = {
            "update_jumps": every.to_json(),
            "later_update_jumps": later.to_json(),
            "returnable": balance.to_json(),
            "renderer_status_s": statuses,
        }
        sentences.append(_told(name, every, later, balance))
    caption = (
        "A jump is the change of force that an update makes at one instant; large ones are above 5 % of the RMS force. "
        "The energy balance is what the hand has put in less what the model could give back: below 0 updates or late "
        "switches have made energy."
    )
    return Judgement(Table(headers, rows, caption), sentences, figures)


_PASSED_OVER = {name for code, name in STATUS_NAMES.items() if code not in (WAITING, RENDERING, APPROACHING)}


def _seconds_by_status(recording: Recording) -> dict[str, float]:
    """How long [s] the renderer was in each status."""
    codes, counts = np.unique(recording["renderer_status"], return_counts=True)
    step = float(recording.time[-1] - recording.time[0]) / (len(recording) - 1)
    return {STATUS_NAMES[float(code)]: step * int(count) for code, count in zip(codes, counts, strict=True)}


def _told(name: str, every: Jumps, later: Jumps, balance: Returnable) -> str:
    energy = (
        "no energy was made"
        if balance.holds
        else f"{significant(-1e3 * balance.least, 3)} mJ were made out of nothing, at {balance.least_at:.3f} s"
    )
    return (
        f"{name}: the first set changes the force by {significant(every.largest, 3)} N in one tick, later ones by "
        f"{significant(later.largest, 3)} N ({percent(later.ratio)} of the RMS force) at most; {energy}."
    )


UPDATES: Final = Comparison(
    name="updates",
    title="How should new parameters be taken up?",
    lead=(
        "Set-up 1 with 400 ms each way. Parameters are taken up at once, with a limited rate of the force, blended "
        "over a tenth of a second, or as far as the model has burnt energy before; the model is switched by a detector "
        "beside the operator or, as in the thesis, by the telerobot's flag, which comes late."
    ),
    cases=cases,
    judge=judge,
)
