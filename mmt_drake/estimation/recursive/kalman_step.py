"""The extended Kalman filter over the object's motion and its parameters; compiled.

State: the unknowns of `mmt_drake.estimation.output_error.unknowns` (log m, k1, log k2, b1, log b2, Fc), and of each
tangential axis the body's position, velocity and the anchor of the contact spring. The prediction is the plant itself
(`mmt_drake.model.body`), stick and slip located within the step, and so is what is predicted of the force.

Friction at rest is set-valued, so the plant is a hybrid system, and its mode (stuck, sliding either way) is no random
variable here but that of the predicted motion. Derivatives are differences of the plant's own step; where it passes an
event they hold the jump that a change of mode puts in (the saltation matrix). A body that is stuck has no velocity to
be uncertain of: its row and column of the covariance are empty until it slides. What the true body does in another mode
than the predicted one is met as noise, whose variance follows what the innovations say (covariance matching, Mehra
1972), and no innovation counts for more than three deviations.

Source: Jazwinski, Stochastic Processes and Filtering Theory, 1970, ch. 8; equality constraints, for what reaches a
bound, by projection (Simon, Optimal State Estimation, 2006, ch. 7.5).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.unknowns import HIGH, LOG_B2, LOG_K2, LOW, SIZE, UNKNOWNS
from mmt_drake.estimation.output_error.window import SHORT_GAP
from mmt_drake.estimation.recursive.samples import Samples, advance, write_parameters
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MODE, POSITION, VELOCITY
from mmt_drake.model.parameters import B2, K2, KERNEL_SIZE, THETA

Array = NDArray[np.float64]

OWN = 3  # states of an axis: position, velocity, anchor
STATES = UNKNOWNS + 2 * OWN
_FROM = UNKNOWNS + OWN  # what the motion of an axis depends on
_OF_SIZE = 1e-3  # differences after the unknowns, of their natural sizes
_DIFFERENCE = (1e-6, 1e-5, 1e-6)  # after position [m], velocity [m/s], anchor [m]
_FARTHEST = 9.0  # squared deviations that an innovation may count for
_LONGEST = 0.5  # of the unknowns' natural sizes: the longest step


class Tuning(NamedTuple):
    """What the filter takes for random.

    Attributes:
        force: variance of a sample of the measured force [N^2].
        push: variance of the force on the body that nothing in the model explains, from sample to sample [N^2].
        drift: variance of the unknowns' random walk from sample to sample, of their natural sizes squared.
        gap: variances that the body's position and velocity gain per sample of a long gap in the motion [m^2],
            [m^2/s^2].
        follow: how fast the noise follows the innovations, per sample.
    """

    force: float
    push: float
    drift: float
    gap: tuple[float, float]
    follow: float


@njit(cache=True, error_model="numpy")
def _lost(samples: Samples, k: int) -> bool:
    """Whether sample k is far into a gap in the motion; a short one is bridged."""
    return not samples.good[max(0, k - SHORT_GAP) : k + 1].any()


@njit(cache=True, error_model="numpy")
def _spread(P: Array, A: Array, i: int, row: Array) -> None:
    """P <- Phi P Phi' for axis i, whose own states depend on the unknowns and themselves by A (OWN, UNKNOWNS + OWN)."""
    at = UNKNOWNS + OWN * i
    for side in range(2):
        for n in range(STATES):
            for r in range(OWN):
                total = 0.0
                for j in range(_FROM):
                    c = j if j < UNKNOWNS else at + j - UNKNOWNS
                    total += A[r, j] * (P[c, n] if side == 0 else P[n, c])
                row[r] = total
            for r in range(OWN):
                if side == 0:
                    P[at + r, n] = row[r]
                else:
                    P[n, at + r] = row[r]


@njit(cache=True, error_model="numpy")
def _move(delta: float, gain: Array, x: Array, axes: Array) -> None:
    """Add delta times the gain to the state."""
    for j in range(UNKNOWNS):
        x[j] += gain[j] * delta
    for i in range(2):
        at = UNKNOWNS + OWN * i
        axes[i, POSITION] += gain[at] * delta
        axes[i, VELOCITY] += gain[at + 1] * delta
        axes[i, ANCHOR] += gain[at + 2] * delta


@njit(cache=True, error_model="numpy")
def _correct(
    innovation: float, H: Array, variance: float, x: Array, axes: Array, P: Array, gain: Array
) -> tuple[float, float]:
    """One measurement; returns its squared innovation over the variance that was expected of it, and that variance."""
    S = variance
    for a in range(STATES):
        gain[a] = 0.0
        for b in range(STATES):
            gain[a] += P[a, b] * H[b]
        S += H[a] * gain[a]
    expected, surprise = S, innovation * innovation / S
    S *= max(1.0, math.sqrt(surprise / _FARTHEST))
    share = 1.0
    for j in range(UNKNOWNS):
        step = abs(gain[j] * innovation / S)
        if step * share > _LONGEST * SIZE[j]:
            share = _LONGEST * SIZE[j] / step
    _move(share * innovation / S, gain, x, axes)
    left = share * (2.0 - share) / S  # Joseph's form for a gain that is cut short
    for a in range(STATES):
        for b in range(STATES):
            P[a, b] -= left * gain[a] * gain[b]
    return surprise, expected


