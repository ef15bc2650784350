"""A force sensor that carries a mass before the tip: it reads what moves that mass, too.

The reading is less by m_tip a, the acceleration a of the probe along each axis from three samples; where samples are
nearer than 1.6 ms it is averaged over that, for a recorded velocity has noise. Free space shows it alone. A gripper, a
tool or a flange between the sensor and the contact.

Easily confused with:

- `time_delay`: both shift the force of a damper in time; the probe moved in free space tells them apart: there a late
  force is still none.
- `periodic_disturbance`: both make free space hum where the hand shakes; a probe held still tells them apart.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Scales, Values
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law

_LEAST_S = 1.6e-3  # of an interval over which a slope is taken: 500 Hz is as it is, 1 kHz is averaged


@law(Slot.SENSOR, remembers=True, order=1, every_axis=True)
def _carried(at: At, q: Own, p: Numbers) -> Result:
    # q: the velocity at the sample before, and its slope up to there: three samples tell the slope at the last.
    slope = (at.v - q[0]) / at.h if at.h > 0.0 else 0.0
    if at.t <= 1.5 * at.h:
        acceleration = slope
    elif at.h < _LEAST_S:
        acceleration = slope = q[1] + (slope - q[1]) * at.h / _LEAST_S
    else:
        acceleration = slope + 0.5 * (slope - q[1])
    return at.force - p[0] * acceleration, at.v, slope, 0.0


def _starts(scales: Scales) -> list[Values]:
    return [{"m_tip": 0.2 * scales.force / (scales.velocity * scales.frequency)}]


EFFECT = Effect(
    name="tip_mass",
    block="force_sensor",
    family="sensor",
    parameters=(Parameter("m_tip", "kg", NOT_NEGATIVE),),
    equation="recorded force = force - m_tip v', v the velocity of the probe",
    source="Siciliano et al. 2009, Robotics: Modelling, Planning and Control, section 9.1",
    law=_carried,
    starts=_starts,
)
