"""Motions, and what the trial's engine answers to them."""

import math
from collections.abc import Callable

import numpy as np

from mmt_drake.diagrams.proof.trial.laws import Concealed, linear_object, with_effects
from mmt_drake.diagrams.proof.trial.motions import ProbeMotion
from mmt_drake.diagrams.proof.trial.plant import QUICK_STEP_S
from mmt_drake.diagrams.proof.trial.sensor import Sensor
from mmt_drake.diagrams.proof.trial.session import tangential_readings
from mmt_drake.numeric.arrays import Array

BASE = {"m": 0.5, "k1": 0.0, "k2": 500.0, "b1": 20.0, "b2": 25.0, "Fc": 0.0, "normal_k": 400.0, "normal_b": 8.0}
DEPTH = 0.01


def along_y(
    y: Callable[[Array], Array], v: Callable[[Array], Array], seconds: float, rate: float = 1000.0
) -> ProbeMotion:
    """A probe pressed in by DEPTH throughout, moving along y as a function of time."""
    time = np.arange(round(seconds * rate) + 1) / rate
    still = np.zeros_like(time)
    position = np.column_stack([still, y(time), still - DEPTH])
    return ProbeMotion(time, position, np.column_stack([still, v(time), still]), moves_x=False)


def sine(amplitude: float, hertz: float, seconds: float) -> ProbeMotion:
    w = 2.0 * math.pi * hertz
    return along_y(lambda t: amplitude * np.sin(w * t), lambda t: amplitude * w * np.cos(w * t), seconds)


def ramp(speed: float, seconds: float) -> ProbeMotion:
    return along_y(lambda t: speed * t, lambda t: np.full_like(t, speed), seconds)


def run(motion: ProbeMotion, *effects: Concealed, **base: float) -> tuple[Array, Array]:
    """Reading along y (n,) and the body's motion (n, 2)."""
    physics, sensor = with_effects(linear_object({**BASE, **base}), Sensor(), effects)
    (force,), body = tangential_readings(
        physics, sensor, motion, step=QUICK_STEP_S
    )  # a quarter of the time, and enough
    return force, body


# Effects at the value where they vanish.
VANISHED: dict[str, dict[str, float]] = {
    "frame_misalignment": {"rx": 0.0, "ry": 0.0, "rz": 0.0},
    "viscous_friction": {"b": 0.0},
    "asymmetric_viscous_friction": {"b_plus": 20.0, "b_minus": 20.0},
    "coulomb_friction": {"Fc": 0.0},
    "asymmetric_friction": {"Fc_plus": 0.3, "Fc_minus": 0.3},
    "static_friction": {"Fs": 0.3, "Fd": 0.3, "v_d": 0.0},
    "stribeck_friction": {"Fs": 0.3, "v_s": 0.02},
    "load_dependent_friction": {"mu": 0.0},
    "quadratic_drag": {"c": 0.0},
    "nonlinear_stiffness": {"k3": 0.0},
    "hunt_crossley_damping": {"lambda": 0.0},
    "viscoelastic_relaxation": {"k_maxwell": 0.0, "tau": 0.1},
    "hysteresis": {"alpha": 0.0, "beta": 100.0},
    "contact_gap": {"gap": 0.0},
    "stiffness_drift": {"rate": 0.0},
    "stiffness_step": {"loss": 0.0, "time": 1.0},
    "constant_force": {"F": 0.0},
    "ground_spring": {"k": 0.0},
    "mass_change": {"time": 1.0, "dm": 0.0},
    "second_mode": {"m2": 0.2, "k": 0.0, "b": 0.0},
    "end_stop": {"position": 1.0, "stiffness": 1e3, "side": 1.0},
    "torque_ripple": {"amplitude": 0.0, "period": 0.02, "phase": 0.5},
    "force_bias": {"bias": 0.0},
    "force_drift": {"rate": 0.0},
    "force_lag": {"tau": 0.0},
    "force_crosstalk": {"gain": 0.0},
    "force_saturation": {"limit": 1e3},
    "periodic_disturbance": {"amplitude": 0.0, "frequency": 3.0, "phase": 0.5},
    "tip_mass": {"m_tip": 0.0},
    "time_delay": {"delay": 0.0},
    "rough_patch": {"F": 0.0, "from": -0.01, "to": 0.01},
    "ageing_friction": {"F": 0.0, "time": 0.01, "distance": 0.01},
    "frictional_heating": {"power": math.inf, "tau": 1.0},
    "run_in_softening": {"loss": 0.0, "distance": 0.1},
    "load_stiffening": {"gain": 0.0, "load": 4.0, "width": 0.4},
    "probe_slip": {"mu": math.inf},
    "loose_mass": {"m": 0.0, "clearance": 0.01, "restitution": 0.5},
    "table_vibration": {"amplitude": 0.0, "frequency": 2.0, "rate": 0.1},
    "sensor_play": {"width": 0.0},
    "clock_drift": {"rate": 0.0},
    "texture": {"F": 0.0, "length": 0.02},
    "wandering_friction": {"F": 0.0, "period": 10.0},
    "flicker_noise": {"amplitude": 0.0, "seed": 1.0},
    "power_drag": {"c": 0.0},
}
