"""Forces in another frame than positions: a force sensor mounted askew, or a robot that stands askew on its table.

The sensor reads R^T F of a force F, R = Rz(rz) Ry(ry) Rx(rx) the rotation from the force frame to the position frame,
about the axes of the latter. A degree of rx adds 1.7 % of the normal force to y and takes 1.7 % of the force along y
from z; reports tell degrees. All three angles show where the probe slides in two directions and presses; where it
slides along y alone, rx shows alone.

Easily confused with:

- `force_crosstalk`: where a probe slides along y alone and lightly, both add a part of the normal force to y; strokes
  along x and y tell them apart, and so does what a turned sensor takes from z.
- `constant_force`: alike while the probe presses evenly; strokes under a light and under a heavy hand tell them apart.
"""

from math import pi, radians

from mmt_drake.effects.changes import turns_or_moves
from mmt_drake.effects.effect import Effect, Parameter

_MOST = 0.25 * pi  # beyond, axes were swapped
_SEEN = {"rx": "y", "ry": "x", "rz": "xy"}  # angle -> along what it shows, beside z


EFFECT = Effect(
    name="frame_misalignment",
    block="geometry",
    family="geometry",
    parameters=tuple(Parameter(angle, "rad", (-_MOST, _MOST), seen_along=axes) for angle, axes in _SEEN.items()),
    equation="recorded force = R^T force, R = Rz(rz) Ry(ry) Rx(rx)",
    source="Craig 2005, Introduction to Robotics, section 2.8",
    change=turns_or_moves("turn", tuple(_SEEN)),
    near_equal={"force_crosstalk": "the probe slides along one axis, and lightly: a small tilt of the sensor"},
    starts=lambda scales: [dict.fromkeys(_SEEN, sign * radians(1.0)) for sign in (1.0, -1.0)],
)
