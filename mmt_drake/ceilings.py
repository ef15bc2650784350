"""Ceilings of the options that guard a person or a device, declared once, beside the option itself:

    force: Annotated[float, Bound(12.0, "N", "its data sheet")] = 8.0

Read from there by what refuses an option beyond it (`refuse_beyond`), and by what tells, records and asks about one
that is looser than it is shipped (`looser_options`).
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from mmt_drake.errors import BadInput
from mmt_drake.quantities import declared


@dataclass(frozen=True)
class Bound:
    """The absolute bound of an option, whatever a scenario says.

    A corner of a box, (3), is bounded by the size of each of its numbers.

    Attributes:
        limit: greatest value, or the least one where `least`.
        unit: of it.
        source: who says so.
        least: smaller values are the looser ones.
        order: of an option with names, all of them allowed, the strictest first.
        without: what it means that the option is null.
        fact: of the set-up, not a limit: no value is looser than another.
    """

    limit: float = math.inf
    unit: str = ""
    source: str = ""
    least: bool = False
    order: tuple[str, ...] = ()
    without: str = ""
    fact: bool = False

    def looseness(self, value: Any) -> tuple[float, ...]:
        """Numbers, one for each of the option's, that grow with what it allows."""
        if value is None:
            return (math.inf,)
        if self.order:
            return (float(self.order.index(value)),)
        if isinstance(value, tuple):
            return tuple(abs(number) for number in value)
        return (-value if self.least else value,)

    def allows(self, value: Any) -> bool:
        """True if a value is within the bound."""
        limit = -self.limit if self.least else self.limit
        return bool(self.order) or value is None or all(number <= limit for number in self.looseness(value))


@dataclass(frozen=True)
class Option:
    """An option that has a bound.

    Attributes:
        path: of it, as `--set` has it.
        bound: that is declared beside it.
        value: that it has,
        default: and as it is shipped.
    """

    path: str
    bound: Bound
    value: Any
    default: Any

    @property
    def looser(self) -> bool:
        """True if it allows more than it does as shipped."""
        pairs = zip(self.bound.looseness(self.value), self.bound.looseness(self.default), strict=True)
        return not self.bound.fact and any(value > default for value, default in pairs)

    def line(self) -> str:
        """Of a looser one, for a person."""
        default = f"{_shown(self.default)} {self.bound.unit}".rstrip()
        without = f": {self.bound.without}" if self.value is None else ""
        return f"{self.path} = {_shown(self.value)}, looser than {default}{without}"

    def constants(self) -> dict[str, float]:
        """Of a looser one, for a recording: null is 0, a name its place among those that are allowed."""
        name = f"loosened.{self.path}"
        if isinstance(self.value, tuple):
            return {f"{name}_{axis}": number for axis, number in zip("xyz", self.value, strict=True)}
        if self.bound.order:
            return {name: self.bound.looseness(self.value)[0]}
        return {name: float(self.value or 0.0)}


def options(of: Any, at: str = "") -> Iterator[Option]:
    """Every option of a dataclass, and of those within it, that has a bound.

    Args:
        of: an instance.
        at: its own path.
    """
    owner: type = type(of)
    bounds = declared(owner, Bound)
    for field in fields(of):
        value, path = getattr(of, field.name), f"{at}.{field.name}" if at else field.name
        if field.name in bounds:
            yield Option(path, bounds[field.name], value, field.default)
        if is_dataclass(value):
            yield from options(value, path)


def looser_options(of: Any, at: str = "") -> tuple[Option, ...]:
    """Those of `options` that are looser than shipped."""
    return tuple(option for option in options(of, at) if option.looser)


def loosened_constants(found: tuple[Option, ...]) -> Mapping[str, float]:
    """Their entries among the `Recording.constants` of a recording."""
    return {name: value for option in found for name, value in option.constants().items()}


def refuse_beyond(of: Any, source: str) -> None:
    """Refuse a dataclass with an option beyond its bound.

    Args:
        of: an instance.
        source: what it is.

    Raises:
        BadInput: there is one.
    """
    for option in options(of):
        bound = option.bound
        if not bound.allows(option.value):
            most = f"{'at least' if bound.least else 'at most'} {bound.limit:g} {bound.unit} ({bound.source})"
            raise BadInput(source, at=option.path, found=option.value, expected=most)


def _shown(value: Any) -> str:
    return "null" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
