"""A contact that is stiffer at one place than at another: k over x and y as a table, in the place of one k.

A lump under the skin, a bone under soft tissue. The load along the normal is k(x, y) times the depth, and where the tip
sticks it is held along the surface by `across` times that stiffness. Between the columns `x` and the rows `y` of the
grid k is bicubic, beyond them as at the rim. `stiffness` is row by row from the least y on; `deviation` says how well
each is known (one standard deviation) and does nothing.

All values are learned together with the numbers of the contact, and with the heights where the surface is unknown too.
How smooth k is held is what predicts places best that the fit has not seen. Light and hard presses at the same places
tell a stiff place from a high one.

Easily confused with:

- `surface_shape`: under an even load a high place and a stiff one are alike; light and hard presses tell them apart.
- `nonlinear_stiffness`: where the probe presses harder at some places than at others; the same load everywhere tells
  them apart.
- `stiffness_drift`: a scan that goes over each place once cannot tell a stiffer place from a stiffer time; a second
  scan in another order tells them apart.
"""

from mmt_drake.effects.changes import lays_out
from mmt_drake.effects.effect import NOT_NEGATIVE, Effect
from mmt_drake.effects.over_places import checked_table, over_places

EFFECT = Effect(
    name="stiffness_map",
    block="contact",
    family="contact_stiffness",
    parameters=over_places("stiffness", "N/m", vanishes_at="k2", bounds=NOT_NEGATIVE),
    equation="k(x, y) in the place of k, bicubic over a grid",
    source="Catmull and Rom 1974, Computer Aided Geometric Design; Johnson 1985, Contact Mechanics, chapter 4",
    change=lays_out("stiffness", "stiffness"),
    check=checked_table("stiffness"),
    replaces="k2",
    needs=("surface",),
    starts=lambda scales: [],  # learned, not searched for
)
