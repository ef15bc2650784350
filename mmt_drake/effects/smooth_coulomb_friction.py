"""Friction of one size against the motion that sets in gradually: a bearing with a film of grease that never sticks.

F = -Fc tanh(v/v_s): viscous of Fc/v_s in creeping motion, Coulomb friction of level Fc in motion faster than v_s. It
never holds the body. In the plane it is -Fc tanh(abs(v)/v_s) v/abs(v).

Easily confused with:

- `coulomb_friction`: alike in motion much faster than v_s; slow reversals, and a body left to itself on a slope, which
  creeps here and stays there, tell them apart.
- `viscous_friction`: alike in motion much slower than v_s; fast motion tells them apart.
"""

from math import inf, tanh

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import OSCILLATION, At, Numbers, Own, Result, Slot, law, norm

_FASTEST = 400.0
"""A slope at rest that would stop the body faster than this [1/s], which no recording shows, stops it so fast."""
_CREEPING = 1e-3
"""Part of the highest speed below which no recording shows how friction sets in."""


@law(Slot.BODY, in_plane=True)
def _tanh(at: At, q: Own, p: Numbers) -> Result:
    Fc, v_s, m = p[0], p[1], p[2]
    if m > 0.0:
        v_s = max(v_s, Fc / (m * _FASTEST))
    speed = norm(at.v, at.v_across)
    level = tanh(speed / v_s)
    rate = Fc / (m * v_s) * (1.0 - level**2) if m > 0.0 else 0.0
    return -Fc * level * at.v / speed if speed > 0.0 else 0.0, 0.0, 0.0, OSCILLATION * rate


def _sets_in(values: Values, ranges: Ranges) -> bool:
    """True where it neither is Coulomb friction, its slope at rest the steepest there is, nor a damper."""
    v_s, m = values["v_s"], ranges["m"][0]
    fastest = max(map(abs, ranges["sliding_velocity"]))
    steepest = values["Fc"] / (m * _FASTEST) if m > 0.0 else 0.0
    return max(steepest, _CREEPING * fastest) < v_s < 0.5 * fastest


EFFECT = Effect(
    name="smooth_coulomb_friction",
    block="friction",
    family="dry_friction",
    parameters=(Parameter("Fc", "N", NOT_NEGATIVE), Parameter("v_s", "m/s", (1e-9, inf), vanishes_at=1.0, shape=True)),
    equation="Fc tanh(v/v_s)",
    source="Andersson, Soderberg and Bjorklund 2007, Tribology International 40(4)",
    law=_tanh,
    uses=("m",),
    passive=ALWAYS,
    engages=_sets_in,
    holds=("coulomb_friction",),  # one that sets in at once
    starts=lambda scales: [{"Fc": 0.3 * scales.force, "v_s": part * scales.velocity} for part in (0.03, 0.3)],
)
