"""Coulomb friction at the table: a force of one size against the motion.

F = -Fc sgn v while the body slides; at rest friction holds whatever is below Fc. It adds to the structure's own Fc.

Easily confused with:

- `load_dependent_friction`: alike while the probe presses evenly; strokes under a light and under a heavy hand tell
  them apart.
- `stribeck_friction`: alike in fast strokes; slow ones, and starts from rest, tell them apart.
- `force_bias`: the same while the motion goes one way; strokes both ways tell them apart.
- `presliding_friction`: alike in long strokes; strokes of a fraction of a millimetre about one spot tell them apart.
"""

from mmt_drake.effects.changes import adds
from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS

EFFECT = Effect(
    name="coulomb_friction",
    block="friction",
    family="dry_friction",
    parameters=(Parameter("Fc", "N", NOT_NEGATIVE),),
    equation="Fc sgn v; at rest it holds whatever is below Fc",
    source="Coulomb 1785; Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    change=adds("Fc", "Fc"),
    adds_to="Fc",
    equal_one_way=("constant_force", "force_bias"),
    passive=ALWAYS,
    starts=lambda scales: [{"Fc": 0.1 * scales.force}, {"Fc": 0.4 * scales.force}],
)
