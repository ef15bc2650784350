"""A wall on one side of the body's way.

F = -stiffness (x - position) while x > position (side 1: met moving in +), or while x < position (side -1: met moving
in -). x is the body's displacement; the output of a driven body.

Easily confused with:

- `nonlinear_stiffness`: both stiffen far out; strokes to both sides tell them apart, and slow ones up to the wall: it
  has an edge.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Scales, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


def _stored(at: At, q: Own, p: Numbers) -> Result:
    depth = max(p[2] * (at.x - p[0]), 0.0)
    return 0.5 * p[1] * depth * depth, 0.0, 0.0, 0.0


@law(Slot.BODY, stored=_stored)
def _wall(at: At, q: Own, p: Numbers) -> Result:
    position, stiffness, side = p[0], p[1], p[2]
    depth = max(side * (at.x - position), 0.0)
    return -side * stiffness * depth, 0.0, 0.0, 0.0


def _starts(scales: Scales) -> list[Values]:
    return [
        {"position": side * part * scales.position, "stiffness": scales.stiffness, "side": side}
        for side in (1.0, -1.0)
        for part in (0.3, 0.8, 1.3)
    ]


EFFECT = Effect(
    name="end_stop",
    block="body",
    family="body_force",
    parameters=(
        Parameter("position", "m", shape=True),
        Parameter("stiffness", "N/m", NOT_NEGATIVE),
        Parameter("side", "1", (-1.0, 1.0), vanishes_at=1.0, default=1.0, choices=(-1.0, 1.0)),
    ),
    equation="stiffness (x - position) while side (x - position) > 0",
    source="Brogliato 2016, Nonsmooth Mechanics, chapter 2",
    law=_wall,
    stiffness=lambda values: values["stiffness"],
    # A wall that is never left; a spring of the structure may take its stiffness, and a force is left.
    holds=("ground_spring", "constant_force"),
    passive=ALWAYS,
    engages=lambda values, ranges: ranges["position"][0] < values["position"] < ranges["position"][1],
    starts=_starts,
)
