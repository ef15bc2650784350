"""Friction of a tip on the surface of a `surface_contact`: Amontons' law for a tip that sticks and slips.

The tangential force of a `surface_contact` is at most mu N, N the load along the surface normal. Below that the tip
sticks: a spring `across` times as stiff as the contact holds it, anchored where it touched. Above it slips, and the
anchor is carried along. Both as vectors in the plane that touches the surface. A tip of a `surface_contact` without
friction glides freely, so there the law vanishes at mu = 0.

Easily confused with:

- `coulomb_friction`: alike while the probe presses evenly; strokes under a light and under a heavy hand tell them
  apart.
- `viscous_friction`: alike while the probe glides at one speed; slow strokes and fast ones tell them apart.
- `load_dependent_friction`: of an object that itself slides over its table, with next to no mass and a stiff damper to
  the tip: the same force. Watching the object tells them apart.
"""

from mmt_drake.effects.changes import adds
from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.effects.passivity import ALWAYS

EFFECT = Effect(
    name="probe_slip",
    block="friction",
    family="dry_friction",
    parameters=(Parameter("mu", "1", NOT_NEGATIVE),),
    equation="the tangential force of the tip is at most mu N: it sticks below, and slips along the force above",
    source="Amontons 1699; Cattaneo 1938 and Mindlin 1949 in Johnson 1985, Contact Mechanics, chapter 7",
    change=adds("mu", "mu"),
    adds_to="mu",
    near_equal={"load_dependent_friction": "where an object with next to no mass slides over its table instead"},
    passive=ALWAYS,
    starts=lambda scales: [{"mu": 0.1}, {"mu": 0.4}],
)
