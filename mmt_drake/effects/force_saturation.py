"""A force sensor that reads no more than its range.

The recorded force, along each axis, is clipped to -limit ... limit, after everything else that the sensor does to it.

Easily confused with:

- `coulomb_friction`: a body that slips bounds the force as a sensor does; strokes of several speeds tell them apart:
  with damping, faster sliding still takes more force.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.SENSOR, order=2, every_axis=True)
def _clip(at: At, q: Own, p: Numbers) -> Result:
    return min(max(at.force, -p[0]), p[0]), q[0], q[1], 0.0


EFFECT = Effect(
    name="force_saturation",
    block="force_sensor",
    family="sensor",
    # A limit that nothing reaches.
    parameters=(Parameter("limit", "N", NOT_NEGATIVE, vanishes_at=1e9),),
    equation="recorded force = force clipped to -limit ... limit",
    source="Doebelin 2004, Measurement Systems, chapter 3",
    law=_clip,
    # Recorded are forces up to the limit, and none beyond it but for noise.
    engages=lambda values, ranges: 0.95 < values["limit"] / max(map(abs, ranges["force"])) < 1.1,
    starts=lambda scales: [{"limit": part * scales.peak_force} for part in (0.97, 1.0)],
)
