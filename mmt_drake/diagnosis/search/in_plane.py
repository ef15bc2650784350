"""Friction of which nobody said whether it is a vector in the plane or one for each axis."""

from collections.abc import Callable
from dataclasses import replace

from mmt_drake.diagnosis.fit.box_tracks import BoxTrack
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.nameless import NOISE_ALONE
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.errors import attempt
from mmt_drake.model.parameters import FlexibleBoxModel, InPlane
from mmt_drake.model.structure import Structure
from mmt_drake.model_files import Model


def said(problem: Problem, model: Model, fit: Callable[[Model], Fitted]) -> tuple[Model, Fitted | None]:
    """The model handed in, and None; if it has friction already and does not say which, with what fits better, and fit.

    Args:
        problem: to be explained.
        model: nominal.
        fit: of a model's numbers to the problem; near crude ones the wrong friction may be the better.

    Raises:
        MmtError: the model cannot be simulated.
    """
    if not _is_open(problem, model, model):
        return model, None
    both = (_with(model, "vector"), _with(model, "per_axis"))
    return min(((friction, fit(friction)) for friction in both), key=lambda found: found[1].cost)


def fit_near(problem: Problem, skew: float, model: Structure) -> Fitted:
    """The fit of a model's numbers from these numbers alone: for `said`, where they are not crude.

    Raises:
        MmtError: the model cannot be simulated.
    """
    hypothesis = replace(Hypothesis.of(model, skew), unseen=problem.unseen)
    return problem.fit(hypothesis, hypothesis.base())


def per_axis_if_better(problem: Problem, fitted: Fitted, steps: int) -> Fitted:
    """A fit whose friction is a vector because nobody said what it is; with one for each axis if that is better.

    Where the vector leaves no more than noise nothing is better.
    """
    hypothesis = fitted.hypothesis
    is_noise = fitted.cost <= NOISE_ALONE**2 * problem.samples()
    if is_noise or not _is_open(problem, hypothesis.nominal, fitted.model):
        return fitted
    return _with_if_better(problem, fitted, "per_axis", steps)


def the_other_if_better(problem: Problem, fitted: Fitted, steps: int) -> Fitted:
    """A fit; with its friction the other one of the two, if that is better."""
    nominal = fitted.hypothesis.nominal
    assert isinstance(nominal, FlexibleBoxModel)  # nothing else is open
    return _with_if_better(problem, fitted, "vector" if nominal.in_plane == "per_axis" else "per_axis", steps)


def _with_if_better(problem: Problem, fitted: Fitted, which: InPlane, steps: int) -> Fitted:
    hypothesis = replace(fitted.hypothesis, nominal=_with(fitted.hypothesis.nominal, which))
    found = attempt(problem.fit, hypothesis, fitted.x, steps=steps, secant=True)
    return fitted if found is None or fitted.cost <= found.cost else found


def _is_open(problem: Problem, nominal: Structure, model: Structure) -> bool:
    """Whether it matters, and nobody has said: the model rubs, and both axes move."""
    unsaid = isinstance(nominal, FlexibleBoxModel) and nominal.in_plane is None
    both_move = any(sum(isinstance(t, BoxTrack) for t in tracks) > 1 for tracks in problem.by_recording())
    return unsaid and both_move and isinstance(model, FlexibleBoxModel) and model.couples


def _with(model: Structure, which: InPlane) -> FlexibleBoxModel:
    assert isinstance(model, FlexibleBoxModel)  # nothing else is open
    handed = model.handed
    if handed is not None:
        handed = replace(handed, bare=_with(handed.bare, which))
    return replace(model, in_plane=which, handed=handed)
