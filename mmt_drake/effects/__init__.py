"""The library of effects that a simulation may have left out, one file each.

An effect of your own is a Python file with an `EFFECT` in it, written as those of this folder are; `register_file`
(`--effects FILE` on the command line) puts it into the library, where it is as good as any other.
"""

from mmt_drake.effects import (
    asymmetric_friction,
    asymmetric_viscous_friction,
    constant_force,
    contact_gap,
    coulomb_friction,
    dahl_friction,
    dead_band,
    elastoplastic_play,
    end_stop,
    force_bias,
    force_crosstalk,
    force_drift,
    force_lag,
    force_saturation,
    gravity_offset,
    ground_spring,
    hunt_crossley_damping,
    hysteresis,
    load_dependent_friction,
    mass_change,
    nonlinear_stiffness,
    periodic_disturbance,
    presliding_friction,
    quadratic_drag,
    second_mode,
    smooth_coulomb_friction,
    static_friction,
    stiffness_drift,
    stribeck_friction,
    tabulated_force,
    time_delay,
    torque_ripple,
    viscoelastic_relaxation,
    viscous_friction,
)
from mmt_drake.effects.effect import Effect, Parameter, Scales, Values, adds
from mmt_drake.effects.library import LIBRARY, register, register_file

for _module in (
    viscous_friction,
    asymmetric_viscous_friction,
    coulomb_friction,
    asymmetric_friction,
    static_friction,
    stribeck_friction,
    presliding_friction,
    load_dependent_friction,
    smooth_coulomb_friction,
    dahl_friction,
    elastoplastic_play,
    quadratic_drag,
    nonlinear_stiffness,
    hunt_crossley_damping,
    viscoelastic_relaxation,
    hysteresis,
    contact_gap,
    stiffness_drift,
    constant_force,
    ground_spring,
    mass_change,
    second_mode,
    end_stop,
    gravity_offset,
    torque_ripple,
    force_bias,
    force_drift,
    force_lag,
    force_crosstalk,
    force_saturation,
    periodic_disturbance,
    time_delay,
    dead_band,
    tabulated_force,
):
    register(_module.EFFECT)

__all__ = ["LIBRARY", "Effect", "Parameter", "Scales", "Values", "adds", "register", "register_file"]
