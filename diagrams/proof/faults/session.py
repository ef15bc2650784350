"""Set-up 1 with an emulated device in the hand, as `run --hardware` has it, tick by tick on the device's own clock."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.proof.faults.injection import PERIOD, HandRig
from mmt_drake.diagrams.proof.faults.wires import End, FaultyWire
from mmt_drake.diagrams.stations.devices import Camera, Hand
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import Station, build_station
from mmt_drake.diagrams.stations.two_sides import build_side
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions, LinkSignal, Role
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.numeric.arrays import Array
from mmt_drake.realtime import Pace
from mmt_drake.viewer.viewer import Viewer

KEY = bytes(range(32))  # of the link
TIMEOUT = 0.05  # of the link [s]
FORCE = 4.0  # the supervisor's limit [N]
CHANGES = (
    "estimator=!OutputErrorOptions {}",
    "operator_device.device=0",
    f"operator_device.limits.force={FORCE:g}",
    "operator_device.limits.rise=0.02",
)
SCENARIO = load_scenario("setup1", [*CHANGES, "environment.cloud.points=2000"])

_PRESS = 130  # ticks from pressing the arm switch until it has sprung back, and the force has come back
_TOUCHING = 300  # ticks until the hand is where it presses
_HEALING = 200  # ticks after which two sides must have found each other


def telerobot_record(record: Path) -> Path:
    """The other side's file, beside the operator's."""
    return record.with_suffix(".telerobot.mcap")


class _Link(Link):
    """Keeps what it has sent."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.sent: set[bytes] = set()

    def exchange(self, tick: float, vector: Array | None, shown: Array) -> None:
        """One tick; arguments and errors as `Link.exchange`."""
        if vector is not None:
            self.sent.add(vector.tobytes())
        super().exchange(tick, vector, shown)


class Session(HandRig):
    """An emulated hand that presses and strokes; nothing happens but in `go`.

    Attributes:
        station: or the operator's side of it.
        there, back: the network from the operator and to it, if there is one.
        shown: by the link to the operator, while the peer is there, that was never sent: how often.

    Args:
        omega: the device.
        record: file for the (operator's) recording.
        apart: two sides with a link between them.
        meshcat: a viewer, where all is one.
        tell: called with each line for a person.
        scenario: of a camera, if there is one.
        camera: that sees the surface, at the telerobot's side of two.
        each: called before every tick.
        worker: fits have a process of their own, which takes a while to begin.
    """

    def __init__(
        self,
        omega: EmulatedOmega,
        record: Path,
        *,
        apart: bool = False,
        meshcat: Viewer | None = None,
        tell: Callable[[str], None] | None = None,
        scenario: Scenario = SCENARIO,
        camera: Camera | None = None,
        each: Callable[[], object] = lambda: None,
        worker: bool = False,
    ) -> None:
        self.omega, self.shown, self._each = omega, 0, each
        omega.reset()
        omega.set(target_z=-0.02, swing_x=0.01, swing_y=0.015, swing_z=0.012, swing_hz=2.3)
        watched = {"peer": TIMEOUT} if apart else {}
        if camera is not None:
            watched["camera"] = camera.oldest
        self._hand = Hand(scenario.operator_device, scenario.step, watched, clock=lambda: omega.get("clock"))
        self.there, self.back = FaultyWire(self._now), FaultyWire(self._now)
        self._links: list[_Link] = []
        devices = Devices(self._hand, camera=None if apart else camera)
        pace = Pace()  # makes the recorder one of a run in real time
        if apart:
            there, record_there = Devices(camera=camera), telerobot_record(record)
            self._sides: tuple[Station, ...] = (
                build_side(scenario, OPERATOR, self._open, record=record, devices=devices, pace=pace, tell=tell),
                build_side(scenario, TELEROBOT, self._open, record=record_there, devices=there),
            )
        else:
            whole = build_station(
                scenario, record=record, worker=worker, devices=devices, pace=pace, meshcat=meshcat, tell=tell
            )
            self._sides = (whole,)
        self.station = self._sides[0]
        self._simulators = [Simulator(side.diagram) for side in self._sides]
        self.simulator, self.supervised, self.watched = self._simulators[0], self._hand.system, tuple(watched)
        self.go(_TOUCHING)

    def _now(self) -> int:
        return 10**9 + round(1e9 * self.omega.get("clock"))

    def _open(self, role: Role, signals: Mapping[Role, LinkSignal], agreed: str) -> Link:
        end = End(self.there, self.back) if role == OPERATOR else End(self.back, self.there)
        link = _Link(role, signals, KEY, end, LinkOptions(timeout=TIMEOUT), scenario=agreed, clock=self._now)
        self._links.append(link)
        return link

    def go(self, ticks: int) -> None:
        """So many ticks."""
        for _ in range(ticks):
            self._each()
            for simulator in self._simulators:
                simulator.AdvanceTo((self.tick + 0.5) * PERIOD)  # up to the next tick and not into it
            self.omega.advance(PERIOD)
            self.tick += 1
            if self._links:
                self._compare()

    def _compare(self) -> None:
        """Whether what the operator's end shows was sent by the telerobot's, to the bit."""
        if self._links[0].alive and self.tick > 1:
            shown = self.read(self.station.diagram.GetSubsystemByName("link"), "received")
            self.shown += shown.tobytes() not in self._links[1].sent

    def arm(self) -> bool:
        """A person presses the switch once all is well, and the force comes back; gives whether it does."""
        for _ in range(_HEALING):
            if all(link.alive for link in self._links):
                break
            self.go(1)
        self.go(10)
        self._hand.switch.arm()
        self.go(_PRESS)
        return self.armed

    def close(self) -> None:
        """Bring the device to rest and complete the recordings."""
        for side in self._sides:
            side.__exit__(None, None, None)
