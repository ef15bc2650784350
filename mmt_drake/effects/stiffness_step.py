"""A contact spring that loses, or gains, a part of its stiffness at once.

k2 before `time`, k2 (1 - loss) after it, `time` counted from the first sample; as with a change of mass it passes
smoothly within a moment. A crack, a clamp that slips, a layer that gives way; a `loss` below 0 stiffens.

Easily confused with:

- `stiffness_drift`: both change the spring for good; the same stroke repeated all along tells them apart: one changes
  at once, one gradually.
- `mass_change`: both change the object at one moment; slow strokes tell them apart, in which a mass does not show.
"""

from math import inf

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.mass_change import passed, within
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.CONTACT)
def _step(at: At, q: Own, p: Numbers) -> Result:
    time, loss, k2 = p[0], p[1], p[2]
    return -k2 * loss * passed(at.t, time) * at.d, 0.0, 0.0, 0.0


EFFECT = Effect(
    name="stiffness_step",
    block="contact",
    family="contact_stiffness",
    parameters=(Parameter("time", "s", NOT_NEGATIVE, shape=True, moment=True), Parameter("loss", "1", (-inf, 1.0))),
    equation="k2 before `time`, k2 (1 - loss) after it",
    source="Dimarogonas 1996, Vibration of cracked structures, Engineering Fracture Mechanics 55(5)",
    law=_step,
    uses=("k2",),
    sought_beside=("k2",),
    engages=within("time_in_contact"),
    starts=lambda scales: [{"time": k / 13.0 * scales.duration, "loss": 0.3} for k in range(1, 13)],
)
