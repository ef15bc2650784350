"""Effects and their numbers as people write them."""

from typing import Final

from mmt_drake.effects.effect import Effect

_PROPER: Final = {"coulomb": "Coulomb", "stribeck": "Stribeck", "hunt crossley": "Hunt-Crossley", "dahl": "Dahl"}


def words(name: str) -> str:
    """A name as people write it: `static_friction` is static friction, `coulomb_friction` Coulomb friction."""
    written = name.replace("_", " ")
    for lower, proper in _PROPER.items():
        written = written.replace(lower, proper)
    return written


def law_words(effect: Effect) -> list[str]:
    """The name of an effect, and each of its numbers with # in the place of the value: `k3 = # N/m^3`."""
    values = (f"{p.symbol} = #" + ("" if p.unit == "1" else f" {p.unit}") for p in effect.parameters)
    return [words(effect.name), *values]
