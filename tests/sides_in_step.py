"""Both sides of a run on two machines in this process, on a network in memory."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.diagrams.stations.two_sides import Side, build_side
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, ROLES, LinkSignal, Role

KEY = bytes(range(1, 33))


class InStep:
    """A tick of each side in turn, and what crosses between them.

    Args:
        scenario: of both.
        folder: for a recording of each, named after its role.
        ahead: by how much the operator's clock is ahead of the telerobot's [ns].
    """

    def __init__(self, scenario: Scenario, folder: Path, ahead: int = 0) -> None:
        self.now = 10**9
        self.cut = False
        self._step, self._tick = scenario.step, round(scenario.step * 1e9)
        queues: dict[Role, list[bytes]] = {role: [] for role in ROLES}
        self.sides: dict[Role, Side] = {}
        for role in ROLES:
            other = ROLES[1 - ROLES.index(role)]
            opened = self._opener(queues[other], queues[role], ahead if role == OPERATOR else 0)
            self.sides[role] = build_side(scenario, role, opened, record=folder / f"{role}.mcap")
        for _ in range(60):
            for role in ROLES:
                self.sides[role].link.poll()
            self.now += self._tick
        self.simulators = {role: Simulator(side.diagram) for role, side in self.sides.items()}

    def _opener(self, out: list[bytes], back: list[bytes], ahead: int) -> Callable[..., Link]:
        owner = self

        class Socket:
            def send(self, datagram: bytes) -> bool:
                if not owner.cut:
                    out.append(datagram)
                return True

            def receive(self) -> bytes | None:
                return back.pop(0) if back else None

            def close(self) -> None:
                pass

        def open_link(role: Role, signals: Mapping[Role, LinkSignal], agreed: str) -> Link:
            return Link(role, signals, KEY, Socket(), scenario=agreed, clock=lambda: self.now + ahead)

        return open_link

    def ticks(self, start: int, stop: int) -> Iterator[int]:
        """Simulate, a tick at a time."""
        for tick in range(start + 1, stop + 1):
            self.now += self._tick
            for simulator in self.simulators.values():  # the operator first
                simulator.AdvanceTo(tick * self._step)
            yield tick

    def read(self, role: Role, port: str) -> NDArray[np.float64]:
        """An output of a side's diagram."""
        diagram, context = self.sides[role].diagram, self.simulators[role].get_context()
        value: NDArray[np.float64] = diagram.GetOutputPort(port).Eval(context)
        return value.copy()

    def close(self) -> None:
        """End both recordings."""
        for side in self.sides.values():
            side.__exit__(None, None, None)
