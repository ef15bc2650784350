"""A constant force on the body, along + of the tangential axis: a tilted table, gravity, a hose that pulls.

F on the body of a flexible box [N], on both axes alike; gain F on a driven body, so that there F is in units of the
input. Together with Coulomb friction of a level not below it, it is the same thing as asymmetric friction.

Easily confused with:

- `force_bias`: alike while the probe holds the body; the probe lifted off tells them apart: there a sensor still reads
  its bias.
- `coulomb_friction`: alike in strokes one way; strokes both ways tell them apart.
"""

from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.BODY)
def _constant(at: At, q: Own, p: Numbers) -> Result:
    return p[0] * p[1], 0.0, 0.0, 0.0


EFFECT = Effect(
    name="constant_force",
    block="body",
    family="body_force",
    parameters=(Parameter("F", "N"),),
    equation="F on the body, along + (of a driven body: gain F, F in units of the input)",
    source="Newton 1687, Principia",
    law=_constant,
    uses=("gain",),
    starts=lambda scales: [{"F": 0.2 * scales.force}, {"F": -0.2 * scales.force}],
)
