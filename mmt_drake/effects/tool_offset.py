"""A tip that is elsewhere than recorded: a tool longer or bent otherwise than the robot's software believes.

The tip is at p + R o, p the recorded position, R the recorded orientation of the hand (`orientation_x` _y _z _w) and o
the offset in the hand's frame, so it goes about as the hand turns. Where the hand never turns, an offset is no more
than another place of the surface, and nothing is said of it.

Easily confused with:

- `surface_shape`: where the hand turns in step with the place, a tip that goes up and down is a surface that does; the
  same places under another hand tell them apart.
- `frame_misalignment`: both make forces of another direction where the surface is steep; on a level one an offset moves
  no force sideways.
"""

from mmt_drake.effects.changes import turns_or_moves
from mmt_drake.effects.effect import Effect, Parameter

_AXES = ("x", "y", "z")


EFFECT = Effect(
    name="tool_offset",
    block="geometry",
    family="geometry",
    parameters=tuple(Parameter(axis, "m", (-1.0, 1.0)) for axis in _AXES),
    equation="tip at p + R o: o = (x, y, z) in the hand's frame, R its recorded orientation",
    source="Craig 2005, Introduction to Robotics, section 2.3",
    change=turns_or_moves("tool", _AXES),
    needs=("surface",),
    starts=lambda scales: [dict.fromkeys(_AXES, sign * 0.003) for sign in (1.0, -1.0)],
)
