"""The project's own fit of the numbers that the other packages are given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mmt_drake import __version__
from mmt_drake.analysis.nrmse import nrmse
from mmt_drake.diagnosis.fit.hypothesis import SKEW, Hypothesis
from mmt_drake.diagnosis.fit.prepare import scales_of
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagrams.trial.peers.case import FRICTION, PeerCase
from mmt_drake.diagrams.trial.peers.result import OURS, WITH, WITHOUT, Estimate, PeerResult, Stopwatch


def fit_own(case: PeerCase, *, friction: bool, diagnosis: Mapping[str, Any] | None = None) -> PeerResult:
    """Fit the model's parameters.

    Args:
        case: to be fitted.
        friction: whether Coulomb friction, which the model lacks, is free too.
        diagnosis: what `diagnose` says of the case (`diagnosis.json`), if it was asked; its names and its summary
            become those of the result.
    """
    hypothesis = Hypothesis(case.model, case.skew)
    start = hypothesis.base()
    if friction:
        hypothesis = hypothesis.adding(FRICTION)
        start = hypothesis.vector({}, {FRICTION.name: friction_start(case)})
    case.problem.residual(hypothesis.model(start), hypothesis.skew_of(start))  # compiles
    with Stopwatch() as taken:
        fitted = case.problem.fit(hypothesis, start)
    estimates = {
        place.symbol: Estimate(float(value), 0.5 * (high - low))
        for place, value, (low, high) in zip(
            hypothesis.free_parameters(), fitted.x, intervals(case.problem, fitted), strict=True
        )
        if place.symbol != SKEW
    }
    output, _ = case.track.replay(fitted.model, 1.0)  # to the smoothed motion, unfiltered
    simulated = np.interp(case.recording.time - fitted.skew, case.track.time, output)
    measured = np.concatenate([touch.force for touch in case.touches])
    answered = np.concatenate([simulated[t.first : t.first + len(t.time)] for t in case.touches])
    return PeerResult(
        tool=OURS,
        version=__version__,
        setting=WITH if friction else WITHOUT,
        rate_hz=case.track.smoothed.rate_hz,
        seconds=taken.seconds,
        cpu_seconds=taken.cpu_seconds,
        before_seconds=case.preparation_seconds,
        simulations=fitted.minimum.simulations,
        estimates=estimates,
        error=nrmse(measured, answered),
        names=() if diagnosis is None else tuple(effect["name"] for effect in diagnosis.get("effects", ())),
        says="" if diagnosis is None else f"{diagnosis['verdict']}: {diagnosis['summary']}",
    )


def friction_start(case: PeerCase) -> dict[str, float]:
    """Where the search for Coulomb friction begins, in every package."""
    return dict(FRICTION.starts(scales_of(case.problem, case.model))[0])
