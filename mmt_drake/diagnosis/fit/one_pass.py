"""Bodies that go through everything once, as in a fall: a curve over time there does what a law does."""

import numpy as np
from scipy import stats

from mmt_drake.diagnosis.fit.left_out import by_chance, left_out, left_out_linear
from mmt_drake.diagnosis.fit.nameless import moved_by_table
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.effects import tabulated_force
from mmt_drake.errors import attempt
from mmt_drake.model.structure import PositionOut
from mmt_drake.numeric.arrays import Array

_ONE_WAY = 0.98
"""Rank correlation with time from which on a signal only rises, or only falls."""
_SIGNALS = ("position", "sliding_velocity")
_OVER = "friction_over_time"
"""Of a table. Where nothing turns, a level of friction over time is any force on the body over time."""
_SLIGHT = 0.01
"""Part of the mismatch that a step of its values makes: far from where friction would hold a body."""


def passes_once(problem: Problem, fitted: Fitted) -> bool:
    """Whether place and speed only rise or only fall, in all recordings alike: each then says what the time says.

    Args:
        problem: of a body that moves by itself.
        fitted: says how it moves.
    """
    times: list[Array] = []
    samples: dict[str, list[Array]] = {name: [] for name in _SIGNALS}
    for track in problem.tracks:
        if abs(stats.spearmanr(track.time, track.smoothed.output[:, track.column]).statistic) < _ONE_WAY:
            return False  # without a simulation, as nearly always
        _, states = track.replay(fitted.model, problem.coarse, fitted.late)
        used = track.weight > 0.0
        if not samples.keys() <= states.keys():
            return False
        times.append((track.time - track.time[0])[used])
        for name, values in samples.items():
            values.append(states[name][used])
    time = np.concatenate(times)
    return all(abs(stats.spearmanr(time, np.concatenate(s)).statistic) >= _ONE_WAY for s in samples.values())


def may_be_any_curve(problem: Problem, refit: Fitted, fitted: Fitted, ruled_out: float) -> bool:
    """Whether a force over time with a number more explains as much as the effects of a fit, in such recordings.

    A law with one number has a shape of its own there; with two and more many a law draws what goes by once, and the
    best of so many says little.

    Args:
        problem: what was fitted.
        refit: the fit without effects.
        fitted: the fit with them.
        ruled_out: a curve is ruled out that chance puts behind the fit with less than this probability.
    """
    count = len(fitted.x) - len(refit.x)
    if count < 2 or not fitted.hypothesis.effects or not refit.hypothesis.admits(tabulated_force.EFFECT):
        return False
    if not isinstance(refit.hypothesis.nominal, PositionOut) or not passes_once(problem, fitted):
        return False
    end = max(track.duration for track in problem.tracks)
    moved = attempt(moved_by_table, problem, refit, _OVER, tuple(np.linspace(0.0, end, count + 1)), _SLIGHT)
    if moved is None:
        return False
    jacobian = np.column_stack([refit.minimum.jacobian, moved])
    step = np.linalg.lstsq(jacobian, -refit.minimum.residual, rcond=None)[0]
    curve = left_out_linear(problem, jacobian, refit.minimum.residual + jacobian @ step)
    numbers = problem.blocks()
    chance = by_chance(numbers, curve, left_out(problem, fitted), problem.samples() / len(numbers))
    return chance >= ruled_out
