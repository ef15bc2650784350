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

from mmt_drake.effects.effect import Effect, Parameter, Values
from mmt_drake.errors import BadInput
from mmt_drake.model.height_map import HeightMap
from mmt_drake.model.structure import Structure
from mmt_drake.model.surface_contact import SurfaceContact


def _shape(values: Values) -> HeightMap:
    return HeightMap(tuple(values["x"]), tuple(values["y"]), tuple(values["height"]))


def _check(model: Structure, values: Values, source: str) -> None:
    try:
        shape = _shape(values)
    except BadInput as error:
        raise BadInput(source, at=error.at, found=error.found, expected=error.expected) from None
    known = values["deviation"]
    if len(known) != len(shape.height) or min(known) < 0.0:
        expected = f"{len(shape.height)}, one for each height, none below 0"
        raise BadInput(
            source, at="deviation", found=f"{len(known)} deviations from {min(known, default=0.0):g}", expected=expected
        )


def _change(model: Structure, values: Values) -> Structure:
    assert isinstance(model, SurfaceContact)  # nothing else has a surface
    return model.with_surface(_shape(values))


EFFECT = Effect(
    name="surface_shape",
    block="geometry",
    family="geometry",
    parameters=(
        Parameter("x", "m", vanishes_at=(0.0, 1.0), kind="list"),
        Parameter("y", "m", vanishes_at=(0.0, 1.0), kind="list"),
        Parameter("height", "m", vanishes_at=(0.0, 0.0, 0.0, 0.0), kind="list"),
        Parameter("deviation", "m", vanishes_at=(0.0, 0.0, 0.0, 0.0), kind="list"),
    ),
    equation="contact along the normal of z = h(x, y), h bicubic over a grid, in the place of z = height",
    source="Catmull and Rom 1974, Computer Aided Geometric Design; Johnson 1985, Contact Mechanics, chapter 1",
    change=_change,
    check=_check,
    replaces="height",
    needs=("surface",),
    starts=lambda scales: [],  # learned, not searched for
)
