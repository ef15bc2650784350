"""A spring and a damper between the probe and the world."""

from __future__ import annotations

from dataclasses import dataclass

from mmt_drake.errors import check_number


@dataclass(frozen=True)
class KelvinVoigt:
    """F = F0 - k (x - x0) - b v: the contact in the normal axis, a damper, a tissue.

    Attributes:
        k: stiffness [N/m], >= 0.
        b: damping [N s/m], >= 0.
        x0: rest position [m].
        F0: force at rest [N].

    Raises:
        BadInput: a negative stiffness or damping.
    """

    k: float = 0.0
    b: float = 0.0
    x0: float = 0.0
    F0: float = 0.0

    def __post_init__(self) -> None:
        for name in ("k", "b"):
            check_number("parameters", name, getattr(self, name), least=0.0)

    def affine(self) -> tuple[float, float, float]:
        """(p, q, r) of F = p x + q v + r."""
        return -self.k, -self.b, self.F0 + self.k * self.x0
