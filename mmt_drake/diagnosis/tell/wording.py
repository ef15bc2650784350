"""Names as people write them."""

from collections.abc import Iterable
from typing import Final

from mmt_drake.diagnosis.decide.budget import NAMELESS, PARAMETERS, SHARED

_PARTS: Final = {
    PARAMETERS: "wrong parameters",
    SHARED: "parameters and effects together",
    NAMELESS: "what nobody has named",
}
_PROPER: Final = {"coulomb": "Coulomb", "stribeck": "Stribeck", "hunt crossley": "Hunt-Crossley"}


def words(name: str) -> str:
    """A name as people write it: `static_friction` is static friction, `coulomb_friction` Coulomb friction."""
    written = name.replace("_", " ")
    for lower, proper in _PROPER.items():
        written = written.replace(lower, proper)
    return written


def all_words(names: Iterable[str]) -> str:
    """Names side by side: `static friction + contact gap`."""
    return " + ".join(map(words, names))


def part_words(part: str) -> str:
    """A part of a budget as people write it."""
    return _PARTS.get(part, words(part))
