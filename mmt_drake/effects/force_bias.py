"""A force sensor that reads a constant too much: an offset left by taring it.

Added to the recorded tangential force, in contact and off it.

Easily confused with:

- `force_drift`: alike in a short recording; a long one tells them apart.
- `force_crosstalk`: alike while the probe presses evenly; the probe lifted off, or pressed harder, tells them apart.
- `asymmetric_friction`: beside Coulomb friction alike while the body slides to and fro; the probe lifted off tells them
  apart.
"""

from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.SENSOR, order=1)
def _bias(at: At, q: Own, p: Numbers) -> Result:
    return at.force + p[0], q[0], q[1], 0.0


EFFECT = Effect(
    name="force_bias",
    block="force_sensor",
    family="sensor",
    parameters=(Parameter("bias", "N"),),
    equation="recorded force = force + bias",
    source="International Vocabulary of Metrology (JCGM 200:2012), 4.20",
    law=_bias,
    starts=lambda scales: [{"bias": 0.1 * scales.force}, {"bias": -0.1 * scales.force}],
)
