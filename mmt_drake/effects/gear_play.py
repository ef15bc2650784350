"""Play of a transmission: gears, couplings and cables between which the input turns before the output does.

The output is pulled along only while the input has it beyond the clearance: d = ratio u + offset - x becomes
sgn(d) max(abs(d) - gap/2, 0), and within the gap spring and damper are dead. gap is the total clearance, measured at
the output; there the output coasts until friction stops it. Slow motions draw a loop of this width over the input.

Easily confused with:

- `coulomb_friction`: slow motions draw the same loop, of width 2 Fc/k, and without a mass they are equal; fast
  reversals, in which the output coasts across the gap, tell them apart.
- `time_delay`: both make the output late after a reversal; strokes of one size, slow and fast, tell them apart: play
  is a way, a delay is a time.
- `dead_band`: a stretch about one place of the input, not after each reversal; motion elsewhere tells them apart.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS

EFFECT = Effect(
    name="gear_play",
    block="drive",
    family="drive_train",
    parameters=(Parameter("gap", "m", NOT_NEGATIVE),),
    equation="d = ratio u + offset - x becomes sgn(d) max(|d| - gap/2, 0); within the gap spring and damper are dead",
    source="Nordin and Gutman 2002, Automatica 38(10)",
    change=lambda model, values: model.with_additions(gap=values["gap"]),
    needs=("ratio",),
    equal_massless=("coulomb_friction",),
    passive=ALWAYS,
    # Slow motions leave the output half the gap behind; what was fitted without it has taken a part of that.
    starts=lambda scales: [{"gap": part * scales.force / scales.stiffness} for part in (0.5, 2.0, 4.0)],
)
