"""What effects have in common whose numbers are a table over the places of a surface."""

import math
from collections.abc import Callable

from mmt_drake.effects.effect import Parameter, Values
from mmt_drake.errors import BadInput
from mmt_drake.model.place_table import PlaceTable
from mmt_drake.model.structure import Structure

_CORNERS = 4


def over_places(
    symbol: str, unit: str, *, vanishes_at: float | str, bounds: tuple[float, float] = (-math.inf, math.inf)
) -> tuple[Parameter, ...]:
    """The parameters: columns x and rows y of the grid, a value for each place, how well each is known."""
    return (
        Parameter("x", "m", vanishes_at=(0.0, 1.0), kind="list"),
        Parameter("y", "m", vanishes_at=(0.0, 1.0), kind="list"),
        Parameter(symbol, unit, bounds, vanishes_at=(vanishes_at,) * _CORNERS, kind="list"),
        Parameter("deviation", unit, vanishes_at=(0.0,) * _CORNERS, kind="list"),
    )


def table_of(values: Values, symbol: str) -> PlaceTable:
    """The table that values of these parameters are."""
    return PlaceTable(tuple(values["x"]), tuple(values["y"]), tuple(values[symbol]))


def checked_table(symbol: str) -> Callable[[Structure, Values, str], None]:
    """The check of an effect: an even grid, a value and a deviation for each place."""

    def check(model: Structure, values: Values, source: str) -> None:
        try:
            table = table_of(values, symbol)
        except BadInput as error:
            raise BadInput(source, at=error.at or symbol, found=error.found, expected=error.expected) from None
        known = values["deviation"]
        if len(known) != len(table.value) or min(known) < 0.0:
            found = f"{len(known)} deviations from {min(known, default=0.0):g}"
            expected = f"{len(table.value)}, one for each {symbol}, none below 0"
            raise BadInput(source, at="deviation", found=found, expected=expected)

    return check
