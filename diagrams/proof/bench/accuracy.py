"""Errors of plant, renderer and `simulate` against the trial's time stepping, which shares no code with them."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.diagrams.proof.trial.plant import run_axis
from mmt_drake.diagrams.stations.environment import THESIS_FRICTION
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.simulation import simulate

Motion = tuple[Callable[[float], float], Callable[[float], float]]

STEP, DURATION = 1e-3, 4.0
_SUBSTEPS = 1000  # of the independent integration, a sample
_SINES = ((0.03, 3.6, 0.0), (0.02, 0.7, 0.4), (0.005, 10.0, 1.1))


def fast() -> Motion:
    """Strokes with content from 0.7 to 10 Hz: position [m] and velocity [m/s] as functions of time."""

    def x(t: float) -> float:
        return float(sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in _SINES))

    def v(t: float) -> float:
        return float(sum(a * 2 * np.pi * f * np.cos(2 * np.pi * f * t + p) for a, f, p in _SINES))

    return x, v


def slow() -> Motion:
    """A slow stroke that lingers at its middle, so that friction sticks."""
    w = 2 * np.pi * 0.25
    return lambda t: 0.04 * np.sin(w * t) ** 3, lambda t: 0.12 * w * np.sin(w * t) ** 2 * np.cos(w * t)


def independent(x: Array, v: Array, times: Array, p: BoxParameters, friction: Friction) -> tuple[Array, Array]:
    """Force on the probe [N] and the body's velocity [m/s], (n,) each, by `trial.plant`, in contact throughout.

    Args:
        x, v: of the probe along the axis, (n,) [m], [m/s].
        times: (n,) [s].
        p, friction: the object; p.Fc is not asked.
    """
    Fs, Fd = friction.Fs, friction.Fd
    levels = {"Fs_plus": Fs, "Fs_minus": Fs, "Fd_plus": Fd, "Fd_minus": Fd, "v_d": friction.v_d}
    laws = Physics(m=p.m, k1=p.k1, k2=p.k2, b_plus=p.b1, b_minus=p.b1, b2=p.b2, **levels)
    force, body = np.empty((len(times) - 1) * _SUBSTEPS + 1), np.empty((len(times), 2))
    run_axis(times, x, v, np.full_like(times, -0.005), np.zeros_like(times), laws, _SUBSTEPS, force, body)
    return force[::_SUBSTEPS], body[:, 1]


def compare(motion: Motion, friction: Friction) -> tuple[float, float, float]:
    """Set-up 1's object under one motion, by `simulate` and by the independent integration.

    Returns:
        RMS of the difference in force [N]; RMS of the force [N]; largest difference in time of a beginning or end of
        sticking, in steps, infinite if their numbers differ.
    """
    t = np.arange(0.0, DURATION, STEP)
    x, v = (np.array([f(s) for s in t]) for f in motion)
    still = np.zeros_like(t)
    columns = {"position_x": still, "position_y": x, "position_z": still - 0.005}
    columns |= {"velocity_x": still, "velocity_y": v, "velocity_z": still}
    p, recording = BoxParameters(), Recording(t, columns)
    model = FlexibleBoxModel(p, friction=friction)
    force, body = np.empty((len(t), 3)), np.empty((len(t), 4))
    contact = np.full(len(t), box.CONTACT_BY_GEOMETRY)
    position, velocity = recording.vector("position"), recording.vector("velocity")
    box.replay(t, position, velocity, contact, model.kernel_vector(), force, body)
    expected, rate = independent(x, v, t, p, friction)
    ends, expected_ends = (np.flatnonzero(np.diff((speed == 0.0).astype(int))) for speed in (body[:, 3], rate))
    apart = float(np.abs(ends - expected_ends).max(initial=0)) if len(ends) == len(expected_ends) else math.inf
    return _rms(simulate(model, recording)["force_y"] - expected), _rms(expected), apart


def measurements() -> Iterator[Measurement]:
    """Errors relative to the RMS force, one figure a case."""
    cases = (
        ("smooth motion, no friction", fast(), Friction(), 1e-6),
        ("Karnopp friction of the thesis, fast strokes", fast(), THESIS_FRICTION, 1e-3),
        ("Karnopp friction of the thesis, slow strokes", slow(), THESIS_FRICTION, 1e-3),
    )
    for name, motion, friction, target in cases:
        error, force, _ = compare(motion, friction)
        yield Measurement(f"error against time stepping: {name}", error / force, "of RMS force", target)
    for name, motion in (("fast", fast()), ("slow", slow())):
        what = f"against time stepping: 2 N of Coulomb friction, {name} strokes"
        error, _, apart = compare(motion, Friction.coulomb(2.0))
        yield Measurement(f"error {what}", error / 2.0, "of friction force", 1e-2)
        yield Measurement(f"ends of sticking {what}, largest difference", apart, "steps", 1.0)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
