"""The sums of the refined instrumental variable on the regressors of eq. 7; compiled.

Eq. 7, with friction f on the body in full (the thesis leaves out its derivative), s = f / Fc::

    F = -(a v'' + b v' + c v + d x + e F'' + f F' + g (s + b2/k2 s'))

All signals pass 1 / (e p^2 + f p + 1), p = d/dt, whose states are their derivatives too: with the true e and f what the
equation misses is then the noise of the force as it was measured, white (Young and Jakeman 1980; Young, Recursive
Estimation and Time-Series Analysis, 2011, ch. 8). With any prefilter the equation holds, but not while that changes,
since differentiation does not commute with it: one is kept as it is, and the next one runs in beside it before it takes
over. x counts from where the contact spring is unstretched, and the filters start empty at each touch, which is exact
for a body that rests then.

Noise on F makes least squares biased, since F stands among its own regressors; an instrument that the noise does not
reach does not have this. It is the force of an auxiliary model along the same motion, and that is the plant itself with
the parameters believed so far, sticking where they say so; its friction is s.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.unknowns import UNKNOWNS, write_unknowns
from mmt_drake.estimation.recursive.samples import Samples, advance
from mmt_drake.model.body import ANCHOR, MODE, POSITION, VELOCITY
from mmt_drake.model.forces import NOTHING as NO_MEMORY
from mmt_drake.model.forces import Motion, Surroundings, constants, forces
from mmt_drake.model.hermite import Cubic
from mmt_drake.model.parameters import B2, FD, K2, THETA
from mmt_drake.model.regrouping_equations import regroup

Array = NDArray[np.float64]

REGRESSORS = 7
_V, _X, _F, _MODEL, _FRICTION = range(5)
SIGNALS = 5
BANK = 3 * SIGNALS
"""Of each signal: filtered, the rate of that, the latest input."""
_MOVING = 1e-3  # [m/s]: a slower motion says less than its noise, which is in regressors and instruments alike


class Prefilter(NamedTuple):
    """1 / (e p^2 + f p + 1) from sample to sample, exact for inputs that are linear in between.

    Attributes:
        e, f: [s^2], [s].
        free: (2, 2) of what is there.
        before, after: (2,) of the input at either end.
    """

    e: float
    f: float
    free: Array
    before: Array
    after: Array


class Sums(NamedTuple):
    """What samples leave behind, fading.

    Attributes:
        cross: (7, 7) instruments by regressors.
        instruments: (7, 7) instruments by instruments.
        target: (7,) instruments by the filtered force.
        counts: (3,) samples; squared misses [N^2]; time that was learned from in all [s].
    """

    cross: Array
    instruments: Array
    target: Array
    counts: Array


@njit(cache=True, error_model="numpy")
def _friction(samples: Samples, i: int, k: int, p: Array, axis: Array) -> float:
    """Friction on the auxiliary body over Fc; where it is stuck, what holds it."""
    if p[FD] <= 0.0:
        return np.sign(axis[VELOCITY])
    if axis[MODE] != 0.0:
        return axis[MODE]
    probe, level = Cubic(samples.probe[i, k], samples.rate[i, k], 0.0, 0.0), Cubic(0.0, 0.0, 0.0, 0.0)
    around = Surroundings(probe, level, axis[ANCHOR], samples.contact[k] != 0.0, 0.0)
    return forces(Motion(axis[POSITION], 0.0, 0.0, NO_MEMORY), 0.0, around, constants(p)).drive / p[FD]


@njit(cache=True, error_model="numpy")
def _filter(bank: Array, which: int, value: float, through: Prefilter) -> None:
    """One sample of a signal, in the bank (BANK,): filtered, its rate, the latest input."""
    signal = bank[3 * which : 3 * which + 3]
    y, rate, last = signal[0], signal[1], signal[2]
    signal[0] = through.free[0, 0] * y + through.free[0, 1] * rate + through.before[0] * last + through.after[0] * value
    signal[1] = through.free[1, 0] * y + through.free[1, 1] * rate + through.before[1] * last + through.after[1] * value
    signal[2] = value


@njit(cache=True, error_model="numpy")
def _second(signal: Array, through: Prefilter) -> float:
    """The filtered signal's second derivative."""
    return (signal[2] - signal[0] - through.f * signal[1]) / through.e


