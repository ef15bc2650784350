"""Policies of taking up parameters: jumps of the force, energy, and what they cost in accuracy."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from mmt_drake.analysis.jumps import update_jumps
from mmt_drake.analysis.passivity import returnable
from mmt_drake.analysis.table import Cell
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagrams.proof.experiments.changes import noisy, rendering
from mmt_drake.diagrams.proof.experiments.comparison import CaseFindings, Comparison, Findings, findings_of
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun, ratio_of
from mmt_drake.diagrams.proof.experiments.targets import ENERGY_MADE, RENDERED_DELAYED, UPDATE_JUMP, bands
from mmt_drake.diagrams.proof.experiments.thesis import ESTIMATOR_OPTIONS
from mmt_drake.diagrams.proof.studies.study import Asked, Reached
from mmt_drake.diagrams.stations.scenario import Scenario, updates_name
from mmt_drake.recording import Recording
from mmt_drake.rendering.status import APPROACHING, RENDERING, STATUS_NAMES, WAITING
from mmt_drake.rendering.updates import AtOnce, Blended, EnergyPermitting, Policy, RateLimited

_POLICIES: Final[Mapping[str, Policy]] = {
    "at_once": AtOnce(),
    "rate_limited": RateLimited(),
    "blended": Blended(),
    "energy_permitting": EnergyPermitting(),
}
_ESTIMATORS: Final = {"output_error": ESTIMATOR_OPTIONS["output_error"], "thesis": ESTIMATOR_OPTIONS["settled_rls"]}
_LATE: Final = ("at_once", "energy_permitting")
_LENGTH_S: Final = 30.0


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """Experiment 3 with each estimator and policy; and with the telerobot's flag, which comes late."""
    base = noisy("setup1-delay", seed=asked.seed, duration=asked.seconds or _LENGTH_S)
    made = {}
    for source, estimator in _ESTIMATORS.items():
        for name, policy in _POLICIES.items():
            case = rendering(updates=policy)(replace(base, estimator=estimator))
            made[f"{source}_{name}"] = replace(case, switching="operator")
            if source == "output_error" and name in _LATE:
                made[f"{source}_{name}_late_flag"] = replace(case, switching="telerobot")
    return made


def judge(found: Cases) -> Findings:
    """Jumps that the updates make, the energy balance, the error, and what was passed over."""
    headers = ["case", "updates", "largest jump [N]", "of RMS force [%]", "at [s]", "large ones", "error [%]"]
    headers += ["2nd half [%]", "least energy balance [mJ]", "passed over [s]"]
    caption = (
        "A jump is the change of force that an update makes at one instant; large ones are above 5 % of the RMS force. "
        "Error: of the rendered force against the plant's without noise. "
        "The energy balance is what the hand has put in less what the model could give back: below 0 updates or late "
        "switches have made energy."
    )
    return findings_of({name: _judged(case) for name, case in found.items()}, headers, caption)


def _judged(case: MeasuredRun) -> CaseFindings:
    jumps, balance = update_jumps(case.samples), returnable(case.samples)
    statuses, error = _seconds_by_status(case.samples), case.true_error
    row: list[Cell] = [case.name, updates_name(case.scenario)]
    row += [jumps.largest, in_percent(jumps.ratio), jumps.largest_at, jumps.large]
    row += [in_percent(ratio_of(each)) for each in (error, case.settled.rendered_error_true)]
    row += [1e3 * balance.least, sum(seconds for what, seconds in statuses.items() if what in _PASSED_OVER)]
    return CaseFindings(
        row,
        {"update_jumps": jumps.to_json(), "returnable": balance.to_json(), "renderer_status_s": statuses},
        [
            *bands(case.name, error, RENDERED_DELAYED),
            Reached(case.name, UPDATE_JUMP, jumps.ratio),
            Reached(case.name, ENERGY_MADE, 0.0 if balance.holds else -balance.least),
        ],
    )


_PASSED_OVER = {name for code, name in STATUS_NAMES.items() if code not in (WAITING, RENDERING, APPROACHING)}


def _seconds_by_status(recording: Recording) -> dict[str, float]:
    """How long [s] the renderer was in each status."""
    codes, counts = np.unique(recording["renderer_status"], return_counts=True)
    step = float(recording.time[-1] - recording.time[0]) / (len(recording) - 1)
    return {STATUS_NAMES[float(code)]: step * int(count) for code, count in zip(codes, counts, strict=True)}


UPDATES: Final = Comparison(
    name="updates",
    title="How should new parameters be taken up?",
    lead=(
        "Set-up 1 with noise and 400 ms each way, with parameters of the estimator whose model runs freely and of the "
        "thesis's, which waits after each touch. They are taken up at once, with a limited rate of the force, blended "
        "over a tenth of a second, or as far as the model has burnt energy before. The model is switched by a "
        "detector beside the operator or, as in the thesis, by the telerobot's flag, which comes late."
    ),
    cases=cases,
    judge=judge,
)
