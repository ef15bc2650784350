"""A spring from the body to the world."""

from dataclasses import replace
from math import inf

from mmt_drake.effects.effect import Effect, Parameter

EFFECT = Effect(
    name="ground_spring",
    block="body",
    parameters=(Parameter("k", "N/m", (0.0, inf)),),
    equation="-k x_m on the body",
    source="spring k1 of the thesis, figure 3",
    apply=lambda model, p: replace(model, parameters=replace(model.parameters, k1=model.parameters.k1 + p["k"])),
    adds_to="k1",
)
