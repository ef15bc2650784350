"""The library of effects that a simulation may have left out, one file each.

An effect of your own is a Python file with an `EFFECT` in it, written as those of this folder are; `register_file`
(`--effects FILE` on the command line) puts it into the library, where it is as good as any other.
"""

import importlib

from mmt_drake.effects.changes import adds
from mmt_drake.effects.effect import Effect, Parameter, Scales, Values
from mmt_drake.effects.library import LIBRARY, SOURCES, register, register_file

for _name in (
    "viscous_friction",
    "asymmetric_viscous_friction",
    "coulomb_friction",
    "asymmetric_friction",
    "static_friction",
    "stribeck_friction",
    "presliding_friction",
    "load_dependent_friction",
    "smooth_coulomb_friction",
    "dahl_friction",
    "elastoplastic_play",
    "quadratic_drag",
    "nonlinear_stiffness",
    "hunt_crossley_damping",
    "viscoelastic_relaxation",
    "hardening_relaxation",
    "hysteresis",
    "contact_gap",
    "stiffness_drift",
    "stiffness_step",
    "power_law_stiffness",
    "normal_nonlinear_stiffness",
    "normal_hunt_crossley_damping",
    "normal_viscoelastic_relaxation",
    "normal_hardening_relaxation",
    "normal_hysteresis",
    "normal_stiffness_drift",
    "constant_force",
    "ground_spring",
    "mass_change",
    "second_mode",
    "end_stop",
    "gravity_offset",
    "torque_ripple",
    "force_bias",
    "force_drift",
    "force_lag",
    "force_crosstalk",
    "force_saturation",
    "periodic_disturbance",
    "tip_mass",
    "time_delay",
    "input_lag",
    "probe_slip",
    "surface_shape",
    "stiffness_map",
    "frame_misalignment",
    "tool_offset",
    "gear_play",
    "dead_band",
    "tabulated_force",
):
    register(importlib.import_module(f"{__name__}.{_name}").EFFECT)

__all__ = ["LIBRARY", "SOURCES", "Effect", "Parameter", "Scales", "Values", "adds", "register", "register_file"]
