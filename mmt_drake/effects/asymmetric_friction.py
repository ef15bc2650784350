"""Coulomb friction whose level differs with the direction of motion.

F = -Fc_plus while the body slides along +, Fc_minus while it slides along -; at rest it holds a drive along + below
Fc_plus and one along - below Fc_minus. It takes the place of the structure's Fc. On one axis it is the same thing as
Coulomb friction of the mean level together with a constant force of half the difference, and no recording can tell.

Easily confused with:

- `coulomb_friction`: alike in strokes one way; strokes both ways tell them apart.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Scales, Values, both_ways
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.FRICTION)
def _two_levels(at: At, q: Own, p: Numbers) -> Result:
    level = p[0] if at.direction > 0.0 else p[1]
    return level, level, 0.0, 0.0


def _holds_both_ways(values: Values, ranges: Ranges) -> bool:
    """True where it has a level either way, and the body slides either way: with one alone it is a force of its own."""
    return min(values["Fc_plus"], values["Fc_minus"]) > 0.0 and both_ways("sliding_velocity")(values, ranges)


def _starts(scales: Scales) -> list[Values]:
    high, low = 0.4 * scales.force, 0.1 * scales.force
    return [{"Fc_plus": a, "Fc_minus": b} for a, b in ((low, low), (high, low), (low, high))]


EFFECT = Effect(
    name="asymmetric_friction",
    block="friction",
    family="dry_friction",
    parameters=(
        Parameter("Fc_plus", "N", NOT_NEGATIVE, vanishes_at="Fc"),
        Parameter("Fc_minus", "N", NOT_NEGATIVE, vanishes_at="Fc"),
    ),
    equation="Fc_plus for v > 0, -Fc_minus for v < 0, in the place of Fc sgn v",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    law=_two_levels,
    replaces="Fc",
    holds=("coulomb_friction",),  # the same both ways
    equal_to=("coulomb_friction + constant_force",),
    passive=ALWAYS,
    engages=_holds_both_ways,
    starts=_starts,
)
