"""Measurements: numbers taken here and now, each with its target."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

from mmt_drake.diagrams.proof.studies.columns import Column, documents


@dataclass(frozen=True)
class Measurement:
    """A measured number.

    Attributes:
        name: what was measured.
        value: the number.
        unit: its unit.
        target: what it should reach; None if it is there for information.
        at_least: the target is a lower bound, not an upper one.
    """

    name: str
    value: float
    unit: str
    target: float | None = None
    at_least: bool = False

    @property
    def met(self) -> bool | None:
        """Whether the target is reached; None without one."""
        if self.target is None:
            return None
        return bool(self.value >= self.target if self.at_least else self.value <= self.target)

    @property
    def measured(self) -> str:
        """The number and its unit."""
        return f"{self.value if isinstance(self.value, int) else f'{self.value:.3g}'} {self.unit}".rstrip()

    @property
    def bound(self) -> str:
        """The target in words; empty without one."""
        return "" if self.target is None else f"at {'least' if self.at_least else 'most'} {self.target:.3g}"

    def __str__(self) -> str:
        verdict = f" (target: {self.bound}; {'reached' if self.met else 'MISSED'})" if self.bound else ""
        return f"{self.name}: {self.measured}{verdict}"


COLUMNS: Final[tuple[Column[Measurement], ...]] = (
    Column(lambda one: one.name, "name", "figure"),
    Column(lambda one: float(one.value), "value"),
    Column(lambda one: one.unit, "unit"),
    Column(lambda one: one.measured, "", "measured"),
    Column(lambda one: one.target, "target"),
    Column(lambda one: one.bound if one.met is not False else f"{one.bound} (missed)", "", "target"),
    Column(lambda one: one.met, "met"),
)


def figures_of(measured: Iterable[Measurement], command: str) -> list[dict[str, Any]]:
    """As the contract has figures that a command prints; `met` beside them."""
    return [{**one, "command": command} for one in documents(measured, COLUMNS)]
