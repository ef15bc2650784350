"""A force sensor whose zero wanders: what it reads too much grows with time.

rate t is added to the recorded tangential force, t from the first sample: a sensor that warms up.

Easily confused with:

- `constant_force`: both push the mean of the force away; a long recording and the probe lifted off tell them apart.
"""

from mmt_drake.effects.effect import Effect, Parameter, Scales, Values
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.SENSOR, order=1)
def _wander(at: At, q: Own, p: Numbers) -> Result:
    return at.force + p[0] * at.t, q[0], q[1], 0.0


def _starts(scales: Scales) -> list[Values]:
    rate = 0.2 * scales.force / scales.duration
    return [{"rate": rate}, {"rate": -rate}]


EFFECT = Effect(
    name="force_drift",
    block="force_sensor",
    family="sensor",
    parameters=(Parameter("rate", "N/s"),),
    equation="recorded force = force + rate t, t from the first sample",
    source="International Vocabulary of Metrology (JCGM 200:2012), 4.21",
    law=_wander,
    starts=_starts,
)
