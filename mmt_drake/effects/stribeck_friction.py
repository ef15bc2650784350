"""Friction that falls from a break-away level to the sliding level as the body gains speed.

F = -(Fc + (Fs - Fc) exp(-(v/v_s)^2)) sgn v, Fc being the structure's own; at rest it holds whatever is below Fs. A
lubricated contact: the film builds up with speed.

Easily confused with:

- `viscous_friction`: within a narrow range of low speeds it is a damper of negative value; strokes over a decade of
  speed tell them apart.
- `presliding_friction`: alike in long strokes where Fs is above Fc in both; reversals within the bristles' reach tell
  them apart.
"""

from math import exp, inf

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.FRICTION)
def _stribeck(at: At, q: Own, p: Numbers) -> Result:
    Fs, v_s, Fc = p[0], p[1], p[2]
    return Fc + (Fs - Fc) * exp(-((at.v / v_s) ** 2)), Fs, 0.0, 0.0


EFFECT = Effect(
    name="stribeck_friction",
    block="friction",
    family="dry_friction",
    parameters=(
        Parameter("Fs", "N", NOT_NEGATIVE, vanishes_at="Fc"),
        Parameter("v_s", "m/s", (1e-6, inf), vanishes_at=0.01, shape=True),
    ),
    equation="(Fc + (Fs - Fc) exp(-(v/v_s)^2)) sgn v, Fc the model's; sticks below Fs",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    law=_stribeck,
    uses=("Fc",),
    inertial=True,
    replaces="Fc",
    holds=("coulomb_friction",),  # one that hardly falls
    passive=ALWAYS,
    # Slower than half of v_s its level falls by less than a quarter: Coulomb friction by another name. Faster than a
    # thousand v_s it has fallen before anything is seen of it: static friction.
    engages=lambda values, ranges: (
        0.5 * values["v_s"] < max(map(abs, ranges["sliding_velocity"])) < 1e3 * values["v_s"]
    ),
    starts=lambda scales: [
        {"Fs": level * scales.force, "v_s": part * scales.velocity} for level in (0.15, 0.5) for part in (0.1, 0.5)
    ],
)