@njit(cache=True, error_model="numpy")
def _regressor(bank: Array, force: int, ratio: float, through: Prefilter, out: Array) -> None:
    """Eq. 7's regressor of one axis, with the force that is told; `ratio` is b2 / k2 [s]."""
    v, F, s = bank[3 * _V : 3 * _V + 3], bank[3 * force : 3 * force + 3], bank[3 * _FRICTION : 3 * _FRICTION + 3]
    out[0], out[1], out[2], out[3] = -_second(v, through), -v[1], -v[0], -bank[3 * _X]
    out[4], out[5], out[6] = -_second(F, through), -F[1], -(s[0] + ratio * s[1])


@njit(cache=True, error_model="numpy", nogil=True)
def add_samples(
    samples: Samples,
    span: tuple[int, int],
    p: Array,
    regrouped: Array,
    through: tuple[Prefilter, Prefilter],
    growth: float,
    longest: float,
    axes: Array,
    bank: Array,
    sums: Sums,
) -> None:
    """Let samples add to the sums, in place.

    Args:
        samples: with the one before the span.
        span: first sample to take, at least 1, and one past the last.
        p: kernel vector of the auxiliary model.
        regrouped: (7,) a ... g believed so far.
        through: the prefilter, and the one that runs in.
        growth, longest: what is remembered of the time in contact: this share of it, and no more than that [s].
        axes: (2, AXIS_SIZE) the auxiliary body at the sample before the span.
        bank: (2, 2, BANK) what is in both, of each axis.
        sums: what is added to.

    Raises:
        RuntimeError: see `mmt_drake.model.body.advance_axis`.
    """
    felt, psi, zeta = np.empty(2), np.empty(REGRESSORS), np.empty(REGRESSORS)
    ratio = p[B2] / p[K2]
    for k in range(span[0], span[1]):
        touching = samples.contact[k] != 0.0
        for i in range(2):
            advance(samples, i, k, p, axes[i], felt)
            if not touching:
                bank[:, i, :] = 0.0
                continue
            weight = samples.weight[i, k]
            # A force that is not believed is the model's.
            force = samples.force[i, k] if weight != 0.0 else felt[1]
            friction = _friction(samples, i, k, p, axes[i])
            for j in range(2):
                _filter(bank[j, i], _V, samples.rate[i, k], through[j])
                _filter(bank[j, i], _X, samples.probe[i, k] - axes[i, ANCHOR], through[j])
                _filter(bank[j, i], _F, force, through[j])
                _filter(bank[j, i], _MODEL, felt[1], through[j])
                _filter(bank[j, i], _FRICTION, friction, through[j])
            if weight == 0.0 or abs(bank[0, i, 3 * _V]) < _MOVING:
                continue
            _regressor(bank[0, i], _F, ratio, through[0], psi)
            _regressor(bank[0, i], _MODEL, ratio, through[0], zeta)
            y = bank[0, i, 3 * _F]
            miss = y
            for a in range(REGRESSORS):
                miss -= psi[a] * regrouped[a]
            for a in range(REGRESSORS):
                sums.target[a] += zeta[a] * y
                for b in range(REGRESSORS):
                    sums.cross[a, b] += zeta[a] * psi[b]
                    sums.instruments[a, b] += zeta[a] * zeta[b]
            sums.counts[0] += 1.0
            sums.counts[1] += miss * miss
        if samples.weight[0, k] + samples.weight[1, k] > 0.0:
            sums.counts[2] += samples.h
            keep = np.exp(-samples.h / min(longest, samples.h + growth * sums.counts[2]))
            sums.cross[:, :] *= keep
            sums.instruments[:, :] *= keep
            sums.target[:] *= keep
            sums.counts[0] *= keep
            sums.counts[1] *= keep


@njit(cache=True, error_model="numpy")
def misfit(x: Array, cross: Array, target: Array, root: Array, mean: Array) -> Array:
    """What least squares are taken of (7 + UNKNOWNS,): what the sums miss, and the distance from the prior.

    Args:
        x: (UNKNOWNS,) as in `mmt_drake.estimation.output_error.unknowns`.
        cross, target: of the sums, made white (7, 7) and (7,).
        root, mean: of the prior; root' root is its information.
    """
    theta, out = np.empty(len(THETA)), np.empty(REGRESSORS + UNKNOWNS)
    write_unknowns(x, 0.0, 0.0, theta)
    rho = regroup(theta[0], theta[1], theta[2], theta[3], theta[4], theta[5])
    for a in range(REGRESSORS):
        out[a] = target[a]
        for b in range(REGRESSORS):
            out[a] -= cross[a, b] * rho[b]
    for a in range(UNKNOWNS):
        out[REGRESSORS + a] = 0.0
        for b in range(UNKNOWNS):
            out[REGRESSORS + a] += root[a, b] * (x[b] - mean[b])
    return out
