"""A second, variable-spring model for high frequencies: where it wins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from diagrams.experiments.comparisons.comparison import Cases, Comparison, Judgement, Recordings
from diagrams.experiments.plans import SETTLE_S
from diagrams.scenario import (
    FusedReflection,
    ImpedanceReflection,
    Renderer,
    Scenario,
    Scripted,
    load_scenario,
)
from mmt_drake.analysis import charts
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import percent
from mmt_drake.model.parameters import BoxParameters
from mmt_drake.rendering.high_band import HighBand
from mmt_drake.systems.flexible_box import SensorNoise

_RENDERERS: Final[Mapping[str, Renderer]] = {
    "model": ImpedanceReflection(),
    "spring": FusedReflection(high_band=HighBand(damper=False)),
    "spring_damper": FusedReflection(high_band=HighBand(damper=True)),
}
_NOISE: Final = SensorNoise(force=0.02, position=1e-5, velocity=5e-4)
_HIGH: Final = "3_to_10_hz"

_SITUATIONS: Final[Mapping[str, str]] = {
    "good_model": "Strokes, and an estimator that waits after each touch.",
    "poor_model": "A chirp to 10 Hz, and the thesis's estimator, which learns from the touch.",
    "lively_object": "The chirp on an object that is a spring above its mode at 6 Hz; the estimator waits.",
}

#: An object that is a spring above its mode at 6 Hz; the thesis's is a damper there.
_LIVELY: Final = BoxParameters(m=1.0, k1=0.0, k2=1500.0, b1=5.0, b2=2.0)


def cases(seed: int, seconds: float | None) -> Mapping[str, Scenario]:
    """Three situations, each with the first model alone and with a second one fused in."""
    base = load_scenario("setup1")
    base = replace(base, seed=seed, duration=seconds or base.duration)
    base = replace(base, environment=replace(base.environment, noise=_NOISE))
    waiting = replace(base, estimator=replace(base.rls, settle=SETTLE_S))
    chirp = Scripted("chirp")
    world = waiting.environment
    lively = replace(world, object=replace(world.object, parameters=_LIVELY))
    scenarios = (waiting, replace(base, operator=chirp), replace(waiting, operator=chirp, environment=lively))
    situations = dict(zip(_SITUATIONS, scenarios, strict=True))
    return {
        f"{situation}_{name}": replace(scenario, renderer=renderer)
        for situation, scenario in situations.items()
        for name, renderer in _RENDERERS.items()
    }


def judge(found: Cases, recordings: Recordings) -> Judgement:
    """Errors by band, against the force without noise."""
    errors = {
        name: case.metrics.rendered_error_true
        for name, case in found.items()
        if case.metrics.rendered_error_true is not None
    }
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values())]
    rows: list[list[Cell]] = []
    for name, error in errors.items():
        ratios = (error.tangential[band] for band in BAND_NAMES)
        rows.append([name, *(None if ratio is None else 100.0 * ratio for ratio in ratios)])
    sentences, pictures = [], {}
    for situation in _SITUATIONS:
        here = {renderer: errors[f"{situation}_{renderer}"] for renderer in _RENDERERS}
        alone, *others = (error.tangential[_HIGH] for error in here.values())
        for second, ratio in zip(list(_RENDERERS)[1:], others, strict=True):
            sentences.append(_told(situation, alone, second, ratio))
        title = f"Error of the rendered force: {situation.replace('_', ' ')}"
        pictures[situation] = (charts.error_bars(here, title=title), _SITUATIONS[situation])
    caption = "Error of the rendered force against the plant's, in contact, after the wind-up phase."
    return Judgement(Table(headers, rows, caption), sentences, {}, pictures)


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
