"""A force sensor whose tangential axes feel the normal one.

The tangential force reads gain times the normal force too much: a sensor mounted askew.

Easily confused with:

- `constant_force`: alike while the probe presses evenly; strokes under a light and under a heavy hand tell them apart.
"""

from mmt_drake.effects.effect import Effect, Parameter, Scales, Values
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.SENSOR, order=1)
def _crosstalk(at: At, q: Own, p: Numbers) -> Result:
    return at.force + p[0] * at.normal_force, q[0], q[1], 0.0


def _starts(scales: Scales) -> list[Values]:
    gain = 0.2 * scales.force / scales.load if scales.load > 0.0 else 0.1
    return [{"gain": gain}, {"gain": -gain}]


EFFECT = Effect(
    name="force_crosstalk",
    block="force_sensor",
    family="sensor",
    parameters=(Parameter("gain", "1"),),
    equation="recorded force = tangential force + gain x normal force",
    source="Doebelin 2004, Measurement Systems, chapter 5",
    law=_crosstalk,
    starts=_starts,
)
