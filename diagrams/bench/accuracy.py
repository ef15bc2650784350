"""Errors of plant, renderer and `simulate` against the trial's time stepping, which shares no code with them."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagrams.stations.environment import THESIS_FRICTION
from mmt_drake.diagrams.studies.measurement import Measurement
from mmt_drake.diagrams.trial.physics import Physics
from mmt_drake.diagrams.trial.plant import run_axis
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.recording import Recording
from mmt_drake.simulate import simulate

Array = NDArray[np.float64]
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


@dataclass(frozen=True)
class AgainstStepping:
    """Set-up 1's object under one motion, ours and independent, (n,) each.

    Attributes:
        force, stuck: of `simulate` [N], and whether the body of the kernel it runs rests.
        expected_force, expected_stuck: the same of the independent integration.
    """

    force: Array
    stuck: NDArray[np.bool_]
    expected_force: Array
    expected_stuck: NDArray[np.bool_]

    def force_error(self) -> float:
        """RMS of the difference in force [N]."""
        return _rms(self.force - self.expected_force)

    def boundary_error(self) -> float:
        """Largest difference in time of a beginning or end of sticking, in steps; infinite if their numbers differ."""
        ours, expected = (np.flatnonzero(np.diff(stuck.astype(int))) for stuck in (self.stuck, self.expected_stuck))
        return float(np.abs(ours - expected).max(initial=0)) if len(ours) == len(expected) else math.inf


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


def compare(motion: Motion, friction: Friction) -> AgainstStepping:
    """Run one motion through `simulate` and through the independent integration."""
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
    return AgainstStepping(simulate(model, recording)["force_y"], body[:, 3] == 0.0, expected, rate == 0.0)


def measurements() -> Iterator[Measurement]:
    """Errors relative to the RMS force, one figure a case."""
    cases = (
        ("smooth motion, no friction", fast(), Friction(), 1e-6),
        ("Karnopp friction of the thesis, fast strokes", fast(), THESIS_FRICTION, 1e-3),
        ("Karnopp friction of the thesis, slow strokes", slow(), THESIS_FRICTION, 1e-3),
    )
    for name, motion, friction, target in cases:
        compared = compare(motion, friction)
        error = compared.force_error() / _rms(compared.expected_force)
        yield Measurement(f"error against time stepping: {name}", error, "of RMS force", target)
    for name, motion in (("fast", fast()), ("slow", slow())):
        compared, what = compare(motion, Friction.coulomb(2.0)), f"2 N of Coulomb friction, {name} strokes"
        yield Measurement(
            f"error against time stepping: {what}", compared.force_error() / 2.0, "of friction force", 1e-2
        )
        yield Measurement(
            f"ends of sticking against time stepping: {what}, largest difference",
            compared.boundary_error(),
            "steps",
            1.0,
        )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
