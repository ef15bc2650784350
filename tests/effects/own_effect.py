"""A spring of the fifth power."""

from mmt_drake.effects import Effect, Parameter
from mmt_drake.model.laws import Slot, law


@law(Slot.CONTACT)
def quintic(at, q, p):
    return p[0] * at.d**5, 0.0, 0.0, 0.0


EFFECT = Effect(
    name="quintic_stiffness",
    block="contact",
    parameters=(Parameter("k5", "N/m^5"),),
    equation="k5 d^5",
    source="mine",
    law=quintic,
    starts=lambda scales: [{"k5": 0.1 * scales.force / scales.deflection**5}],
)
