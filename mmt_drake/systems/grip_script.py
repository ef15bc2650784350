"""A grip that closes and opens at given times."""

import math

from mmt_drake.systems.leaf import LeafSystem

RISE = 0.2
"""Time in which it closes, and opens [s]."""


class GripScript(LeafSystem):
    """The grip of a simulated hand: closed from one time of a cycle to another.

    .. pydrake_system::

        name: GripScript
        output_ports:
        - grip

    - `grip` (1): its force [N], which rises and falls evenly within 0.2 s, a function of the Context's time.

    Args:
        closes, opens: when it begins to, after the start of a cycle [s].
        force: of the closed grip [N].
        cycle: after which it begins again [s]; None: never.
    """

    def __init__(
        self, closes: float = 7.0, opens: float = 17.5, force: float = 10.0, cycle: float | None = None
    ) -> None:
        super().__init__()
        self._closes, self._opens, self._grip = closes, opens, force
        self._cycle = math.inf if cycle is None else cycle
        self.declare_function("grip", 1, self._at)

    def _at(self, t: float) -> float:
        t = math.fmod(t, self._cycle)
        return self._grip * min(max(min((t - self._closes) / RISE, 1.0 - (t - self._opens) / RISE), 0.0), 1.0)
