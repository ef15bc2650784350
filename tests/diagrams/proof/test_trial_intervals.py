"""Intervals above a remainder that nobody has named hold the truth; the effect is given, so nothing is searched for."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from mmt_drake.diagnosis.fit.bootstrap import deviations
from mmt_drake.diagnosis.fit.comparison import fit_widening
from mmt_drake.diagnosis.fit.floors import with_floors
from mmt_drake.diagnosis.fit.hypothesis import SKEW, Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.search.in_plane import fit_near, said
from mmt_drake.diagrams.proof.trial.cases import Case
from mmt_drake.diagrams.proof.trial.plants import PLANTS
from mmt_drake.diagrams.proof.trial.remainder import REMAINDERS, draw_beneath
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import parse_model

EFFECTS = ("quadratic_drag", "nonlinear_stiffness")


def held(case: Case) -> Iterator[tuple[bool, bool]]:
    """Of each true number whether the interval holds it, and whether one counted over blocks alone would."""
    prepared = prepare([case.recording()], parse_model(dict(case.nominal)))
    assert prepared.problem is not None and prepared.fine is not None
    near = partial(fit_near, prepared.problem, prepared.skew)
    model, _ = said(prepared.problem, parse_model(dict(case.nominal)), near)
    (concealed,) = case.effects
    effect = LIBRARY[concealed.name].within(model)
    hypothesis = Hypothesis.of(model, prepared.skew).adding(effect)
    base = {name.replace("normal_", "normal."): value for name, value in case.base.items()}
    x = hypothesis.vector(base, {effect.name: dict(concealed.parameters)})
    fine = replace(prepared.fine, tracks=with_floors(prepared.fine.tracks, hypothesis.model(x)), coarse=1.0)
    low, high, _ = hypothesis.limits(x)
    fitted = fit_widening(fine, hypothesis, np.clip(x, low, high), steps=12)
    minimum = fitted.minimum
    known = deviations(minimum.jacobian, minimum.residual, fine.objective_blocks(), fine.samples())
    for p, true, value, half, (start, end) in zip(
        hypothesis.free_parameters(), x, fitted.x, known.half_width, intervals(fine, fitted), strict=True
    ):
        if p.symbol != SKEW:
            yield start <= true <= end, abs(value - true) <= half


@pytest.mark.parametrize(("plant", "least"), [("own", 0.9), ("foreign", 0.9)])
def test_intervals_above_a_remainder_hold_the_truth_where_blocks_alone_do_not(plant: str, least: float) -> None:
    rng, found = np.random.default_rng(1), []
    for effect in EFFECTS:
        for remainder in REMAINDERS:
            found += held(draw_beneath(rng, effect, effect, 0.9, remainder, 0.2, PLANTS[plant]))
    covered, resampled = np.mean(found, axis=0)
    print(f"{plant}: {covered:.3f} of {len(found)} numbers, over blocks alone {resampled:.3f}")
    assert resampled < 0.8 and covered >= least
