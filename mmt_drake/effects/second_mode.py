"""A further mass that hangs on the body by a spring and a damper: an antenna, a liquid, a loose part.

m2 x2'' = -k (x2 - x) - b (x2' - v), and the body feels the opposite. At the first sample both are at rest, the spring
relaxed.

Easily confused with:

- `periodic_disturbance`: both ring at one frequency; a long dwell tells them apart: a hung mass comes to rest.
- `viscoelastic_relaxation`: both are late force with a memory; a fast stroke and a hold tell them apart: a hung mass
  swings.
"""

from math import inf, pi, sqrt

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Scales, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import OSCILLATION, At, Numbers, Own, Result, Slot, law


def _stored(at: At, q: Own, p: Numbers) -> Result:
    return 0.5 * (p[1] * q[0] ** 2 + p[0] * q[1] ** 2), 0.0, 0.0, 0.0


@law(Slot.BODY, remembers=True, stored=_stored)
def _hung(at: At, q: Own, p: Numbers) -> Result:
    # Remembered are the spring's stretch x2 - x and the velocity x2'.
    m2, k, b = p[0], p[1], p[2]
    stretch_rate = q[1] - at.v
    force = k * q[0] + b * stretch_rate
    return force, stretch_rate, -force / m2, OSCILLATION * (b / m2 + sqrt(k / m2))


def _starts(scales: Scales) -> list[Values]:
    m2 = 0.2 * scales.mass
    omegas = [2.0 * pi * part * scales.frequency for part in (0.4, 0.6, 0.9, 1.3, 2.0, 3.0, 4.5, 6.5, 9.5, 14.0)]
    return [{"m2": m2, "k": m2 * omega**2, "b": 0.1 * m2 * omega} for omega in omegas]


def _swings(values: Values, ranges: Ranges) -> bool:
    """True where it swings twice at least: slower, it is no mode but a mass dragged along, and passes for drag."""
    period = 2.0 * pi * sqrt(values["m2"] / values["k"]) if values["k"] > 0.0 else inf
    return 2.0 * period <= ranges["time"][1] - ranges["time"][0]


EFFECT = Effect(
    name="second_mode",
    block="body",
    family="inertia",
    parameters=(
        Parameter("m2", "kg", (1e-6, inf), vanishes_at=1e-6),
        Parameter("k", "N/m", NOT_NEGATIVE),
        Parameter("b", "N s/m", NOT_NEGATIVE),
    ),
    equation="k (x2 - x) + b (x2' - v) on the body, m2 x2'' = -k (x2 - x) - b (x2' - v)",
    source="Den Hartog 1934, Mechanical Vibrations, chapter 3",
    law=_hung,
    stiffness=lambda values: values["k"],
    damping=lambda values: values["b"],
    passive=ALWAYS,
    engages=_swings,
    starts=_starts,
)
