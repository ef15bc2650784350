"""What the tests of the link share: two ends on a network in memory whose every fault is chosen."""

import socket

import numpy as np

from mmt_drake.diagrams.proof.faults.wires import End, FaultyWire
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions, LinkSignal, Role

KEY = bytes(range(1, 33))
PERIOD = 1_000_000  # [ns]
SIGNALS: dict[Role, LinkSignal] = {
    OPERATOR: LinkSignal("motion", np.zeros(6), when_lost=np.array([np.nan] * 3 + [0.0] * 3), motion=6),
    TELEROBOT: LinkSignal(
        "model", np.zeros(4), when_lost=np.array([np.nan, np.nan, 0.0, 0.0]), may_be_nan=np.arange(4) < 2
    ),
}


class Pair:
    """Both ends, a tick at a time, on one clock that the test turns; each end may see it shifted."""

    def __init__(self, options: LinkOptions = LinkOptions(), key: bytes = KEY, scenario: str = "") -> None:  # noqa: B008
        self.now = 1_000_000_000
        self.shift: dict[Role, int] = {OPERATOR: 0, TELEROBOT: 7_000_000_000}
        self.ticks: dict[Role, int] = {OPERATOR: 0, TELEROBOT: 0}
        self.there, self.back = FaultyWire(lambda: self.now), FaultyWire(lambda: self.now)
        self.options = options
        self.operator = self.start(OPERATOR)
        self.telerobot = self.start(TELEROBOT, key, scenario)
        self.sent: list[np.ndarray] = []

    def start(self, role: Role, key: bytes = KEY, scenario: str = "") -> Link:
        """A new start of one end on the same wires."""
        end = End(self.there, self.back) if role == OPERATOR else End(self.back, self.there)
        self.ticks[role] = 0
        clock = lambda: self.now + self.shift[role]  # noqa: E731
        return Link(role, SIGNALS, key, end, self.options, scenario=scenario, clock=clock)

    def connect(self) -> None:
        """Greet until both have heard each other."""
        for _ in range(60):
            self.tick()

    def tick(self, *, operator: bool = True, telerobot: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """One period; what each end shows: (model at the operator, motion at the telerobot)."""
        model, motion = np.full(4, np.nan), np.full(6, np.nan)
        if operator:
            self.operator.exchange(self.ticks[OPERATOR] * 1e-3, self.motion(), model)
            self.ticks[OPERATOR] += 1
        if telerobot:
            self.telerobot.exchange(self.ticks[TELEROBOT] * 1e-3, self.model(), motion)
            self.ticks[TELEROBOT] += 1
        self.now += PERIOD
        return model, motion

    def motion(self) -> np.ndarray:
        """A sine whose phase is the time, with its velocity; every sample differs."""
        t = self.ticks[OPERATOR] * 1e-3
        return np.concatenate([np.sin(20.0 * t + np.arange(3)), 20.0 * np.cos(20.0 * t + np.arange(3))])

    def model(self) -> np.ndarray:
        t = self.ticks[TELEROBOT] * 1e-3
        return np.array([np.nan, 500.0 + t, 1.0, 1.0])


def status(link: Link) -> dict[str, float]:
    from mmt_drake.hw.link.link import STATUS

    return dict(zip(STATUS, link.status.tolist(), strict=True))


def free_ports(count: int) -> list[int]:
    """Ports of UDP on loopback that were free just now."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for item in sockets:
        item.bind(("127.0.0.1", 0))
    ports = [item.getsockname()[1] for item in sockets]
    for item in sockets:
        item.close()
    return ports
