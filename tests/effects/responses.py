"""A model of each structure under a motion or an input with strokes, dwells, a touch and a changing load."""

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from mmt_drake.effects import LIBRARY
from mmt_drake.model import driven_body, flexible_box, kelvin_voigt, surface_contact
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import PositionOut
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model.transmission import TransmissionModel
from mmt_drake.motion.delay import delayed_motion, input_behind
from mmt_drake.motion.hand import HandOrientation

TIME = np.arange(3500) * 1e-3
MODELS = {
    "flexible_box": FlexibleBoxModel(BoxParameters(m=0.8, k1=0, k2=400, b1=5, b2=20, Fc=0.3), NormalContact(600, 20)),
    "kelvin_voigt": KelvinVoigt(k=400, b=20),
    "surface_contact": SurfaceContact(k=600, b=20),
    "driven_body": DrivenBodyModel(m=0.8, b=5, k=60, Fc=0.3, gravity=Gravity("pendulum", 4.0)),
    "transmission": TransmissionModel(ratio=0.5, offset=0.004, k=60, b=3, m=0.05, c=2, Fc=0.1),
    "transmission without mass": TransmissionModel(ratio=-0.5, offset=0.004, k=300, c=9, Fc=0.1),
}
#: Parameters that a person would notice.
SOME = {
    "viscous_friction": {"b": 9.0},
    "asymmetric_viscous_friction": {"b_plus": 30.0, "b_minus": 9.0},
    "coulomb_friction": {"Fc": 0.5},
    "asymmetric_friction": {"Fc_plus": 0.9, "Fc_minus": 0.5},
    "static_friction": {"Fs": 0.9, "Fd": 0.6, "v_d": 0.004},
    "stribeck_friction": {"Fs": 0.9, "v_s": 0.05},
    "presliding_friction": {"sigma0": 600.0, "sigma1": 1.0, "Fs": 0.9, "v_s": 0.1},
    "load_dependent_friction": {"mu": 0.2},
    "smooth_coulomb_friction": {"Fc": 0.6, "v_s": 0.03},
    "dahl_friction": {"Fc": 0.6, "sigma": 200.0},
    "elastoplastic_play": {"Fc": 0.6, "k": 200.0, "gap": 0.004},
    "quadratic_drag": {"c": 40.0},
    "nonlinear_stiffness": {"k3": 4e5},
    "hunt_crossley_damping": {"lambda": 60.0},
    "viscoelastic_relaxation": {"k_maxwell": 300.0, "tau": 0.1},
    "hardening_relaxation": {"k3_maxwell": 6e5, "tau": 0.1},
    "hysteresis": {"alpha": 300.0, "beta": 150.0},
    "contact_gap": {"gap": 0.004},
    "stiffness_drift": {"rate": 0.2},
    "stiffness_step": {"time": 1.6, "loss": 0.4},
    "power_law_stiffness": {"k": 9000.0, "p": 1.5},
    "normal_nonlinear_stiffness": {"k3": 2e7},
    "normal_hunt_crossley_damping": {"lambda": 300.0},
    "normal_viscoelastic_relaxation": {"k_maxwell": 300.0, "tau": 0.1},
    "normal_hardening_relaxation": {"k3_maxwell": 2e7, "tau": 0.1},
    "normal_hysteresis": {"alpha": 300.0, "beta": 500.0},
    "normal_stiffness_drift": {"rate": 0.2},
    "constant_force": {"F": 1.0},
    "ground_spring": {"k": 60.0},
    "mass_change": {"time": 1.6, "dm": 0.5},
    "second_mode": {"m2": 0.3, "k": 120.0, "b": 0.6},
    "end_stop": {"position": 0.01, "stiffness": 800.0},
    "gravity_offset": {"angle": 0.1},
    "torque_ripple": {"amplitude": 0.5, "period": 0.013, "phase": 0.7},
    "force_bias": {"bias": 0.3},
    "force_drift": {"rate": 0.2},
    "force_lag": {"tau": 0.02},
    "force_crosstalk": {"gain": 0.2},
    "force_saturation": {"limit": 1.5},
    "periodic_disturbance": {"amplitude": 0.3, "frequency": 6.0, "phase": 0.5},
    "tip_mass": {"m_tip": 0.3},
    "time_delay": {"delay": 0.0153},
    "input_lag": {"tau": 0.02},
    "probe_slip": {"mu": 0.3},
    "surface_shape": {
        **{"x": [-0.1, 0.1], "y": [-0.1, 0.0, 0.1]},
        **{"height": [-0.004, 0.004, 0.0, 0.001, -0.002, 0.003], "deviation": [1e-4] * 6},
    },
    "stiffness_map": {
        **{"x": [-0.1, 0.1], "y": [-0.04, 0.0, 0.04]},
        **{"stiffness": [700.0, 650.0, 300.0, 400.0, 900.0, 800.0], "deviation": [10.0] * 6},
    },
    "frame_misalignment": {"rx": 0.1, "ry": -0.15, "rz": 0.2},
    "tool_offset": {"x": 0.004, "y": -0.003, "z": 0.002},
    "gear_play": {"gap": 0.004},
    "dead_band": {"width": 0.8},
    "tabulated_force": {"of": "sliding_velocity", "at": [-0.2, -0.02, 0.02, 0.2], "value": [-0.6, -0.9, 0.9, 0.6]},
}
PLACES = [
    (name, structure)
    for name, effect in LIBRARY.items()
    for structure, model in MODELS.items()
    if effect.acts_on(model)
]

