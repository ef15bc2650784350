"""Clearance between probe and object: a stretch of deflection in which the contact carries nothing.

d becomes sgn(d) max(abs(d) - gap/2, 0), and within the gap spring and damper are dead. gap is the total clearance; at a
touch the probe is in its middle. In the plane the clearance is round: abs(d) is the length of the deflection, and
sgn(d) its direction.

Easily confused with:

- `time_delay`: both make the force late after a reversal; strokes of one size, slow and fast, tell them apart: a
  clearance is a way, a delay is a time.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS

EFFECT = Effect(
    name="contact_gap",
    block="contact",
    family="contact_stiffness",
    parameters=(Parameter("gap", "m", NOT_NEGATIVE, rough=True),),
    equation="d becomes sgn(d) max(|d| - gap/2, 0); within the gap spring and damper are dead",
    source="Nordin and Gutman 2002, Automatica 38(10)",
    change=lambda model, values: model.with_additions(gap=values["gap"]),
    passive=ALWAYS,
    engages=lambda values, ranges: 0.5 * values["gap"] < max(map(abs, ranges["deflection"])),
    starts=lambda scales: [{"gap": part * scales.deflection} for part in (0.05, 0.2, 0.6, 1.5)],
)
