"""Laws that nobody has named: over which signals, how they vary, and what they would do to an output."""

import math
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import COARSE
from mmt_drake.effects import tabulated_force
from mmt_drake.effects.tabulated_force import SIGNALS
from mmt_drake.errors import attempt
from mmt_drake.model.structure import Structure
from mmt_drake.numeric.arrays import Array

KNOTS, FINE_KNOTS = 11, 23
"""Of a table; of one over position, where things may lie close together."""
NOISE_ALONE = 1.1
"""RMS of the residual over the noise floor up to which there is no room for a further law."""
_FINE = ("position", "friction_over_time")
_TAIL = 0.01


class Kind(NamedTuple):
    """How a law varies over a signal, in units of the signal's range from its middle.

    Attributes:
        length: within which its values are alike.
        smooth: whether it has slopes (squared exponential), or none as a surface has (exponential).
        odd: whether it is of opposite sign for opposite values, the unit then being the greatest of these.
    """

    length: float
    smooth: bool = False
    odd: bool = False


_ROUGH = Kind(0.3)
VARYING = {
    "sliding_velocity": (Kind(1.0, smooth=True, odd=True), _ROUGH),  # drag and the like; and what bends sharply
    "position": (_ROUGH, Kind(0.05)),  # uneven, and with no two knots alike
    "friction_over_time": (_ROUGH,),
}
"""Signal of a table -> how laws over it may vary, each as strong as what is left says."""


def nameless_laws(problem: Problem, fitted: Fitted) -> list[Array]:
    """What laws over the signals of `VARYING` do to the objective of a fit, (n, q) each, for `hidden_variance`.

    None where no more than noise is left, where the model has a table already, or where none can be simulated.

    Args:
        problem: what was fitted; laws are simulated on the step of a search.
        fitted: the fit.
    """
    if problem.left(fitted) <= NOISE_ALONE or not fitted.hypothesis.admits(tabulated_force.EFFECT):
        return []
    result, problem = [], replace(problem, coarse=max(problem.coarse, COARSE))
    for of, at in table_signals(problem, fitted.model, VARYING, _FINE):
        moved = attempt(moved_by_table, problem, fitted, of, at)
        if moved is not None and np.isfinite(moved).all() and moved.any():
            result += [moved @ _root(np.array(at), kind) for kind in VARYING[of]]
    return result


def table_signals(
    problem: Problem, model: Structure, names: Iterable[str] = SIGNALS, fine: Container[str] = ("position",)
) -> Iterator[tuple[str, tuple[float, ...]]]:
    """What of these a table may be of in this structure and recordings, and where its knots are.

    Args:
        problem: with the recordings.
        model: replayed for the signals.
        names: of `SIGNALS`.
        fine: those over which things may lie close together.
    """
    samples: dict[str, list[Array]] = {}
    for track in problem.tracks:
        _, states = track.replay(model)
        used = track.weight > 0.0
        if isinstance(track, NormalTrack):  # tables are of what happens along the surface
            continue
        for name, values in {**states, "time": track.time - track.time[0], "force": track.measured}.items():
            samples.setdefault(name, []).append(values[used])
    for name in names:
        signal = SIGNALS[name]
        if signal.block in model.BLOCKS and signal.over in samples:
            count = FINE_KNOTS if name in fine else KNOTS
            knots = np.unique(_knots(np.concatenate(samples[signal.over]), count))
            if len(knots) >= 4:
                yield name, tuple(float(k) for k in knots)


def _knots(values: Array, count: int) -> Array:
    """Half way between knots of equal count and knots of equal distance: there are data, and the range is covered."""
    q = np.linspace(_TAIL, 1.0 - _TAIL, count)
    quantiles = np.quantile(values, q)
    return 0.5 * (quantiles + np.linspace(quantiles[0], quantiles[-1], count))


def moved_by_table(problem: Problem, fitted: Fitted, of: str, at: Sequence[float], part: float = 1.0) -> Array:
    """(n, q) derivatives of the objective after the values of a table, all of them 0.

    Args:
        problem: what was fitted.
        fitted: the fit.
        of: of `SIGNALS`.
        at: the knots of the table.
        part: of how far the model is off the step moves the output.
    """
    hypothesis = fitted.hypothesis

    def moved(i: int, step: float) -> Array:
        value = [step if j == i else 0.0 for j in range(len(at))]
        held = {"of": of, "at": list(at), "value": value}
        model = hypothesis.adding(tabulated_force.EFFECT, held).model(fitted.x)
        return (problem.objective(model, hypothesis.skew_of(fitted.x)) - still) / step

    still = problem.objective_at(hypothesis, fitted.x)
    step = problem.left(fitted) * float(np.mean([track.floor for track in problem.tracks]))
    size = float(np.linalg.norm(moved(len(at) // 2, step)))
    if size > 0.0:
        step = part * math.sqrt(fitted.cost) / size
    return np.column_stack([moved(i, step) for i in range(len(at))])


def _root(at: Array, kind: Kind) -> Array:
    """(q, q) a root of the covariance of a law's values at its knots, of variance 1 in the middle of things."""
    middle, reach = 0.5 * (at[0] + at[-1]), 0.5 * (at[-1] - at[0])
    if kind.odd:
        middle, reach = 0.0, float(np.abs(at).max())
    u = (at - middle) / (reach * kind.length)

    def alike(apart: Array) -> Array:
        return np.exp(-0.5 * apart**2) if kind.smooth else np.exp(-np.abs(apart))

    covariance = alike(u[:, np.newaxis] - u)
    if kind.odd:
        covariance = covariance - alike(u[:, np.newaxis] + u)
    size, shapes = np.linalg.eigh(covariance)
    return np.asarray(shapes * np.sqrt(np.maximum(size, 0.0)))