_STROKES = PchipInterpolator(
    [0, 0.1, 0.4, 0.8, 1.0, 1.3, 1.6, 1.9, 2.05, 2.2, 2.35, 2.8, 3.1, 3.5],
    [0, 0.0, 0.04, 0.04, -0.02, -0.02, 0.03, 0.03, 0.0, 0.025, -0.01, 0.03, 0.03, -0.03],
)
_HEIGHT = PchipInterpolator([0, 1.9, 2.0, 2.1, 2.2, 3.5], [-0.004, -0.006, 0.002, 0.002, -0.005, -0.003])
STROKE, STROKE_RATE = _STROKES(TIME), _STROKES(TIME, 1)
_TURNS = np.column_stack([0.5 * np.sin(3.0 * TIME), 0.4 * np.sin(4.0 * TIME + 1.0), 0.1 * np.sin(5.0 * TIME)])
HAND = HandOrientation.of(TIME, Rotation.from_rotvec(_TURNS).as_quat())
LOAD = 2.0 + np.sin(4.0 * TIME)


def applied(model, name, values=None):
    """The model with an effect in it."""
    effect = LIBRARY[name]
    return effect.apply(model, effect.checked(SOME[name] if values is None else values, model, "test"))


def respond(model, max_step=np.inf, rates=False, to=""):
    """(n,) force that the sensor reads, or a body's output; with `rates` also the input's power.

    The tangential force, or the normal one `to` an effect along it, or all three, (3 n,), to one that turns them.
    """
    p, delay, n = model.kernel_vector(max_step), model.additions.delay, len(TIME)
    if isinstance(model, PositionOut):
        u = 60.0 * STROKE if isinstance(model, DrivenBodyModel) else STROKE
        u = input_behind(TIME, u, delay, model.additions.lag)
        output, rate, state = np.empty(n), np.empty(n), np.empty(driven_body.STATE_SIZE)
        driven_body.begin(state, 0.0, u[0], LOAD[0], model.offset)
        driven_body.replay_part(0, n, TIME, u, LOAD, p, state, output, rate)
        if not rates:
            return output
        if isinstance(model, DrivenBodyModel):
            return output, u * rate
        d, half, d_rate = model.deflection(u, output), 0.5 * model.additions.gap, model.ratio * STROKE_RATE - rate
        pull = np.where(np.abs(d) > half, model.k * (d - np.copysign(half, d)) + model.b * d_rate, 0.0)
        return output, pull * model.ratio * STROKE_RATE
    position, velocity = np.zeros((n, 3)), np.zeros((n, 3))
    position[:, 1], velocity[:, 1] = STROKE, STROKE_RATE
    position[:, 2], velocity[:, 2] = _HEIGHT(TIME), _HEIGHT(TIME, 1)
    position, velocity = HAND.tip(position, velocity, model.additions.tool)
    position, velocity = delayed_motion(TIME, position, velocity, delay)
    if isinstance(model, KelvinVoigt):
        force = np.empty(n)
        kelvin_voigt.replay(TIME, position[:, 1].copy(), velocity[:, 1].copy(), LOAD, p, force)
        return (force, -force * velocity[:, 1]) if rates else force
    if isinstance(model, SurfaceContact):
        found = np.empty((n, 6))
        surface_contact.replay(TIME, position, velocity, p, found)
        force = found[:, :3].T.ravel()
        return (force, -np.sum(found[:, :3] * velocity, axis=1)) if rates else force
    force, body = np.empty((n, 3)), np.empty((n, 4))
    contact = np.full(n, flexible_box.CONTACT_BY_GEOMETRY)
    flexible_box.replay(TIME, position, velocity, contact, p, force, body)
    if to and LIBRARY[to].block == "geometry":
        return force.T.ravel()
    i = 2 if to and LIBRARY[to].axis == "z" else 1
    return (force[:, i], -force[:, i] * velocity[:, i]) if rates else force[:, i].copy()
