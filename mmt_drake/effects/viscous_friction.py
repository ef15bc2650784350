"""Viscous friction at the table."""

from dataclasses import replace
from math import inf

from mmt_drake.effects.effect import Effect, Parameter

EFFECT = Effect(
    name="viscous_friction",
    block="friction",
    parameters=(Parameter("b", "N s/m", (0.0, inf)),),
    equation="b v",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    apply=lambda model, p: replace(model, parameters=replace(model.parameters, b1=model.parameters.b1 + p["b"])),
    adds_to="b1",
)
