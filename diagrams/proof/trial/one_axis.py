"""A driven body, a transmission and a Kelvin-Voigt contact with concealed effects, the first two stepped by `plant`.

The driven body follows a reference under a proportional-derivative controller, and its recording gives the actuator's
command as input, as a servo's log does. The transmission's input is a hand's motion. The Kelvin-Voigt contact is a
material test: a probe moves it about.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit
from scipy.interpolate import CubicSpline

from mmt_drake.diagrams.proof.trial.laws import LAWS, Concealed
from mmt_drake.diagrams.proof.trial.motions import strokes
from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.diagrams.proof.trial.plant import run_axis
from mmt_drake.diagrams.proof.trial.sensor import Sensor
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording

Values = Mapping[str, float]

_STEP_S = 2e-5
_RATE_HZ = 1000.0


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
        rate = 2.0 * math.pi * self.bandwidth_hz
        gains = base["m"] * rate**2, 1.4 * base["m"] * rate
        drive, x = run_servo(time, wanted, wanted_v, gains, servo(base, effects))
        lag = math.fsum(effect.parameters["tau"] for effect in effects if effect.name == "input_lag")
        return drive + lag * np.gradient(drive, time), x  # the command, behind which the drive lags


def run_servo(
    time: Array, wanted: Array, wanted_v: Array, gains: tuple[float, float], p: Physics
) -> tuple[Array, Array]:
    """A body that a controller has follow a reference, from rest at 0.

    Args:
        time: (n,) [s], evenly spaced.
        wanted, wanted_v: (n,) reference and its rate; the reference begins at 0.
        gains: of position and rate [N/m], [N s/m].
        p: the laws.

    Returns:
        The command (n,) [N] and the position (n,) [m].
    """
    force, x = _held(time, wanted, wanted_v, p._replace(k2=gains[0], b2=gains[1]))
    return -force, x


def _held(time: Array, probe: Array, probe_v: Array, p: Physics) -> tuple[Array, Array]:
    """Force on a probe that never lets go of a body (n,) [N], and the body's position (n,) [m]."""
    substeps = round((time[1] - time[0]) / _STEP_S)
    force, body = np.empty((len(time) - 1) * substeps + 1), np.empty((len(time), 2))
    held, still = np.full_like(time, -1.0), np.zeros_like(time)
    run_axis(time, probe, probe_v, held, still, p._replace(normal_k=0.0, normal_b=0.0), substeps, force, body)
    return force[::substeps], np.ascontiguousarray(body[:, 0])


def servo(base: Values, effects: tuple[Concealed, ...]) -> Physics:
    """A servo's body with these effects."""
    b, Fc, F = base["b"], base["Fc"], base["offset"] - base["m"] * base["gravity"]
    p = Physics(m=base["m"], k1=base["k"], b_plus=b, b_minus=b, F=F, pendulum=base["pendulum"])
    p = p._replace(Fd_plus=Fc, Fd_minus=Fc, Fs_plus=Fc, Fs_minus=Fc)
    for effect in effects:
        if effect.name == "nonlinear_stiffness":  # of its own spring, not of the controller's
            p = p._replace(body_k3=effect.parameters["k3"])
        else:
            p = LAWS[effect.name].plant(p, effect.parameters)
    return p


@dataclass(frozen=True)
class TransmissionSession:
    """A drive train whose input a hand turns; both ends have an encoder.

    Attributes:
        seed: of the motion and of the encoders' noise.
        noise: standard deviation of either position's noise [m].
    """

    seed: int
    noise: float = 2e-5

    def record(self, base: Values, effects: tuple[Concealed, ...]) -> Recording:
        """Input and output with these effects."""
        time, u, _ = _reference(self.seed)
        error = np.random.default_rng((self.seed, 1)).normal(0.0, self.noise, (2, len(time)))
        return Recording(time, {"input": u + error[0], "output": self.true_reading(base, effects) + error[1]})

    def true_reading(self, base: Values, effects: tuple[Concealed, ...]) -> Array:
        """The output (n,) without noise [m]."""
        time, u, rate = _reference(self.seed)
        Fc, ratio = base["Fc"], base["ratio"]
        p = Physics(m=base["m"], k2=base["k"], b2=base["b"], b_plus=base["c"], b_minus=base["c"])
        p = p._replace(Fd_plus=Fc, Fd_minus=Fc, Fs_plus=Fc, Fs_minus=Fc)
        for effect in effects:
            p = LAWS[effect.name].plant(p, effect.parameters)
        return base["offset"] + _held(time, ratio * u, ratio * rate, p)[1]


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
        if p := law.get("hardening_relaxation"):
            force -= p["k3_maxwell"] * _relaxing(time, d**3, p["tau"])
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
