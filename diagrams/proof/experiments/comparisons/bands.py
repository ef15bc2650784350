"""A second, variable-spring model for high frequencies: where it wins."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from mmt_drake.analysis import charts
from mmt_drake.analysis.metrics import TELLING, ForceError
from mmt_drake.analysis.page import Picture
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.wording import in_percent, percent
from mmt_drake.diagrams.proof.experiments.changes import noisy, touching
from mmt_drake.diagrams.proof.experiments.comparison import CaseFindings, Comparison, Findings, findings_of
from mmt_drake.diagrams.proof.experiments.runs import Cases
from mmt_drake.diagrams.proof.experiments.targets import RENDERED, RENDERED_OTHER, bands
from mmt_drake.diagrams.proof.experiments.thesis import ESTIMATOR_OPTIONS
from mmt_drake.diagrams.proof.studies.study import Asked
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.renderers import FusedReflection, ImpedanceReflection, Renderer
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.effects import LIBRARY
from mmt_drake.model.parameters import BoxParameters
from mmt_drake.rendering.high_band import HighBand

_RENDERERS: Final[Mapping[str, Renderer]] = {
    "model": ImpedanceReflection(in_plane="per_axis"),
    "spring": FusedReflection(high_band=HighBand(damper=False), in_plane="per_axis"),
    "spring_damper": FusedReflection(high_band=HighBand(damper=True), in_plane="per_axis"),
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


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """Each situation with the first model alone and with a second one fused in."""
    length = asked.seconds or _LENGTH_S
    base = noisy("setup1", seed=asked.seed, duration=length, operator=Scripted("chirp", {"duration": length}))
    best, waiting = (replace(base, estimator=ESTIMATOR_OPTIONS[name]) for name in ("output_error", "settled_rls"))
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


def judge(found: Cases) -> Findings:
    """Errors by band, against the force without noise."""
    errors = {name: case.true_error for name, case in found.items()}
    sentences, pictures = [], []
    for situation, what in _SITUATIONS.items():
        here = {renderer: errors[f"{situation}_{renderer}"] for renderer in _RENDERERS}
        alone, *others = (_telling(error, _HIGH) for error in here.values())
        fused = zip(list(_RENDERERS)[1:], others, strict=True)
        sentences += [_sentence(situation, alone, second, ratio) for second, ratio in fused]
        title = f"Error of the rendered force: {situation.replace('_', ' ')}"
        pictures.append(Picture(charts.error_bars(here, title=title), what, name=situation))
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values())]
    caption = (
        "Error of the rendered force against the plant's, in contact, after the wind-up phase, in bands that hold "
        f"{percent(TELLING)} of the force."
    )
    each = {
        name: CaseFindings(
            [name, *(in_percent(_telling(error, band)) for band in BAND_NAMES)],
            # Nothing is asked of an object that is not the thesis's.
            reached=bands(name, error, RENDERED_OTHER if name.startswith(_OTHER_OBJECTS) else RENDERED),
        )
        for name, error in errors.items()
    }
    return findings_of(each, headers, caption, sentences, pictures)


def _telling(error: ForceError, band: str) -> float | None:
    """The error in a band; None where that holds too little of the force."""
    return error.tangential[band] if band in error.telling else None


def _sentence(situation: str, alone: float | None, second: str, fused: float | None) -> str:
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
    takes=("seconds", "seed"),  # the cases differ in their motion
)
