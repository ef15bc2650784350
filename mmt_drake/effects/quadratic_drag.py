"""Drag that grows with the square of the speed.

F = -c v abs(v): a body that pushes a fluid aside. In the plane abs(v) is the speed.

Easily confused with:

- `coulomb_friction`: alike in strokes of one speed; slow strokes and fast ones tell them apart.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import OSCILLATION, At, Numbers, Own, Result, Slot, law, norm


@law(Slot.BODY, in_plane=True)
def _drag(at: At, q: Own, p: Numbers) -> Result:
    c, m = p[0], p[1]
    speed = norm(at.v, at.v_across)
    rate = 2.0 * c * speed / m if m > 0.0 else 0.0
    return -c * at.v * speed, 0.0, 0.0, OSCILLATION * rate


EFFECT = Effect(
    name="quadratic_drag",
    block="friction",
    family="viscous",
    parameters=(Parameter("c", "N s^2/m^2", NOT_NEGATIVE),),
    equation="c v |v|",
    source="Newton 1687, Principia, book II; Batchelor 1967, An Introduction to Fluid Dynamics, section 5.11",
    law=_drag,
    uses=("m",),
    passive=ALWAYS,
    starts=lambda scales: [{"c": 0.2 * scales.force / scales.velocity**2}],
)