@njit(cache=True, error_model="numpy")
def _within_bounds(x: Array, axes: Array, P: Array, gain: Array) -> None:
    """Project the state onto the bounds that unknowns have passed."""
    for _ in range(2):
        for j in range(UNKNOWNS):
            bound = min(max(x[j], LOW[j]), HIGH[j])
            if bound != x[j] and P[j, j] > 0.0:
                for a in range(STATES):
                    gain[a] = P[a, j] / P[j, j]
                _move(bound - x[j], gain, x, axes)
    for j in range(UNKNOWNS):
        x[j] = min(max(x[j], LOW[j]), HIGH[j])


@njit(cache=True, error_model="numpy", nogil=True)
def filter_samples(
    samples: Samples,
    span: tuple[int, int],
    stick: tuple[float, float],
    tuning: Tuning,
    x: Array,
    axes: Array,
    P: Array,
    scale: float,
) -> tuple[float, float]:
    """Let the filter take samples, in place.

    Args:
        samples: with the one before the span.
        span: first sample to take, at least 1, and one past the last.
        stick: Fs - Fc [N] and v_d [m/s] of Karnopp's law.
        tuning: what is random.
        x: (UNKNOWNS,) unknowns.
        axes: (2, AXIS_SIZE) the body along x and y at the sample before the span.
        P: (STATES, STATES) covariance of the state there.
        scale: noise of the force over what is known of it, at least 1.

    Returns:
        The scale afterwards, and by how much the innovations were unlikely: -log likelihood, but for a constant.

    Raises:
        RuntimeError: see `mmt_drake.model.body.advance_axis`.
    """
    theta, q = np.ones(len(THETA)), np.zeros((UNKNOWNS + 1, KERNEL_SIZE))
    other, step = np.empty(UNKNOWNS), np.empty(_FROM)
    A, row, H, gain = np.zeros((OWN, _FROM)), np.empty(OWN), np.empty(STATES), np.empty(STATES)
    before, axis, forces, felt = np.empty(AXIS_SIZE), np.empty(AXIS_SIZE), np.empty(2), np.empty(2)
    unlikely = 0.0
    for j in range(OWN):
        step[UNKNOWNS + j] = _DIFFERENCE[j]
    for k in range(span[0], span[1]):
        write_parameters(x, stick, theta, q[UNKNOWNS])
        for j in range(UNKNOWNS):
            step[j] = _OF_SIZE * SIZE[j]
            if x[j] + step[j] > HIGH[j]:
                step[j] = -step[j]
            other[:] = x
            other[j] += step[j]
            write_parameters(other, stick, theta, q[j])
        p = q[UNKNOWNS]
        for i in range(2):
            before[:] = axes[i]
            advance(samples, i, k, p, axes[i], forces)
            felt[i] = forces[1]
            for j in range(_FROM):
                axis[:] = before
                if j >= UNKNOWNS:
                    axis[j - UNKNOWNS] += step[j]  # POSITION, VELOCITY, ANCHOR
                if j == UNKNOWNS + VELOCITY and before[MODE] == 0.0:
                    axis[VELOCITY] = 0.0
                advance(samples, i, k, q[j] if j < UNKNOWNS else p, axis, forces)
                for r in range(OWN):
                    A[r, j] = (axis[r] - axes[i, r]) / step[j]
            _spread(P, A, i, row)
            at = UNKNOWNS + OWN * i
            if _lost(samples, k):
                P[at, at] += tuning.gap[0]
                P[at + 1, at + 1] += tuning.gap[1]
            elif axes[i, MODE] != 0.0:
                P[at + 1, at + 1] += tuning.push * (samples.h / math.exp(x[0])) ** 2
        if samples.weight[0, k] + samples.weight[1, k] == 0.0:
            continue
        for j in range(UNKNOWNS):
            P[j, j] += tuning.drift * SIZE[j] ** 2
        for i in range(2):
            if samples.weight[i, k] == 0.0:
                continue
            at = UNKNOWNS + OWN * i
            d = samples.probe[i, k] - axes[i, POSITION] - axes[i, ANCHOR]
            H[:] = 0.0
            H[LOG_K2], H[LOG_B2] = -p[K2] * d, -p[B2] * (samples.rate[i, k] - axes[i, VELOCITY])
            H[at + POSITION], H[at + VELOCITY], H[at + ANCHOR] = p[K2], p[B2], p[K2]
            innovation = samples.force[i, k] - felt[i]
            surprise, expected = _correct(innovation, H, scale * tuning.force, x, axes, P, gain)
            unlikely += 0.5 * (min(surprise, _FARTHEST) + math.log(expected / tuning.force))
            scale = max(1.0, scale * math.exp(tuning.follow * (min(surprise, _FARTHEST) - 1.0)))
        _within_bounds(x, axes, P, gain)
        for i in range(2):
            if axes[i, MODE] == 0.0:
                axes[i, VELOCITY] = 0.0
            elif axes[i, VELOCITY] * axes[i, MODE] < 0.0:
                axes[i, MODE] = math.copysign(1.0, axes[i, VELOCITY])
    return scale, unlikely
