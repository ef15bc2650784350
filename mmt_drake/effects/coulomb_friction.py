"""Coulomb friction at the table."""

from dataclasses import replace
from math import inf

from mmt_drake.effects.effect import Effect, Parameter

EFFECT = Effect(
    name="coulomb_friction",
    block="friction",
    parameters=(Parameter("Fc", "N", (0.0, inf)),),
    equation="Fc sgn v; at rest it holds whatever is below Fc",
    source="Coulomb 1785; Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    apply=lambda model, p: replace(model, parameters=replace(model.parameters, Fc=model.parameters.Fc + p["Fc"])),
    adds_to="Fc",
)
