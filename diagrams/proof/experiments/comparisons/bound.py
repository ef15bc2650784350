"""The Cramer-Rao bound of an object's parameters along a motion: what a force sensor's noise alone would allow.

The unknowns are those of the free-running fit (`mmt_drake.estimation.output_error.fit`), all six at once, and nothing
is believed of them beforehand; the samples are the fit's too. Motion and static friction beyond Coulomb's count as
known. No unbiased estimator is sooner than this, and one that does not know the motion exactly is later.
The times after which an estimator does find the parameters stand beside it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mmt_drake.analysis.metrics import counted
from mmt_drake.analysis.signals import BANDS, contact_time, flag, in_band, mean_step
from mmt_drake.diagrams.proof.experiments import targets
from mmt_drake.diagrams.proof.studies.study import NOISE_FORBIDS, Reached
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.unknowns import LOG, LOW, OBJECT, SIZE, Stick, derivatives, theta_of, unknowns
from mmt_drake.model.parameters import TANGENTIAL_THETA, FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import AXES, Recording
from mmt_drake.replay import replayed

NEAR: Final = 0.05
"""Parameters count as found once they stay so near to the truth."""
_DEVIATIONS: Final = 1.96  # on either side of the truth hold 95 % of a normal distribution
_LEAST: Final = 1e-14  # of the largest eigenvalue: what is no larger is rounding


@dataclass(frozen=True)
class NoiseBound:
    """What force noise alone would allow along one motion.

    Attributes:
        allows_s: parameter -> contact time [s] after which it could be within `NEAR` of the truth, 95 times of 100;
            None where the motion does not allow it, or the truth is zero.
        leaves: name of band (`signals.BANDS`) -> RMS error of the force that parameters at the bound would leave, each
            instant with those of the samples before it, over the RMS of the force, where errors count
            (`metrics.counted`); None where there is no force.
    """

    allows_s: Mapping[str, float | None]
    leaves: Mapping[str, float | None]


def noise_bound(truth: FlexibleBoxModel, recording: Recording, noise: float, ticks: int) -> NoiseBound:
    """The bound along a recorded motion.

    Args:
        truth: the object, and where derivatives are taken.
        recording: of a run without delay, on an even clock; its `master_*` columns are the true motion.
        noise: deviation of the force, white, per axis and sample of the recording [N].
        ticks: of which a sample of the fit is the mean.

    Raises:
        BadInput: no noise, a missing column, or no contact where errors count.
    """
    if not noise > 0.0:
        raise BadInput("noise", at="force", found=noise, expected="a deviation above 0 N: without noise nothing bounds")
    motion, contact = true_motion(recording), flag(recording, "in_contact")
    force, slope = sensitivity(truth, motion)
    covariance, deviation = bound_of(truth, slope, contact, noise, ticks)
    theta = truth.theta()[OBJECT]
    ends = np.append(contact_time(contact, mean_step(recording)), np.nan)[ticks::ticks][: len(deviation)]
    allowed = _DEVIATIONS * deviation <= NEAR * theta
    allows = {
        name: float(ends[np.argmax(enough)]) if value > 0.0 and enough.any() else None
        for name, value, enough in zip(TANGENTIAL_THETA, theta, allowed.T, strict=True)
    }
    return NoiseBound(allows, _left(force, slope, covariance, counted(recording), ticks, 1.0 / mean_step(recording)))


def bound_of(truth: FlexibleBoxModel, slope: Array, contact: Flags, noise: float, ticks: int) -> tuple[Array, Array]:
    """The bound after each sample of so many ticks: covariances (k, 6, 6) of the unknowns, deviations (k, 6) of theta.

    Args:
        truth: the object.
        slope: (n, axes, 6) of `sensitivity`.
        contact: (n,) of each tick.
        noise: deviation of the force, white, per axis and tick [N].
        ticks: of which a sample of the fit is the mean.
    """
    theta = truth.theta()
    covariance = covariances(sample_means(slope, contact, ticks), noise, _steps(unknowns(theta)[OBJECT]))
    return covariance, np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)) * derivatives(theta)


def true_motion(recording: Recording) -> Recording:
    """The probe's motion without sensor noise, and the contact: what `mmt_drake.replay` is driven with."""
    names = {f"{name}_{axis}": f"master_{name}_{axis}" for name in ("position", "velocity") for axis in AXES}
    columns = {name: recording[master] for name, master in names.items()}
    return Recording(recording.time, {**columns, "in_contact": recording["in_contact"]}, recording.source)


