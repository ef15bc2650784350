"""A driven body and a Kelvin-Voigt contact with concealed effects, by the same time stepping as `plant`.

The driven body follows a reference under a proportional-derivative controller, and its recording gives the actuator's
command as input, as a servo's log does. The Kelvin-Voigt contact is a material test: a probe moves it about.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from mmt_drake.diagrams.trial.laws import Concealed
from mmt_drake.diagrams.trial.motions import strokes
from mmt_drake.diagrams.trial.sensor import Sensor
from mmt_drake.recording import Recording

Array = NDArray[np.float64]
Values = Mapping[str, float]

_STEP_S = 2e-5
_RATE_HZ = 1000.0


class DrivenPhysics(NamedTuple):
    """A driven body's numbers, SI units; the defaults leave an effect out."""

    m: float = 1.0
    k: float = 0.0
    b_plus: float = 0.0
    b_minus: float = 0.0
    Fd_plus: float = 0.0
    Fd_minus: float = 0.0
    Fs_plus: float = 0.0
    Fs_minus: float = 0.0
    v_s: float = 0.0
    c: float = 0.0
    k3: float = 0.0
    F: float = 0.0
    pendulum: float = 0.0
    mass_time: float = math.inf
    dm: float = 0.0
    stop_position: float = 0.0
    stop_stiffness: float = 0.0
    stop_side: float = 1.0


@njit(cache=True)
def run_driven(
    time: Array,
    wanted: Array,
    wanted_v: Array,
    kp: float,
    kd: float,
    p: DrivenPhysics,
    substeps: int,
    u: Array,
    x: Array,
) -> None:
    """A driven body that follows a reference from rest on it.

    Args:
        time: (n,) [s], increasing.
        wanted, wanted_v: (n,) reference and its rate, linear between samples.
        kp, kd: the controller's gains [N/m], [N s/m].
        p: the laws.
        substeps: steps per sample.
        u: (n,) to be filled with the command [N].
        x: (n,) to be filled with the position [m].
    """
    q, v, stuck = wanted[0], 0.0, True
    for i in range(len(time)):
        u[i] = kp * (wanted[i] - q) + kd * (wanted_v[i] - v)
        x[i] = q
        if i == len(time) - 1:
            break
        h = (time[i + 1] - time[i]) / substeps
        for j in range(substeps):
            part = (j + 0.5) / substeps
            t = time[i] - time[0] + (j + 0.5) * h
            half = q + 0.5 * h * v
            reference = wanted[i] + part * (wanted[i + 1] - wanted[i])
            reference_v = wanted_v[i] + part * (wanted_v[i + 1] - wanted_v[i])
            drive = kp * (reference - half) + kd * (reference_v - v) - p.k * half + p.F
            drive -= p.pendulum * math.sin(half) + p.c * v * abs(v) + p.k3 * half**3
            into = (half - p.stop_position) * p.stop_side
            if into > 0.0:
                drive -= p.stop_side * p.stop_stiffness * into
            b = p.b_plus if v >= 0.0 else p.b_minus
            mass = p.m + (p.dm if t >= p.mass_time else 0.0)
            dip = math.exp(-((v / p.v_s) ** 2)) if p.v_s > 0.0 else 0.0
            if stuck and -p.Fs_minus <= drive <= p.Fs_plus:
                v_end = 0.0
            else:
                forward = drive > 0.0 if stuck else v > 0.0
                slide_high = p.Fd_plus + (p.Fs_plus - p.Fd_plus) * dip
                slide_low = p.Fd_minus + (p.Fs_minus - p.Fd_minus) * dip
                inertia = mass + 0.5 * h * b
                v_end = ((mass - 0.5 * h * b) * v + h * (drive - (slide_high if forward else -slide_low))) / inertia
                stuck = (v_end > 0.0) != forward
                if stuck:
                    v_end = 0.0
            q += 0.5 * h * (v + v_end)
            v = v_end


