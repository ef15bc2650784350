"""Friction that gives a little before it slides: a spring at each turn of the motion, a level far from it (Dahl).

F' = sigma v (1 - F/Fc sgn v) with a level Fc of its own, beside whatever the structure has. The way from one level to
the other is some Fc/sigma long, whatever the speed: ball bearings, gears, cables.

Easily confused with:

- `coulomb_friction`: alike in strokes much longer than Fc/sigma; strokes of that length about one spot tell them apart.
- `presliding_friction`: alike where the structure's own Fc is the level; there sigma0 is sigma.
- `hysteresis`: in a driven body the same loop.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Values, both_ways
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.effects.presliding_friction import bristles
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law, norm


def _stored(at: At, q: Own, p: Numbers) -> Result:
    return 0.5 * p[1] * q[0] ** 2, 0.0, 0.0, 0.0


@law(Slot.BODY, remembers=True, in_plane=True, stored=_stored)
def _dahl(at: At, q: Own, p: Numbers) -> Result:
    Fc, sigma = p[0], p[1]
    if Fc == 0.0 or sigma == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    z_rate, slip = bristles(q[0], at.v, norm(at.v, at.v_across), sigma, Fc)
    return -sigma * q[0], z_rate, 0.0, slip


_YIELDING = 0.1  # of Fc/sigma: a way in which a tenth of the spring is gone
AT_ONCE = 1e-4
"""Part of the way of a recording within which no recording shows how friction sets in."""
_turns = both_ways("sliding_velocity")  # else it is a level


def _yields(values: Values, ranges: Ranges) -> bool:
    """True where the way is long enough for the bristles to yield, and they do not yield at once.

    On a shorter way they are a spring to the world; those that yield at once are Coulomb friction.
    """
    low, high = ranges["position"]
    wound_up = (high - low) * values["sigma"]
    return _turns(values, ranges) and _YIELDING * values["Fc"] < wound_up and AT_ONCE * wound_up < values["Fc"]


EFFECT = Effect(
    name="dahl_friction",
    block="friction",
    family="dry_friction",
    parameters=(
        Parameter("Fc", "N", NOT_NEGATIVE),
        Parameter("sigma", "N/m", NOT_NEGATIVE, vanishes_at=1.0, shape=True),
    ),
    equation="F, F' = sigma v (1 - F/Fc sgn v)",
    source="Dahl 1968, A Solid Friction Model, Aerospace Corporation TOR-0158(3107-18)-1",
    law=_dahl,
    stiffness=lambda values: values["sigma"],
    passive=ALWAYS,
    engages=_yields,
    holds=("ground_spring", "coulomb_friction"),  # one that never yields, and one that yields at once
    starts=lambda scales: [
        {"Fc": 0.3 * scales.force, "sigma": 0.3 * scales.force / (part * scales.position)} for part in (0.01, 0.1, 0.5)
    ],
)
