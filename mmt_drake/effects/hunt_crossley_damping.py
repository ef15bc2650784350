"""Contact damping that grows with the deflection.

b2 d' lambda abs(d) beside the structure's contact damper b2 d': no jump of the force where a contact closes, and more
loss where it is deep. In the plane abs(d) is the length of the deflection.

Easily confused with:

- `viscoelastic_relaxation`: both lose energy in the contact; a hold after a fast stroke tells them apart: damping ends
  with the motion, relaxation goes on.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import OSCILLATION, At, Numbers, Own, Result, Slot, law, norm


@law(Slot.CONTACT, in_plane=True)
def _hunt_crossley(at: At, q: Own, p: Numbers) -> Result:
    growth, b2, m = p[0], p[1], p[2]
    damper = b2 * growth * norm(at.d, at.d_across)
    return damper * at.d_rate, 0.0, 0.0, OSCILLATION * damper / m if m > 0.0 else 0.0


EFFECT = Effect(
    name="hunt_crossley_damping",
    block="contact",
    family="contact_loss",
    parameters=(Parameter("lambda", "1/m", NOT_NEGATIVE),),
    equation="b2 d' lambda |d| beside the contact damper b2 d'",
    source="Hunt and Crossley 1975, J. Applied Mechanics 42(2)",
    law=_hunt_crossley,
    uses=("b2", "m"),
    passive=ALWAYS,
    starts=lambda scales: [{"lambda": part / scales.deflection} for part in (0.2, 1.0)],
)
