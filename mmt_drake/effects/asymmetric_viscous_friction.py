"""Viscous friction that differs with the direction of motion.

F = -b_plus v for v > 0 and -b_minus v for v < 0, in the place of the structure's damper to the world. A guide with a
lip seal, a damper with a check valve.

Easily confused with:

- `viscous_friction`: alike in strokes one way; strokes of equal speed both ways tell them apart.
- `asymmetric_friction`: alike in strokes of one speed; slow strokes and fast ones, both ways, tell them apart.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Scales, Values, both_ways
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.BODY)
def _two_dampers(at: At, q: Own, p: Numbers) -> Result:
    b_plus, b_minus = p[0], p[1]
    return -(b_plus if at.v > 0.0 else b_minus) * at.v, 0.0, 0.0, 0.0


def _starts(scales: Scales) -> list[Values]:
    b = scales.force / scales.velocity
    return [{"b_plus": 0.6 * b, "b_minus": 0.3 * b}, {"b_plus": 0.3 * b, "b_minus": 0.6 * b}]


EFFECT = Effect(
    name="asymmetric_viscous_friction",
    block="friction",
    family="viscous",
    parameters=(
        Parameter("b_plus", "N s/m", NOT_NEGATIVE, vanishes_at="b"),
        Parameter("b_minus", "N s/m", NOT_NEGATIVE, vanishes_at="b"),
    ),
    equation="b_plus v for v > 0, b_minus v for v < 0, in the place of b v",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    law=_two_dampers,
    replaces="b",
    holds=("viscous_friction",),  # the same both ways
    damping=lambda values: max(values["b_plus"], values["b_minus"]),
    passive=ALWAYS,
    engages=both_ways("sliding_velocity"),
    starts=_starts,
)
