"""The numbers of all laws of the trial's plant."""

import math
from typing import NamedTuple


class Physics(NamedTuple):
    """Every number of the plant's laws; the defaults leave an effect out. SI units.

    Blocks are those of the effects; what no effect of the library describes is marked *outside*.
    """

    # the linear object and the axis normal to the table
    m: float = 1.0
    k1: float = 0.0
    k2: float = 500.0
    b2: float = 60.0
    normal_k: float = 500.0
    normal_b: float = 60.0
    # body, of a servo: a spring that stiffens, a pendulum's moment
    body_k3: float = 0.0
    pendulum: float = 0.0
    # friction: damping, sliding and holding levels in either direction, Karnopp's band, Stribeck's velocity, bristles
    b_plus: float = 0.0
    b_minus: float = 0.0
    Fd_plus: float = 0.0
    Fd_minus: float = 0.0
    Fs_plus: float = 0.0
    Fs_minus: float = 0.0
    v_d: float = 0.0
    v_s: float = 0.0
    sigma0: float = 0.0
    sigma1: float = 0.0
    mu: float = 0.0
    c: float = 0.0
    # friction, outside: a rough patch, ageing at rest, softening of the damping by its own heat
    patch_F: float = 0.0
    patch_from: float = 0.0
    patch_to: float = 0.0
    patch_edge: float = 1e-3
    ageing_F: float = 0.0
    ageing_time: float = 1.0
    ageing_distance: float = 1.0
    heat_power: float = math.inf
    heat_tau: float = 1.0
    # friction, a remainder: a level that wanders, a force with |v|^1.5
    wander_F: float = 0.0
    wander_period: float = 1.0
    drag: float = 0.0
    # contact: deflection law, Maxwell branch, Bouc-Wen, clearance, drift
    k3: float = 0.0
    hunt_crossley: float = 0.0
    k_maxwell: float = 0.0
    tau: float = 1.0
    alpha: float = 0.0
    beta: float = 0.0
    gamma: float = 0.0
    gap: float = 0.0
    drift_rate: float = 0.0
    # contact, outside: running in, stiffening under load, slip of the probe, a step of stiffness
    run_in: float = 0.0
    run_in_distance: float = 1.0
    load_gain: float = 0.0
    load_at: float = 1.0
    load_width: float = 1.0
    slip_mu: float = math.inf
    step_loss: float = 0.0
    step_time: float = math.inf
    # body
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
    # body, outside: a loose part that rattles, a table that shakes with a rising frequency
    loose_m: float = 0.0
    loose_clearance: float = 0.0
    loose_restitution: float = 0.0
    table_amplitude: float = 0.0
    table_from: float = 0.0
    table_rate: float = 0.0
    # body, a remainder: texture of the table, three waves of lengths without a common multiple
    texture_F: float = 0.0
    texture_length: float = 1.0
