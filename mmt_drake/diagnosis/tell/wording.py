"""Names as people write them."""

from __future__ import annotations

from typing import Final

_PROPER: Final = {"coulomb": "Coulomb", "stribeck": "Stribeck", "hunt crossley": "Hunt-Crossley"}


def words(name: str) -> str:
    """A name as people write it: `static_friction` is static friction, `coulomb_friction` Coulomb friction."""
    written = name.replace("_", " ")
    for lower, proper in _PROPER.items():
        written = written.replace(lower, proper)
    return written
