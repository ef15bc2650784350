"""Sizes of concealed effects: parameters over the range from barely visible to plain."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from mmt_drake.numeric.arrays import Array

Values = dict[str, float]


@dataclass(frozen=True)
class Baseline:
    """What an effect's size is measured against: the same recording without it.

    Attributes:
        rng: for everything that is not the size.
        base: the true parameters of the linear object and Fc.
        duration: of the recording [s].
        force: (n,) tangential force in contact [N].
        travel: (n,) displacement of the body in contact [m].
        load: (n,) normal load in contact [N].
    """

    rng: np.random.Generator
    base: Mapping[str, float]
    duration: float
    force: Array
    travel: Array
    load: Array

    def sign(self) -> float:
        """Either sign."""
        return float(self.rng.choice([-1.0, 1.0]))

    def between(self, low: float, high: float) -> float:
        """Log-uniform."""
        return float(low * (high / low) ** self.rng.random())

    def natural(self, hertz: float, mass: float) -> float:
        """Stiffness [N/m] that gives a mass this frequency."""
        return mass * (2.0 * math.pi * hertz) ** 2


def log(low: float, high: float, size: float) -> float:
    """The value at `size` (0 to 1) of a logarithmic range."""
    return low * (high / low) ** size


def _asymmetric(scene: Baseline, mean: float, low: float, high: float, size: float) -> tuple[float, float]:
    part = scene.sign() * log(low, high, size)
    return mean * (1.0 + part), mean * (1.0 - part)


def _asymmetric_viscous(scene: Baseline, size: float) -> Values:
    plus, minus = _asymmetric(scene, scene.base["b1"], 0.04, 0.6, size)
    return {"b_plus": plus, "b_minus": minus}


def _asymmetric_friction(scene: Baseline, size: float) -> Values:
    plus, minus = _asymmetric(scene, scene.base["Fc"], 0.06, 0.7, size)
    return {"Fc_plus": plus, "Fc_minus": minus}


def _static(scene: Baseline, size: float) -> Values:
    Fd = scene.base["Fc"]
    return {"Fs": Fd * (1.0 + log(0.3, 8.0, size)), "Fd": Fd, "v_d": scene.between(0.003, 0.015)}


def _stribeck(scene: Baseline, size: float) -> Values:
    return {"Fs": scene.base["Fc"] * (1.0 + log(0.3, 8.0, size)), "v_s": scene.between(0.01, 0.06)}


def _presliding(scene: Baseline, size: float) -> Values:
    return {"sigma0": scene.base["Fc"] / log(1e-4, 4e-3, size)}  # how far the bristles give: 0.1 to 4 mm


def _cubic(scene: Baseline, size: float) -> Values:
    part, most = log(0.04, 4.0, size), float(np.max(np.abs(scene.force))) / scene.base["k2"]
    if scene.rng.random() < 0.4:
        part = -min(part, 0.3)  # softens, but not so far that the spring gives way
    return {"k3": part * scene.base["k2"] / most**2}


def _hunt_crossley(scene: Baseline, size: float) -> Values:
    return {"lambda": log(0.1, 12.0, size) * scene.base["k2"] / float(np.max(np.abs(scene.force)))}


def _drift(scene: Baseline, size: float) -> float:
    """Part of the stiffness gained or lost over the recording; some of it is always left."""
    part = scene.sign() * log(0.04, 1.5, size)
    return max(part, -0.7)


def _relaxation(scene: Baseline, size: float) -> Values:
    return {"k_maxwell": log(0.04, 2.5, size) * scene.base["k2"], "tau": scene.between(0.03, 0.6)}


def _hysteresis(scene: Baseline, size: float) -> Values:
    return {"alpha": log(0.05, 4.0, size) * scene.base["k2"], "beta": 0.5 / scene.between(0.0003, 0.002)}


def _mass_change(scene: Baseline, size: float) -> Values:
    part = log(0.05, 2.5, size)
    if scene.rng.random() < 0.5:
        part = -min(part, 0.5)
    return {"time": scene.duration * scene.rng.uniform(0.3, 0.7), "dm": part * scene.base["m"]}


def _stiffness_step(scene: Baseline, size: float) -> Values:
    return {"time": scene.duration * scene.rng.uniform(0.35, 0.65), "loss": log(0.02, 0.6, size)}


def _second_mode(scene: Baseline, size: float) -> Values:
    m2, hertz = log(0.04, 1.2, size) * scene.base["m"], scene.between(1.5, 6.0)
    k = scene.natural(hertz, m2)
    return {"m2": m2, "k": k, "b": 2.0 * scene.between(0.05, 0.3) * math.sqrt(k * m2)}


def _end_stop(scene: Baseline, size: float) -> Values:
    side, part = scene.sign(), 1.0 - log(0.003, 0.2, size)
    if np.quantile(side * scene.travel, part) < 0.002:
        side = -side  # the body starts away from the wall
    reach = float(np.quantile(side * scene.travel, part))
    return {"position": side * reach, "stiffness": scene.between(100.0, 3000.0), "side": side}


def _saturation(scene: Baseline, size: float) -> Values:
    return {"limit": float(np.quantile(np.abs(scene.force), 1.0 - log(0.003, 0.2, size)))}


def _periodic(scene: Baseline, size: float) -> Values:
    phase = float(scene.rng.uniform(-math.pi, math.pi))
    return {"amplitude": log(0.015, 0.6, size), "frequency": scene.between(0.7, 12.0), "phase": phase}


def _misalignment(scene: Baseline, size: float) -> Values:
    rx = math.radians(log(0.2, 4.0, size))
    others = {angle: scene.sign() * scene.between(0.3, 1.0) * rx for angle in ("ry", "rz")}
    return {"rx": scene.sign() * rx, **others}


def _rough_patch(scene: Baseline, size: float) -> Values:
    low, high = np.quantile(scene.travel, [0.3, 0.65])
    return {"F": log(0.3, 1.5, size), "from": float(low), "to": float(high)}


def _loose_mass(scene: Baseline, size: float) -> Values:
    m, clearance = log(0.2, 0.8, size) * scene.base["m"], scene.between(0.003, 0.01)
    return {"m": m, "clearance": clearance, "restitution": float(scene.rng.uniform(0.2, 0.6))}


def _table_vibration(scene: Baseline, size: float) -> Values:
    start, end = scene.rng.uniform(1.0, 2.0), scene.rng.uniform(5.0, 8.0)
    return {"amplitude": log(5e-4, 2e-3, size), "frequency": start, "rate": (end - start) / scene.duration}


def _load_stiffening(scene: Baseline, size: float) -> Values:
    load = float(np.median(scene.load))
    return {"gain": log(0.2, 1.0, size), "load": load, "width": 0.1 * load}


def _probe_slip(scene: Baseline, size: float) -> Values:
    return {"mu": float(np.quantile(np.abs(scene.force) / scene.load, 1.0 - log(0.04, 0.3, size)))}


def _run_in(scene: Baseline, size: float) -> Values:
    return {"loss": log(0.3, 0.75, size), "distance": 0.2 * float(np.sum(np.abs(np.diff(scene.travel))))}


def _heating(scene: Baseline, size: float) -> Values:
    mean_power = scene.base["b1"] * 0.04**2
    return {"power": mean_power / log(0.5, 3.0, size), "tau": scene.between(1.5, 5.0)}


SIZES: Final[dict[str, Callable[[Baseline, float], Values]]] = {
    "viscous_friction": lambda scene, size: {"b": log(0.7, 30.0, size)},
    "asymmetric_viscous_friction": _asymmetric_viscous,
    "coulomb_friction": lambda scene, size: {"Fc": log(0.02, 0.9, size)},
    "asymmetric_friction": _asymmetric_friction,
    "static_friction": _static,
    "stribeck_friction": _stribeck,
    "presliding_friction": _presliding,
    "load_dependent_friction": lambda scene, size: {"mu": log(0.008, 0.4, size)},
    "quadratic_drag": lambda scene, size: {"c": log(8.0, 600.0, size)},
    "nonlinear_stiffness": _cubic,
    "hunt_crossley_damping": _hunt_crossley,
    "viscoelastic_relaxation": _relaxation,
    "hysteresis": _hysteresis,
    "contact_gap": lambda scene, size: {"gap": log(2e-5, 4e-3, size)},
    "stiffness_drift": lambda scene, size: {"rate": _drift(scene, size) / scene.duration},
    "stiffness_step": _stiffness_step,
    "constant_force": lambda scene, size: {"F": scene.sign() * log(0.02, 0.6, size)},
    "ground_spring": lambda scene, size: {"k": log(1.0, 150.0, size)},
    "mass_change": _mass_change,
    "second_mode": _second_mode,
    "end_stop": _end_stop,
    "torque_ripple": lambda scene, size: {
        "amplitude": log(0.02, 0.8, size),
        "period": scene.between(0.008, 0.03),
        "phase": float(scene.rng.uniform(-math.pi, math.pi)),
    },
    "force_bias": lambda scene, size: {"bias": scene.sign() * log(0.01, 0.5, size)},
    "force_drift": lambda scene, size: {"rate": scene.sign() * log(0.02, 1.0, size) / scene.duration},
    "force_lag": lambda scene, size: {"tau": log(5e-4, 0.06, size)},
    "force_crosstalk": lambda scene, size: {"gain": scene.sign() * log(0.003, 0.15, size)},
    "force_saturation": _saturation,
    "periodic_disturbance": _periodic,
    "tip_mass": lambda scene, size: {"m_tip": log(0.003, 0.3, size)},
    "time_delay": lambda scene, size: {"delay": log(5e-4, 0.06, size)},
    "frame_misalignment": _misalignment,
    "rough_patch": _rough_patch,
    "ageing_friction": lambda scene, size: {
        "F": log(0.1, 0.35, size),
        "time": scene.between(0.01, 0.03),
        "distance": scene.between(0.002, 0.006),
    },
    "frictional_heating": _heating,
    "run_in_softening": _run_in,
    "load_stiffening": _load_stiffening,
    "probe_slip": _probe_slip,
    "loose_mass": _loose_mass,
    "table_vibration": _table_vibration,
    "sensor_play": lambda scene, size: {"width": log(0.15, 0.8, size)},
    "clock_drift": lambda scene, size: {"rate": log(0.01, 0.08, size) / scene.duration},
}
"""name -> parameters at a size from 0 (barely visible) to 1 (plain). Effects outside the library are all plain."""
