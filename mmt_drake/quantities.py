"""Numbers that say their unit and their range where they are declared, in the type of a field:

    class BoxParameters(Checked):
        m: Mass = 1.0

What checks them, what writes them and what fits them reads it there.
"""

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
            unit = "" if self.unit in ("", "1") else f" {self.unit}"
            expected = f"{'above ' * self.positive}{self.least:g} to {self.most:g}{unit}"
            raise BadInput(source, at=name, found=value, expected=expected)


Mass = Annotated[float, Quantity("kg", positive=True)]
Stiffness = Annotated[float, Quantity("N/m")]
Damping = Annotated[float, Quantity("N s/m")]
Level = Annotated[float, Quantity("N")]
"""Of friction."""
Time = Annotated[float, Quantity("s", positive=True)]
Delay = Annotated[float, Quantity("s")]
Length = Annotated[float, Quantity("m", positive=True)]
Speed = Annotated[float, Quantity("m/s", positive=True)]
Force = Annotated[float, Quantity("N", positive=True)]
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
    """Base of dataclasses that refuse what their types rule out.

    That is a quantity that is no number, not finite or out of range, a name that is none of a `Literal`'s, and a tuple
    of another length than its type's or with a number that is not finite. None is allowed where the type allows it.

    Raises:
        BadInput: see above.
    """

    CALLED: ClassVar[str]
    """In messages."""

    def __post_init__(self) -> None:
        owner: type = type(self)
        for name, may_be_none, allowed in _rules(owner):
            value = getattr(self, name)
            if may_be_none and value is None:
                continue
            if isinstance(allowed, Quantity):
                allowed.check(self.CALLED, name, value)
            elif isinstance(allowed, tuple) and value not in allowed:
                raise BadInput(self.CALLED, at=name, found=value, expected=f"one of {', '.join(map(str, allowed))}")
            elif isinstance(allowed, int) and not (len(value) == allowed and all(map(math.isfinite, value))):
                raise BadInput(self.CALLED, at=name, found=value, expected=f"{allowed} finite numbers")


@cache
def _rules(owner: type) -> tuple[tuple[str, bool, Quantity | tuple[object, ...] | int], ...]:
    """Of what is checked of a class: its name, whether it may be None, and the quantity, the names or the size."""
    found = quantities(owner)
    rules: list[tuple[str, bool, Quantity | tuple[object, ...] | int]] = []
    for name, hint in get_type_hints(owner).items():
        kind, parts = get_origin(hint), get_args(hint)
        if name in found:
            rules.append((name, type(None) in parts, found[name]))
        elif kind is Literal or (kind is tuple and set(parts) == {float}):
            rules.append((name, False, parts if kind is Literal else len(parts)))
    return tuple(rules)
