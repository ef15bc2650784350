"""Viscous friction at the table: a force on the body against its motion, in proportion to its speed.

F = -b v. It adds to the structure's own damper to the world (b1 of a flexible box, b elsewhere).

Easily confused with:

- `coulomb_friction`: alike in strokes of one speed; slow strokes and fast ones tell them apart.
- `quadratic_drag`: alike in strokes of one speed; strokes of twice the speed meet twice the force here, four times the
  drag.
"""

from mmt_drake.effects.changes import adds
from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS

EFFECT = Effect(
    name="viscous_friction",
    block="friction",
    family="viscous",
    parameters=(Parameter("b", "N s/m", NOT_NEGATIVE),),
    equation="b v",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    change=adds("b", "b"),
    adds_to="b",
    passive=ALWAYS,
    starts=lambda scales: [{"b": 0.3 * scales.force / scales.velocity}],
)
