"""Model-mediated, direct and passivity-controlled force feedback, on the same motion and the same network."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

from matplotlib.figure import Figure

from mmt_drake.analysis.hand import Settling, settling, tracking_error
from mmt_drake.analysis.page import Picture
from mmt_drake.analysis.passivity import Passivity, Returnable, passivity, returnable
from mmt_drake.analysis.plotting import legend_above, line, panels, shade, styled
from mmt_drake.analysis.table import Cell
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagrams.proof.experiments.changes import noisy
from mmt_drake.diagrams.proof.experiments.comparison import CaseFindings, Comparison, Findings, findings_of
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun
from mmt_drake.diagrams.proof.experiments.targets import (
    RENDERED,
    RENDERED_DELAYED,
    RENDERED_OTHER,
    REST,
    RETURNED,
    bands,
)
from mmt_drake.diagrams.proof.experiments.thesis import ESTIMATOR_OPTIONS
from mmt_drake.diagrams.proof.studies.study import Asked, Reached
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.renderers import DirectForce, ImpedanceReflection, Renderer
from mmt_drake.diagrams.stations.scenario import Scenario, updates_name
from mmt_drake.motion.along_axis import holding_since
from mmt_drake.motion.yielding import HandImpedance
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import Recording
from mmt_drake.rendering.passivity import PassivityControl
from mmt_drake.rendering.updates import EnergyPermitting


@styled
def hands(recordings: Mapping[str, Recording], still_from_s: float | None) -> Figure:
    """Height of the hand and force along the normal over time, one line per scheme.

    Args:
        recordings: what it was under -> the run; needs `master_position_z` and `rendered_force_z`.
        still_from_s: since when the hand means to hold still [s]; None: not known of this motion.
    """
    figure, grid = panels(2, 4.4)
    for name, recording in recordings.items():
        line(grid[0], recording.time, 1e3 * recording["master_position_z"], name)
        line(grid[1], recording.time, recording["rendered_force_z"], name)
    first = next(iter(recordings.values()))
    if still_from_s is not None:
        shade(grid, first.time, first.time >= still_from_s)
    grid[0].set(ylabel="height of the hand [mm]", title="Hand and force along the normal")
    grid[1].set(ylabel="rendered force [N]", xlabel="time [s]")
    grid[1].set_xlim(first.time[0], first.time[-1])
    legend_above(grid[0])
    return figure


_MOTION: Final = "stroke_and_hold"
STROKING_S: Final = 25.0
DURATION_S: Final = 60.0
"""Length of the hand's motion [s]; a run ends before its last lift."""
_UNTIL_S: Final = 59.0

_SCHEMES: Final[Mapping[str, Renderer]] = {
    "model": ImpedanceReflection(updates=EnergyPermitting(), in_plane="per_axis"),
    "direct": DirectForce(),
    "passivity": DirectForce(passivity=PassivityControl()),
}
_DELAYS: Final = {"no_delay": 0.0, "400ms": 0.4, "2500ms": 2.5}  # [s] each way
_LONGEST: Final = "2500ms"
_HAND: Final = HandImpedance()


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """Every scheme over every network with a hand that yields, and over the thesis's with one that does not."""
    motion = Scripted(_MOTION, {"duration": DURATION_S, "stroking": STROKING_S})
    base = noisy("setup1", seed=asked.seed, operator=motion, duration=asked.seconds or _UNTIL_S)
    made = {}
    for network, delay in _DELAYS.items():
        way = ChannelConfig(delay=delay)
        for hand in (None, _HAND) if network == "400ms" else (_HAND,):
            for scheme, renderer in _SCHEMES.items():
                name = f"{scheme}_{network}" if hand else f"{scheme}_{network}_stiff_hand"
                case = replace(base, to_telerobot=way, to_operator=way, hand=hand, renderer=renderer)
                if scheme == "model":  # the others have no use for these
                    case = replace(case, estimator=ESTIMATOR_OPTIONS["output_error"], switching="operator")
                made[name] = case
    return made


