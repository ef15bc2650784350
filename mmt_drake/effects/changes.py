"""What effects do that change a model in the place of a law: the `change` of each kind."""

from collections.abc import Callable, Sequence

from mmt_drake.effects.effect import Values
from mmt_drake.effects.over_places import table_of
from mmt_drake.model.structure import Structure

Change = Callable[[Structure, Values], Structure]


def adds(symbol: str, parameter: str) -> Change:
    """Adds the effect's one parameter to a number of the structure."""
    return lambda model, values: model.with_value(symbol, model.value(symbol) + values[parameter])


def turns_or_moves(field: str, parameters: Sequence[str]) -> Change:
    """Makes the effect's three parameters a vector of `Additions`."""
    return lambda model, values: model.with_additions(**{field: tuple(values[symbol] for symbol in parameters)})


def lays_out(field: str, parameter: str) -> Change:
    """Puts the effect's table over places into a tip on a surface."""
    return lambda model, values: model.with_parameters(**{field: table_of(values, parameter)})
