"""A spring from the body to the world.

F = -k x. It adds to the structure's own (k1 of a flexible box, where it is anchored where the body rests at the first
sample; k of a driven body).

Easily confused with:

- `end_stop`: alike on one side of the way; strokes to both sides of where the body rests tell them apart.
- `constant_force`: alike in strokes that are short beside the way from where the body rested first; strokes about
  several places tell them apart.
"""

from mmt_drake.effects.changes import adds
from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS

EFFECT = Effect(
    name="ground_spring",
    block="body",
    family="body_force",
    parameters=(Parameter("k", "N/m", NOT_NEGATIVE),),
    equation="k x",
    source="Hooke 1678, De Potentia Restitutiva; spring k1 of the thesis, figure 3",
    change=adds("k", "k"),
    adds_to="k",
    passive=ALWAYS,
    starts=lambda scales: [{"k": part * scales.force / scales.position} for part in (0.1, 0.5)],
)
