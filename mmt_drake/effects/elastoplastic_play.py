"""Friction behind a spring behind play: bands, couplings and gears that are slack, then give, then slide.

A spring k, a clearance gap and a slider of level Fc in series, from the body to the world. With the body at q from the
middle of the clearance, F = k sgn(q) (abs(q) - gap/2) outside of it; the slider follows as soon as that reaches Fc.

Easily confused with:

- `dahl_friction`: alike without play, but for a corner that is round there; the force over position tells them apart:
  with play it is none on a stretch after each turn.
- `coulomb_friction`: alike in strokes much longer than gap + Fc/k; short ones tell them apart.
"""

from math import copysign

from mmt_drake.effects.dahl_friction import AT_ONCE
from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Values, both_ways
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.effects.presliding_friction import FASTEST
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


def _stored(at: At, q: Own, p: Numbers) -> Result:
    Fc, k, gap = p[0], p[1], p[2]
    force = min(k * max(abs(q[0]) - 0.5 * gap, 0.0), Fc)
    return 0.5 * force * force / k if k > 0.0 else 0.0, 0.0, 0.0, 0.0


@law(Slot.BODY, remembers=True, stored=_stored)
def _play(at: At, q: Own, p: Numbers) -> Result:
    Fc, k, gap = p[0], p[1], p[2]
    if Fc == 0.0 or k == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    most = 0.5 * gap + Fc / k
    beyond = abs(q[0]) - most
    force = copysign(min(k * max(abs(q[0]) - 0.5 * gap, 0.0), Fc), q[0])
    if beyond < 0.0 or at.v * q[0] < 0.0:
        return -force, at.v, 0.0, 0.0
    # Taken along by the slider; what a step went too far decays.
    return -force, -FASTEST / 10.0 * copysign(beyond, q[0]), 0.0, FASTEST / 10.0


_turns = both_ways("sliding_velocity")  # else it is a level


def _slides(values: Values, ranges: Ranges) -> bool:
    """True where the way is longer than play and spring give, and they give at all.

    Within them it is a spring to the world; where they give nothing it is Coulomb friction.
    """
    low, high = ranges["position"]
    given, whole = 0.5 * values["gap"] * values["k"] + values["Fc"], (high - low) * values["k"]
    return _turns(values, ranges) and AT_ONCE * whole < given < whole


EFFECT = Effect(
    name="elastoplastic_play",
    block="friction",
    family="dry_friction",
    parameters=(
        Parameter("Fc", "N", NOT_NEGATIVE),
        Parameter("k", "N/m", NOT_NEGATIVE, vanishes_at=1.0, shape=True),
        Parameter("gap", "m", NOT_NEGATIVE, vanishes_at=0.0, shape=True),
    ),
    equation="F = k sgn(q) (|q| - gap/2), at most Fc; q' = v, 0 while it slides",
    source="Iwan 1966, J. Applied Mechanics 33(4), in series with play",
    law=_play,
    stiffness=lambda values: values["k"],
    passive=ALWAYS,
    engages=_slides,
    holds=("ground_spring", "coulomb_friction"),  # one that never slides, and one that slides at once
    starts=lambda scales: [
        {"Fc": 0.3 * scales.force, "k": 0.3 * scales.force / (0.1 * scales.position), "gap": part * scales.position}
        for part in (0.03, 0.3)
    ],
)
