"""A contact whose force grows with a power of its depth: a ball pressed into something elastic (Hertz: 3/2).

k d^p along the surface normal, in the place of normal.k, d = -z the depth; the damper stays. In a `kelvin_voigt`, whose
one axis it is, in the place of k, with d = x - x0 and the sign of d. A cone has p = 2, a flat punch p = 1. Near the
surface it is soft (p > 1) or stiff (p < 1) without bounds.

Easily confused with:

- `hunt_crossley_damping`: of a `kelvin_voigt`: both grow with the depth; slow presses tell them apart: only the spring
  is felt in them.
- `nonlinear_stiffness`: of a `kelvin_voigt`: over a narrow range of depths both are a line that bends; presses from a
  touch on tell them apart.
"""

from math import copysign

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Scales, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law

_EXPONENTS = (1.5, 2.0, 0.7)  # of a ball, a cone, and what softens


def _stored(at: At, q: Own, p: Numbers) -> Result:
    return p[0] * abs(at.d) ** (p[1] + 1.0) / (p[1] + 1.0), 0.0, 0.0, 0.0


@law(Slot.CONTACT, stored=_stored)
def _power(at: At, q: Own, p: Numbers) -> Result:
    return copysign(p[0] * abs(at.d) ** p[1], at.d), 0.0, 0.0, 0.0


def _starts(scales: Scales) -> list[Values]:
    along = scales.normal or scales
    return [{"k": along.stiffness * along.deflection ** (1.0 - p), "p": p} for p in _EXPONENTS]


EFFECT = Effect(
    name="power_law_stiffness",
    block="contact",
    family="contact_stiffness",
    axis="z",
    parameters=(Parameter("k", "N/m^p", NOT_NEGATIVE, vanishes_at="normal_k"), Parameter("p", "1", (0.2, 10.0), 1.0)),
    equation="k d^p along the surface normal, d = -z, in the place of normal.k",
    source="Hertz 1882, J. reine und angewandte Mathematik 92; Johnson 1985, Contact Mechanics, chapters 4 and 5",
    law=_power,
    replaces="normal_k",
    needs=("normal_k",),
    passive=ALWAYS,
    starts=_starts,
)
