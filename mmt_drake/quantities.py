"""Numbers that say their unit and their range where they are declared, in the type of a field:

    class BoxParameters(Checked):
        m: Mass = 1.0

What checks them, what writes them and what fits them reads it there.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, TypeVar, get_args, get_origin, get_type_hints

from mmt_drake.errors import BadInput, check_number

Declared = TypeVar("Declared")


@dataclass(frozen=True)
class Quantity:
    """A number.

    Attributes:
        unit: SI unit.
        least, most: that it may be.
        positive: above `least`, which it may not be itself.
        whole: a whole number.
    """

    unit: str
    least: float = 0.0
    most: float = math.inf
    positive: bool = False
    whole: bool = False

    def check(self, source: str, name: str, value: Any) -> None:
        """Refuse what is no number, not finite or out of range.

        Raises:
            BadInput: the value is refused.
        """
        if isinstance(value, bool) or not isinstance(value, numbers.Integral if self.whole else numbers.Real):
            expected = "a whole number" if self.whole else "a number"
            raise BadInput(source, at=name, found=repr(value), expected=expected)
        number: Any = value
        if math.isinf(self.most):
            check_number(source, name, number, least=self.least, open_interval=self.positive)
        elif not (self.least < number if self.positive else self.least <= number) or not number <= self.most:
            expected = f"{'above ' * self.positive}{self.least:g} to {self.most:g} {self.unit}"
            raise BadInput(source, at=name, found=value, expected=expected)


Mass = Annotated[float, Quantity("kg", positive=True)]
Stiffness = Annotated[float, Quantity("N/m")]
Damping = Annotated[float, Quantity("N s/m")]
Level = Annotated[float, Quantity("N")]
"""Of friction."""
Time = Annotated[float, Quantity("s", positive=True)]
Delay = Annotated[float, Quantity("s")]
Share = Annotated[float, Quantity("", 0.0, 1.0)]
Seed = Annotated[int, Quantity("", 0, 2**53, whole=True)]
"""Whole numbers that float64 holds, like every seed here."""


def quantities(owner: type) -> Mapping[str, Quantity]:
    """The fields of a class that are quantities, in their order."""
    return declared(owner, Quantity)


@cache
def declared(owner: type, kind: type[Declared]) -> Mapping[str, Declared]:
    """The fields of a class whose types are annotated with something of this kind, and with what."""
    hints = get_type_hints(owner, include_extras=True)
    return {
        name: extra
        for name, hint in hints.items()
        for extra in getattr(hint, "__metadata__", ())
        if isinstance(extra, kind)
    }


class Checked:
    """Base of dataclasses that refuse quantities out of range, and names that are none of a `Literal`'s.

    Raises:
        BadInput: a quantity that is no number, not finite or out of range, unless it is None and may be; another name.
    """

    CALLED: ClassVar[str]
    """In messages."""

    def __post_init__(self) -> None:
        owner: type = type(self)
        for name, quantity, names in _rules(owner):
            value = getattr(self, name)
            if value in names:
                continue
            if quantity is None:
                raise BadInput(self.CALLED, at=name, found=value, expected=f"one of {', '.join(map(str, names))}")
            quantity.check(self.CALLED, name, value)


@cache
def _rules(owner: type) -> tuple[tuple[str, Quantity | None, tuple[object, ...]], ...]:
    """For each quantity and each choice of a class its name, the quantity, and what else it may be."""
    hints, found = get_type_hints(owner), quantities(owner)
    numbers = tuple((name, of, (None,) if type(None) in get_args(hints[name]) else ()) for name, of in found.items())
    return numbers + tuple((name, None, get_args(hint)) for name, hint in hints.items() if get_origin(hint) is Literal)
