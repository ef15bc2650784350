"""What an effect is: a small declaration."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel

Apply = Callable[[FlexibleBoxModel, Mapping[str, float]], FlexibleBoxModel]


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Attributes:
        symbol: its name in model files.
        unit: SI unit.
        bounds: least and greatest value allowed.
        vanishes_at: the value at which the effect does nothing.
    """

    symbol: str
    unit: str
    bounds: tuple[float, float]
    vanishes_at: float = 0.0


@dataclass(frozen=True)
class Effect:
    """Physics that a simulation may have left out.

    Attributes:
        name: in model files and reports.
        block: the part of the system it belongs to: friction, contact, body, force_sensor or channel.
        parameters: its numbers.
        equation: its law in one line.
        source: where the law comes from.
        apply: the model with the effect in it; parameters are checked before.
        replaces: the structural parameter whose place it takes, if any.
        adds_to: the structural parameter that it adds to, if any.
        equal_to: effects that no recording can tell from it.
    """

    name: str
    block: str
    parameters: tuple[Parameter, ...]
    equation: str
    source: str
    apply: Apply
    replaces: str | None = None
    adds_to: str | None = None
    equal_to: tuple[str, ...] = ()

    def checked(self, values: Mapping[str, object], source: str) -> dict[str, float]:
        """The parameters as numbers, in the order declared.

        Raises:
            BadInput: one is missing, unknown, not a number, or outside its bounds.
        """
        symbols = [p.symbol for p in self.parameters]
        if set(values) != set(symbols):
            raise BadInput(source, at="parameters", found=f"parameters {sorted(values)}", expected=f"{sorted(symbols)}")
        checked = {}
        for p in self.parameters:
            value = values[p.symbol]
            low, high = p.bounds
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise BadInput(source, at=p.symbol, found=repr(value), expected=f"a number [{p.unit}]")
            if not low <= value <= high:
                raise BadInput(source, at=p.symbol, found=value, expected=f"a value from {low:g} to {high:g} {p.unit}")
            checked[p.symbol] = float(value)
        return checked