@dataclass(frozen=True)
class DrivenSession:
    """A servo that follows a hand's strokes.

    Attributes:
        seed: of the reference and the encoder's noise.
        noise: standard deviation of the position's noise [m]; the output is what is compared.
        bandwidth_hz: of the controller.
    """

    seed: int
    noise: float = 2e-5
    bandwidth_hz: float = 3.0
    style: str = "rich"

    def record(self, base: Values, effects: tuple[Concealed, ...]) -> Recording:
        """Command and position of the servo with these effects."""
        time, _, _ = _reference(self.seed)
        u, x = self._run(base, effects)
        error = np.random.default_rng((self.seed, 1)).normal(0.0, self.noise, len(time))
        return Recording(time, {"input": u, "output": x + error})

    def true_reading(self, base: Values, effects: tuple[Concealed, ...]) -> Array:
        """The position (n,) without noise [m]."""
        return self._run(base, effects)[1]

    def _run(self, base: Values, effects: tuple[Concealed, ...]) -> tuple[Array, Array]:
        time, wanted, wanted_v = _reference(self.seed)
        u, x = np.empty_like(time), np.empty_like(time)
        rate = 2.0 * math.pi * self.bandwidth_hz
        kp, kd = base["m"] * rate**2, 1.4 * base["m"] * rate
        substeps = round(1.0 / (_RATE_HZ * _STEP_S))
        run_driven(time, wanted, wanted_v, kp, kd, _driven(base, effects), substeps, u, x)
        return u, x


def _driven(base: Values, effects: tuple[Concealed, ...]) -> DrivenPhysics:
    b, Fc, offset = base["b"], base["Fc"], base["offset"]
    p = DrivenPhysics(base["m"], base["k"], b, b, Fc, Fc, Fc, Fc, F=offset - base["m"] * base["gravity"])
    p = p._replace(pendulum=base["pendulum"])
    for effect in effects:
        p = _DRIVEN_LAWS[effect.name](p, effect.parameters)
    return p


def _driven_levels(p: DrivenPhysics, plus: float, minus: float) -> DrivenPhysics:
    return p._replace(Fd_plus=plus, Fs_plus=plus, Fd_minus=minus, Fs_minus=minus)


_DRIVEN_LAWS: Final[dict[str, Callable[[DrivenPhysics, Values], DrivenPhysics]]] = {
    "viscous_friction": lambda s, p: s._replace(b_plus=s.b_plus + p["b"], b_minus=s.b_minus + p["b"]),
    "asymmetric_viscous_friction": lambda s, p: s._replace(b_plus=p["b_plus"], b_minus=p["b_minus"]),
    "coulomb_friction": lambda s, p: _driven_levels(s, s.Fd_plus + p["Fc"], s.Fd_minus + p["Fc"]),
    "asymmetric_friction": lambda s, p: _driven_levels(s, p["Fc_plus"], p["Fc_minus"]),
    "stribeck_friction": lambda s, p: s._replace(Fs_plus=p["Fs"], Fs_minus=p["Fs"], v_s=p["v_s"]),
    "quadratic_drag": lambda s, p: s._replace(c=p["c"]),
    "nonlinear_stiffness": lambda s, p: s._replace(k3=p["k3"]),
    "constant_force": lambda s, p: s._replace(F=s.F + p["F"]),
    "ground_spring": lambda s, p: s._replace(k=s.k + p["k"]),
    "mass_change": lambda s, p: s._replace(mass_time=p["time"], dm=p["dm"]),
    "end_stop": lambda s, p: s._replace(
        stop_position=p["position"], stop_stiffness=p["stiffness"], stop_side=p["side"]
    ),
}
DRIVEN: Final[tuple[str, ...]] = tuple(_DRIVEN_LAWS)
"""Names of the effects that a driven body can have concealed."""


@lru_cache(maxsize=4)
def _reference(seed: int) -> tuple[Array, Array, Array]:
    """Times [s], and a hand's motion that starts at rest [m], [m/s], each (n,)."""
    rng = np.random.default_rng((seed, 0))
    time = np.arange(30_000) / _RATE_HZ
    motion = strokes(rng, time) * np.clip(time / 2.0, 0.0, 1.0) ** 2 * (3.0 - 2.0 * np.clip(time / 2.0, 0.0, 1.0))
    return time, motion, CubicSpline(time, motion)(time, 1)


