"""Gravity from another side: the angle at which a pendulum hangs is not the one at which its encoder reads 0.

A driven body's pendulum pulls by pendulum sin(output + angle), not pendulum sin(output).

Easily confused with:

- `constant_force`: alike in strokes that are short beside a radian; strokes to both sides of hanging down tell them
  apart.
"""

from math import cos, pi, sin

from mmt_drake.effects.effect import Effect, Parameter
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.BODY)
def _turned(at: At, q: Own, p: Numbers) -> Result:
    angle, pendulum = p[0], p[1]
    return pendulum * (sin(at.x) * (1.0 - cos(angle)) - cos(at.x) * sin(angle)), 0.0, 0.0, 0.0


EFFECT = Effect(
    name="gravity_offset",
    block="body",
    family="body_force",
    parameters=(Parameter("angle", "rad", (-pi, pi)),),
    equation="pendulum (sin x - sin(x + angle)) on the body",
    source="Craig 2005, Introduction to Robotics, section 6.7",
    law=_turned,
    uses=("pendulum",),
    needs=("pendulum",),
    starts=lambda scales: [{"angle": angle} for angle in (0.1, -0.1)],
)
