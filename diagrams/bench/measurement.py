"""One line of `mmt-drake bench`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


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

    def to_json(self, command: str) -> dict[str, Any]:
        """As the contract has a figure that a command prints; `met` beside it."""
        return {
            "name": self.name,
            "value": float(self.value),
            "unit": self.unit,
            "target": self.target,
            "command": command,
            "met": self.met,
        }
