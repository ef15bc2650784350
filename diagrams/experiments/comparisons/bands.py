"""A second, variable-spring model for high frequencies: where it wins."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from mmt_drake.analysis import charts
from mmt_drake.analysis.metrics import TELLING
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent, percent
from mmt_drake.diagrams.experiments.changes import NOISE, sensing, touching
from mmt_drake.diagrams.experiments.comparison import Cases, Comparison, ComparisonFindings, Recordings
from mmt_drake.diagrams.experiments.targets import RENDERED, RENDERED_OTHER, bands
from mmt_drake.diagrams.experiments.thesis import SETTLE_S
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.renderers import FusedReflection, ImpedanceReflection, Renderer
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario, updates_name
from mmt_drake.diagrams.studies.figures import Target
from mmt_drake.effects import LIBRARY
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import BoxParameters
from mmt_drake.rendering.high_band import HighBand

_RENDERERS: Final[Mapping[str, Renderer]] = {
    "model": ImpedanceReflection(),
    "spring": FusedReflection(high_band=HighBand(damper=False)),
    "spring_damper": FusedReflection(high_band=HighBand(damper=True)),
}
_HIGH: Final = "3_to_10_hz"

_SITUATIONS: Final[Mapping[str, str]] = {
    "best_model": "A chirp to 10 Hz, and the estimator whose model runs freely.",
    "settled_model": "Strokes, and the thesis's estimator, waiting after each touch.",
    "poor_model": "The chirp, and the thesis's estimator, which learns from the touch.",
    "lively_object": "The chirp on an object that is a spring above its mode at 6 Hz; that estimator, waiting.",
    "left_out": "The chirp on an object that relaxes, which no model of this structure can; as the first.",
}

_OTHER_OBJECTS: Final = ("lively_object", "left_out")

_LIVELY: Final = BoxParameters(m=1.0, k1=0.0, k2=1500.0, b1=5.0, b2=2.0)
"""An object that is a spring above its mode at 6 Hz; the thesis's is a damper there."""
_RELAXING: Final = ("viscoelastic_relaxation", {"k_maxwell": 500.0, "tau": 0.03})
"""What the object has beside its contact spring, and its models have not."""
_LENGTH_S: Final = 40.0


def cases(seed: int, seconds: float | None) -> Mapping[str, Scenario]:
    """Each situation with the first model alone and with a second one fused in."""
    base, length = load_scenario("setup1"), seconds or _LENGTH_S
    base = replace(base, seed=seed, duration=length, operator=Scripted("chirp", {"duration": length}))
    base = sensing(NOISE)(base)
    best, waiting = replace(base, estimator=OutputErrorOptions()), replace(base, estimator=RlsOptions(settle=SETTLE_S))
    effect, values = _RELAXING
    scenarios = (
        best,
        replace(waiting, operator=Scripted("strokes")),
        base,
        touching(lambda thing: replace(thing, parameters=_LIVELY))(waiting),
        touching(lambda thing: LIBRARY[effect].apply(thing, values))(best),
    )
    situations = dict(zip(_SITUATIONS, scenarios, strict=True))
    return {
        f"{situation}_{name}": replace(scenario, renderer=renderer)
        for situation, scenario in situations.items()
        for name, renderer in _RENDERERS.items()
    }


def judge(found: Cases, recordings: Recordings) -> ComparisonFindings:
    """Errors by band, against the force without noise."""
    errors = {
        name: case.metrics.rendered_error_true
        for name, case in found.items()
        if case.metrics.rendered_error_true is not None
    }
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values())]
    rows: list[list[Cell]] = []
    for name, error in errors.items():
        ratios = (error.tangential[band] if band in error.telling else None for band in BAND_NAMES)
        rows.append([name, *map(in_percent, ratios)])
    sentences, pictures = [], {}
    for situation in _SITUATIONS:
        here = {renderer: errors[f"{situation}_{renderer}"] for renderer in _RENDERERS}
        alone, *others = (error.tangential[_HIGH] if _HIGH in error.telling else None for error in here.values())
        for second, ratio in zip(list(_RENDERERS)[1:], others, strict=True):
            sentences.append(_told(situation, alone, second, ratio))
        title = f"Error of the rendered force: {situation.replace('_', ' ')}"
        pictures[situation] = (charts.error_bars(here, title=title), _SITUATIONS[situation])
    caption = (
        "Error of the rendered force against the plant's, in contact, after the wind-up phase, in bands that hold "
        f"{percent(TELLING)} of the force."
    )
    reached = [
        figure
        for name, error in errors.items()
        for figure in bands(name, error, _targets(name), updates=updates_name(found[name].scenario))
    ]
    return ComparisonFindings([Table(headers, rows, caption)], sentences, reached, pictures=pictures)


def _targets(case: str) -> Mapping[str, Target]:
    """Nothing is asked of an object that is not the thesis's."""
    return RENDERED_OTHER if case.startswith(_OTHER_OBJECTS) else RENDERED


def _told(situation: str, alone: float | None, second: str, fused: float | None) -> str:
    verdict = "is not known to win"
    if alone is not None and fused is not None:
        verdict = "wins" if fused < alone else "does not win"
    return (
        f"{situation}, 3 to 10 Hz: {percent(alone)} off with the first model alone, {percent(fused)} with a "
        f"{second.replace('_', ' and ')} fused in, which {verdict}."
    )


BANDS: Final = Comparison(
    name="bands",
    title="Does a second model help at high frequencies?",
    lead=(
        "Set-up 1 with sensor noise, rendered by the thesis's model alone, and with a variable spring, or a spring and "
        "damper, fused in above 3 Hz as far as it predicts the measured force better."
    ),
    cases=cases,
    judge=judge,
)