def judge(found: Cases) -> Findings:
    """Force error, energy balance, stability, and how far the telerobot is from the hand."""
    headers = ["case", "updates", "stable", "still moves at [mm/s]", "force error [%]", "z [%]", "energy put in [J]"]
    headers += ["given back too much [J]", "telerobot off by [mm]"]
    caption = (
        f"Stable: a hand that means to hold still from {holding_since(STROKING_S):g} s on does. Force error: rendered "
        "against the plant's without noise, in the operator's time, in contact, after the wind-up phase."
    )
    still = holding_since(STROKING_S) if all(case.operator == _MOTION for case in found.values()) else None
    shaded = "" if still is None else ": shaded where it means to hold still"
    pictures = [
        Picture(
            hands({scheme: found[f"{scheme}_{network}"].samples for scheme in _SCHEMES}, still),
            f"Height of a hand that yields, {1e3 * delay:g} ms each way{shaded}.",
            name=f"hands_{network}",
        )
        for network, delay in _DELAYS.items()
    ]
    return findings_of({name: _judged(case) for name, case in found.items()}, headers, caption, pictures=pictures)


def _judged(case: MeasuredRun) -> CaseFindings:
    recording, yields = case.samples, case.scenario.hand is not None
    settled, energy = _settling(case, recording), passivity(recording)
    balance = returnable(recording) if "stored_energy" in recording else None
    off, error = tracking_error(recording, case.metrics.delay_s), case.true_error
    figures: dict[str, Any] = {
        "hand": "yields" if yields else "stiff",
        "settling": None if settled is None else settled.to_json(),
        "energy": energy.to_json(),
        "tracking_error_m": off,
    }
    if balance is not None:
        figures["returnable"] = balance.to_json()
    still = settled if yields else None  # a stiff hand is at rest whatever it feels
    row: list[Cell] = [case.name, updates_name(case.scenario)]
    row += ["–", None] if still is None else ["yes" if still.stable else "NO", 1e3 * still.holding]
    row += [in_percent(error.tangential["all"]), in_percent(error.normal["all"])]
    return CaseFindings(
        [*row, energy.operator.put_in, energy.operator.violation, 1e3 * off],
        figures,
        _reached(case, still, energy, balance),
    )


def _settling(case: MeasuredRun, recording: Recording) -> Settling | None:
    """None for another motion, which holds still at another time if at all, or a run that ends too early."""
    if case.operator != _MOTION:
        return None
    since, until = holding_since(STROKING_S), min(float(recording.time[-1]), _UNTIL_S)
    return settling(recording, since, until) if until >= since + 10.0 else None


def _reached(case: MeasuredRun, still: Settling | None, energy: Passivity, balance: Returnable | None) -> list[Reached]:
    """The force, of which nothing is asked over the longest round trip; stability and energy, asked of that alone."""
    network = next(network for network in _DELAYS if network in case.name)
    targets = {"no_delay": RENDERED, "400ms": RENDERED_DELAYED, _LONGEST: RENDERED_OTHER}[network]
    back = 0.0 if energy.operator.passive else energy.operator.violation
    if balance is not None and not balance.holds:
        back = max(back, -balance.least)
    judged = [(RETURNED, back)]
    if still is not None:
        judged.append((REST, still.holding / still.moving))
    return bands(case.name, case.true_error, targets) + [
        Reached(case.name, target if network == _LONGEST else replace(target, to_reach=None), value)
        for target, value in judged
    ]


PEERS: Final = Comparison(
    name="peers",
    title="What does a model do that direct force feedback does not?",
    lead=(
        "Set-up 1, its sensors with noise, with a model beside the operator that takes up new parameters as energy "
        "permits, with the telerobot's force as it arrives, and with that force under time-domain passivity control; "
        "without delay, over 400 ms each way, and over a round trip of 5 s. The hand yields to what it feels like an "
        "arm on a device, or is stiff, so that all schemes see the same motion."
    ),
    cases=cases,
    judge=judge,
)
