"""A force that comes back every so much of the way: cogging of a motor, a screw or a gear that is not true.

amplitude sin(2 pi x/period + phase) on the body, x its displacement.

Easily confused with:

- `periodic_disturbance`: alike at one speed; motion at several speeds tells them apart.
- `ground_spring`: alike in strokes much shorter than the period; longer ones tell them apart.
- `gravity_offset`: alike where the period is a whole turn.
"""

from math import inf, pi, sin

from mmt_drake.effects.effect import NOT_NEGATIVE, PHASES, Effect, Parameter, Scales, Values
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.BODY)
def _ripple(at: At, q: Own, p: Numbers) -> Result:
    amplitude, period, phase = p[0], p[1], p[2]
    return amplitude * sin(2.0 * pi * at.x / period + phase), 0.0, 0.0, 0.0


def _starts(scales: Scales) -> list[Values]:
    periods = scales.ripples or (scales.position, 0.3 * scales.position)
    return [
        {"amplitude": 0.1 * scales.force, "period": period, "phase": phase} for period in periods for phase in PHASES
    ]


EFFECT = Effect(
    name="torque_ripple",
    block="body",
    family="body_force",
    parameters=(
        Parameter("amplitude", "N", NOT_NEGATIVE),
        Parameter("period", "m", (1e-9, inf), vanishes_at=1.0, shape=True),
        Parameter("phase", "rad", shape=True),
    ),
    equation="amplitude sin(2 pi x/period + phase) on the body",
    source="Holtz and Springob 1996, IEEE Trans. Industrial Electronics 43(2)",
    law=_ripple,
    stiffness=lambda values: 2.0 * pi * values["amplitude"] / values["period"],
    engages=lambda values, ranges: 2.0 * values["period"] <= ranges["position"][1] - ranges["position"][0],  # repeats
    starts=_starts,
)
