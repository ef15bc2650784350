"""Friction in proportion to the normal load: Amontons' law.

F = -mu N sgn v beside the structure's own friction, N = max(F_z, 0); at rest it holds mu N more. Where the probe does
not press there is none of it. Of a driven body N is the recorded `load`, or else the force of the drive, |gain u|:
gears rub the more, the more they carry.

Easily confused with:

- `force_crosstalk`: both follow the normal force; strokes both ways under one load tell them apart: friction turns with
  the motion.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Scales, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.FRICTION)
def _amontons(at: At, q: Own, p: Numbers) -> Result:
    level = p[0] * at.load
    return level, level, 0.0, 0.0


def _starts(scales: Scales) -> list[Values]:
    mu = scales.force / scales.load if scales.load > 0.0 else 1.0
    return [{"mu": 0.1 * mu}, {"mu": 0.4 * mu}]


EFFECT = Effect(
    name="load_dependent_friction",
    block="friction",
    family="dry_friction",
    parameters=(Parameter("mu", "1", NOT_NEGATIVE),),
    equation="mu N sgn v; at rest it holds mu N more",
    source="Amontons 1699; Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7)",
    law=_amontons,
    passive=ALWAYS,
    starts=_starts,
)