def sensitivity(truth: FlexibleBoxModel, motion: Recording) -> tuple[Array, Array]:
    """The force along x and y [N] (n, 2), and its derivatives after the object's unknowns (n, 2, 6).

    They are differences over 5 % of each parameter to either side: a derivative proper would not see that the jumps
    that Karnopp's friction makes come sooner or later, which happens by whole ticks.
    """
    theta = truth.theta()
    x, stick = unknowns(theta)[OBJECT], Stick(theta[8] - theta[5], theta[9])

    def force(at: Array) -> Array:
        found = replayed(_with_theta(truth, theta_of(at, stick, theta[6:8])), motion)
        return np.column_stack([found["force_x"], found["force_y"]])

    there, steps = force(x), _steps(x)
    slope = np.empty((*there.shape, len(x)))
    for j, step in enumerate(steps):
        ahead, behind = x.copy(), x.copy()
        ahead[j] += step
        behind[j] -= step if x[j] - step >= LOW[j] else 0.0
        slope[:, :, j] = (force(ahead) - force(behind)) / (ahead[j] - behind[j])
    return there, slope


def _steps(x: Array) -> Array:
    """Of the differences: a 20th of each parameter, or of its natural size where it is zero."""
    return NEAR * np.where(LOG[OBJECT], 1.0, np.where(x > 0.0, x, SIZE[OBJECT]))


def sample_means(slope: Array, contact: Flags, ticks: int) -> Array:
    """Means (n // ticks, 2, k) over as many ticks, weighted as if their noise were that of a tick; 0 off contact."""
    count = len(slope) // ticks
    whole = np.all(contact[: count * ticks].reshape(count, ticks), axis=1)
    means = slope[: count * ticks].reshape(count, ticks, *slope.shape[1:]).mean(axis=1)
    weighted: Array = np.sqrt(ticks) * whole[:, np.newaxis, np.newaxis] * means
    return weighted


def covariances(slope: Array, noise: float, size: Array) -> Array:
    """The Cramer-Rao bound (n, k, k) of the unknowns after each sample: the inverse of Fisher's information.

    Args:
        slope: (n, axes, k) derivatives of what is measured after the unknowns.
        noise: deviation of what is measured, white.
        size: (k,) natural sizes of the unknowns, so that none is lost to rounding. A direction that the samples say
            nothing of has a variance that is huge.
    """
    scaled = slope * (size / noise)
    information = np.cumsum(np.einsum("nai,naj->nij", scaled, scaled), axis=0)
    value, vector = np.linalg.eigh(information)
    value = np.maximum(value, np.maximum(_LEAST * value[:, -1:], _LEAST))
    covariance: Array = np.einsum("nik,nk,njk->nij", vector, 1.0 / value, vector) * np.outer(size, size)
    return covariance


def _with_theta(model: FlexibleBoxModel, theta: Array) -> FlexibleBoxModel:
    m, k1, k2, b1, b2, Fc, _, _, Fs, v_d = map(float, theta)
    moved = model.with_parameters(m=m, k1=k1, k2=k2, b1=b1, b2=b2, Fc=Fc)
    return replace(moved, friction=Friction(max(Fs, Fc), Fc, v_d))


def _left(
    force: Array, slope: Array, covariance: Array, chosen: Flags, ticks: int, rate: float
) -> dict[str, float | None]:
    """`NoiseBound.leaves`."""
    # The samples before an instant: those that have ended by then.
    before = np.minimum(np.flatnonzero(chosen) // ticks, len(covariance)) - 1
    left: dict[str, float | None] = {}
    for band, edges in BANDS.items():
        whole = in_band(force, edges, rate)[chosen]
        each = in_band(slope.reshape(len(slope), -1), edges, rate).reshape(slope.shape)[chosen]
        variance = np.einsum("nai,nij,naj->n", each, covariance[before], each)
        power = float(np.mean(np.sum(whole**2, axis=1)))
        left[band] = float(np.sqrt(np.mean(variance) / power)) if power > 0.0 else None
    return left


Times = Mapping[str, float | None]
"""Parameter -> contact time [s]; None is never."""

FOUND: Final = ("m", "k2", "b1", "b2", "Fc")


def times_found(recording: Recording, true: Mapping[str, float]) -> dict[str, float | None]:
    """Contact time [s] from which on each parameter stays near the truth; None where it does not."""
    touched = contact_time(flag(recording, "in_contact"), mean_step(recording))
    found: dict[str, float | None] = {}
    for name in FOUND:
        near = np.abs(recording[f"theta_{name}"] - true[name]) <= NEAR * true[name]
        astray = np.flatnonzero(~near)
        first = 0 if len(astray) == 0 else int(astray[-1]) + 1
        found[name] = float(touched[first]) if first < len(touched) else None
    return found


def parameters_found(case: str, found: Times, allowed: Times | None = None) -> dict[str, Reached]:
    """When each parameter was found; without a verdict where the noise alone does not allow it in time.

    Args:
        case: whose.
        found: of `times_found`.
        allowed: parameter -> contact time after which the noise would allow it (`bound.NoiseBound`); where nobody asked
            for that bound every parameter is to be found in time.
    """
    figures = {}
    for name, time in found.items():
        bound = None if allowed is None else allowed[name]
        forbidden = allowed is not None and (bound is None or bound > targets.FOUND_S)
        unasked = NOISE_FORBIDS if forbidden else ""
        figures[name] = Reached(case, targets.found(name), time, bound, never=time is None, unasked=unasked)
    return figures
