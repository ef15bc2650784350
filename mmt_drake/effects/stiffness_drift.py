"""A contact spring that grows stiffer or softer with time.

k2 (1 + rate t), t from the first sample: a material that warms up, cures, tires or dries.

Easily confused with:

- `force_drift`: both grow with time; the probe lifted off, or at rest in contact without deflection, tells them apart.
- `mass_change`: both change the object for good; the same stroke repeated all along tells them apart: one changes at
  once, one gradually, and a mass shows in fast strokes alone.
"""

from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.CONTACT)
def _drift(at: At, q: Own, p: Numbers) -> Result:
    rate, k2 = p[0], p[1]
    return k2 * rate * at.t * at.d, 0.0, 0.0, 0.0


EFFECT = Effect(
    name="stiffness_drift",
    block="contact",
    family="contact_stiffness",
    parameters=(Parameter("rate", "1/s"),),
    equation="k2 (1 + rate t), t from the first sample",
    source="Fung 1993, Biomechanics: Mechanical Properties of Living Tissues, section 7.5 (preconditioning)",
    law=_drift,
    uses=("k2",),
    starts=lambda scales: [{"rate": change / scales.duration} for change in (0.3, -0.3)],
)
