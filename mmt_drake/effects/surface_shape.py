"""A surface that is not level: its height h over x and y as a table, in the place of `height` of a `surface_contact`.

The contact acts along the normal of z = h(x, y): a slope turns the force, a hill makes it grow. Between the columns `x`
and the rows `y` of the grid h is bicubic, beyond them level as at the rim. `height` is row by row from the least y on;
`deviation` says how well each height is known (one standard deviation) and does nothing.

It is learned where no cloud was recorded: all heights together with the numbers of the contact, and how smooth they are
by how well places that the fit has not seen are predicted. Where the probe never was, h is carried on evenly.

Easily confused with:

- `frame_misalignment`: a force sensor askew by a constant angle turns all forces as a tilted plane does; a probe that
  glides a long way down the plane tells them apart: there its depth changes.
- `stiffness_drift`: a scan that goes over each place once cannot tell a higher place from a stiffer time; a second scan
  in another order tells them apart.
- `probe_slip`: over a scan one way friction tilts the force as a slope does; scans both ways tell them apart.
"""

from mmt_drake.effects.changes import lays_out
from mmt_drake.effects.effect import Effect
from mmt_drake.effects.over_places import checked_table, over_places

EFFECT = Effect(
    name="surface_shape",
    block="geometry",
    family="geometry",
    parameters=over_places("height", "m", vanishes_at=0.0),
    equation="contact along the normal of z = h(x, y), h bicubic over a grid, in the place of z = height",
    source="Catmull and Rom 1974, Computer Aided Geometric Design; Johnson 1985, Contact Mechanics, chapter 1",
    change=lays_out("surface", "height"),
    check=checked_table("height"),
    replaces="height",
    needs=("surface",),
    starts=lambda scales: [],  # learned, not searched for
)
