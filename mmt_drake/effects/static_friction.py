"""Stick and slip with a break-away level above the sliding level, after Karnopp."""

from dataclasses import replace
from math import inf

from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.model.parameters import Friction

EFFECT = Effect(
    name="static_friction",
    block="friction",
    parameters=(
        Parameter("Fs", "N", (0.0, inf)),
        Parameter("Fd", "N", (0.0, inf)),
        Parameter("v_d", "m/s", (0.0, inf)),
    ),
    equation="sticks (v = 0) while |v| < v_d and the drive of the body at rest is below Fs; else Fd sgn v",
    source="Karnopp 1985, J. Dyn. Sys. Meas. Control 107(1)",
    apply=lambda model, p: replace(model, friction=Friction(**p)),
    replaces="Fc",
)
