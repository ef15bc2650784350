"""The numbers of all laws of the foreign object."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput

_PER_STEP = 0.5
"""Greatest product of a step and the body's fastest rate; explicit Runge-Kutta steps are stable up to 2.8."""


class Numbers(NamedTuple):
    """Every number of the laws; the defaults leave a law out. SI units; vectors stand in the plane of the table."""

    # the object, and the axis normal to the table
    m: float = 1.0
    k1: float = 0.0
    k2: float = 500.0
    b1: float = 60.0
    b2: float = 60.0
    normal_k: float = 500.0
    normal_b: float = 60.0
    surface: float = 0.0  # height at which the probe touches
    # friction as a vector: level that holds, level that slides, Stribeck's speed, LuGre's bristles, mu of the load,
    # c |v| v, a level that wanders about, drag |v|^0.5 v
    Fs: float = 0.0
    Fd: float = 0.0
    v_s: float = 0.0
    sigma0: float = 0.0
    sigma1: float = 0.0
    mu: float = 0.0
    c: float = 0.0
    wander_F: float = 0.0
    wander_period: float = 1.0
    drag: float = 0.0
    # contact: k3 |d|^2 d, b2 (1 + hunt_crossley |d|), Maxwell branch, Bouc-Wen, clearance, drift, a step of k2, and the
    # tip that slips beyond slip_mu of the load
    k3: float = 0.0
    hunt_crossley: float = 0.0
    k_maxwell: float = 0.0
    tau: float = 1.0
    alpha: float = 0.0
    beta: float = 0.0
    gamma: float = 0.0
    gap: float = 0.0
    drift_rate: float = 0.0
    step_loss: float = 0.0
    step_time: float = math.inf
    slip_mu: float = math.inf
    # body, on both axes alike: force, change of mass, second mode, wall, ripple, texture, a spring that comes late
    F: float = 0.0
    mass_time: float = math.inf
    dm: float = 0.0
    mode_m: float = 0.0
    mode_k: float = 0.0
    mode_b: float = 0.0
    stop_position: float = 0.0
    stop_stiffness: float = 0.0
    stop_side: float = 1.0
    ripple_F: float = 0.0
    ripple_period: float = 1.0
    ripple_phase: float = 0.0
    texture_F: float = 0.0
    texture_length: float = 1.0
    ground_k: float = 0.0
    ground_time: float = math.inf
    # time constant of the force sensor's first-order low pass
    lag: float = 0.0

    def checked(self, step: float) -> NDArray[np.void]:
        """What the kernels read: one record, (1,).

        Args:
            step: longest of the integration [s].

        Raises:
            BadInput: the body is too light, or held too stiffly, for steps that long.
        """
        mass = self.m + min(self.dm, 0.0)
        stiffness = self.k1 + self.k2 * (1.0 + max(-self.step_loss, 0.0)) + self.k_maxwell + self.alpha
        stiffness += self.ground_k + self.stop_stiffness + self.sigma0 + self.mode_k
        damping = self.b1 + self.b2 + self.sigma1 + self.mode_b
        rate = math.sqrt(stiffness / mass) + damping / mass if mass > 0.0 else math.inf
        if not rate * step <= _PER_STEP:
            found = f"{mass:g} on springs of {stiffness:g} and dampers of {damping:g}"
            expected = f"a heavier body, or a softer hold: steps of {step:g} s cannot follow it"
            raise BadInput("environment", at="m", found=found, expected=expected)
        return np.array([tuple(self)], dtype=[(name, np.float64) for name in self._fields])