@dataclass(frozen=True)
class MaterialSession:
    """A probe that moves a spring and a damper about, beginning where the spring rests.

    Attributes:
        seed: of the motion and the sensors' noise.
        noise: standard deviation [N].
    """

    seed: int
    noise: float = 0.02
    style: str = "rich"

    def true_reading(self, base: Values, effects: tuple[Concealed, ...]) -> Array:
        """The reading without noise (n,) [N]."""
        time, d, v = self._motion()
        law = {effect.name: effect.parameters for effect in effects}
        k = base["k"] * (1.0 + law.get("stiffness_drift", {"rate": 0.0})["rate"] * (time - time[0]))
        damping = base["b"] * (1.0 + law.get("hunt_crossley_damping", {"lambda": 0.0})["lambda"] * np.abs(d))
        force = -k * d - damping * v - law.get("nonlinear_stiffness", {"k3": 0.0})["k3"] * d**3
        force -= law.get("quadratic_drag", {"c": 0.0})["c"] * v * np.abs(v)
        force -= law.get("coulomb_friction", {"Fc": 0.0})["Fc"] * np.sign(v)
        if p := law.get("viscoelastic_relaxation"):
            force -= p["k_maxwell"] * _relaxing(time, d, p["tau"])
        if p := law.get("hysteresis"):
            force -= p["alpha"] * _bouc_wen(d, p["beta"])
        sensor = Sensor(
            lag=law.get("force_lag", {"tau": 0.0})["tau"],
            delay=law.get("time_delay", {"delay": 0.0})["delay"],
            bias=base["F0"],
        )
        return sensor.tangential(time, sensor.arrival(time, force, time), np.zeros_like(force))

    def record(self, base: Values, effects: tuple[Concealed, ...]) -> Recording:
        """Position, velocity and force of the test."""
        time, d, v = self._motion()
        rng = np.random.default_rng((self.seed, 1))
        columns = {
            "position": base["x0"] + d + rng.normal(0.0, 1e-5, len(time)),
            "velocity": v + rng.normal(0.0, 5e-4, len(time)),
            "force": self.true_reading(base, effects) + rng.normal(0.0, self.noise, len(time)),
        }
        return Recording(time, columns)

    def _motion(self) -> tuple[Array, Array, Array]:
        """Times, deflection and its rate: sines, never still for long, as a material test has them."""
        rng = np.random.default_rng((self.seed, 0))
        time = np.arange(30_000) / _RATE_HZ
        d = np.zeros_like(time)
        for f in np.geomspace(0.1, 4.0, 7) * rng.uniform(0.9, 1.1, 7):
            d += rng.uniform(0.5, 1.0) * 0.003 / f**0.5 * np.sin(2.0 * np.pi * f * time)
        return time, d, CubicSpline(time, d)(time, 1)


MATERIAL: Final[tuple[str, ...]] = (
    "nonlinear_stiffness",
    "hunt_crossley_damping",
    "viscoelastic_relaxation",
    "hysteresis",
    "stiffness_drift",
    "quadratic_drag",
    "coulomb_friction",
    "force_lag",
    "time_delay",
)
"""Names of the effects that a Kelvin-Voigt contact can have concealed.

A bias is none of them: beside a rest position that is a parameter it is nothing but another rest position."""


def _relaxing(time: Array, d: Array, tau: float) -> Array:
    """d - q of a Maxwell branch, q' = (d - q)/tau, q = d at first: what a first-order lag falls short of d."""
    return d - Sensor(lag=tau).arrival(time, d, time)


@njit(cache=True)
def _bouc_wen(d: Array, beta: float) -> Array:
    """z of Bouc and Wen with gamma = beta, n = 1, exactly: loading, z relaxes to 1 / (2 beta); unloading, z' = d'."""
    z = np.zeros_like(d)
    for i in range(1, len(d)):
        rise, before = d[i] - d[i - 1], z[i - 1]
        if rise * before < 0.0:  # unloading, until z is 0
            free = min(abs(rise), abs(before))
            before += math.copysign(free, rise)
            rise -= math.copysign(free, rise)
        if rise != 0.0:
            most = math.copysign(0.5 / beta, rise)
            before = most + (before - most) * math.exp(-2.0 * beta * abs(rise))
        z[i] = before
    return z
