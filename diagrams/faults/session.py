"""Set-up 1 with an emulated device in the hand, as `run --hardware` has it, tick by tick on the device's own clock."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator

from mmt_drake.closing import Closing
from mmt_drake.diagrams.faults.children import KEY
from mmt_drake.diagrams.faults.table import Row
from mmt_drake.diagrams.faults.wires import End, FaultyWire
from mmt_drake.diagrams.stations.cameras import Camera
from mmt_drake.diagrams.stations.devices import Devices, Hand
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.station import Station, build_station
from mmt_drake.diagrams.stations.two_sides import build_side
from mmt_drake.hw.link import OPERATOR, TELEROBOT, Link, LinkOptions
from mmt_drake.hw.link.options import LinkSignal, Role
from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated
from mmt_drake.hw.safety import describe
from mmt_drake.realtime import Pace
from mmt_drake.recording import Recording, load
from mmt_drake.viewer.viewer import Viewer

_LOADED: list[EmulatedOmega] = []


def emulated_omega(folder: Path) -> EmulatedOmega:
    """The first emulated device, as it left the factory; the bindings of a process load one library, once.

    Args:
        folder: where to build the library, if this process has none yet.

    Raises:
        MissingDependency: the bindings or a C compiler are not installed.
    """
    if not _LOADED:
        _LOADED.append(EmulatedOmega(load_emulated(folder)))
    _LOADED[0].reset()
    return _LOADED[0]


PERIOD = 1e-3  # [s]

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

    def exchange(self, tick: float, vector: NDArray[np.float64] | None, shown: NDArray[np.float64]) -> None:
        """One tick; arguments and errors as `Link.exchange`."""
        if vector is not None:
            self.sent.add(vector.tobytes())
        super().exchange(tick, vector, shown)


class Session(Closing):
    """An emulated hand that presses and strokes; nothing happens but in `go`.

    Attributes:
        omega: the far side of the device.
        station: or the operator's side of it.
        there, back: the network from the operator and to it, if there is one.
        shown: by the link to the operator, while the peer is there, that was never sent: how often.

    Args:
        omega: the device.
        record: file for the (operator's) recording.
        apart: two sides with a link between them.
        meshcat: a viewer, where all is one.
        tell: called with what a person is told.
        scenario: of a camera, if there is one.
        camera: that sees the surface, at the telerobot's side of two.
        each: called before every tick.
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
    ) -> None:
        self.omega, self.shown = omega, 0
        omega.reset()
        omega.set(target_z=-0.02, swing_x=0.01, swing_y=0.015, swing_z=0.012, swing_hz=2.3)
        watched: Mapping[str, float] = {"peer": TIMEOUT} if apart else {}
        if camera is not None:
            watched = {**watched, "camera": camera.oldest}
        self._each = each
        self._hand = Hand(scenario.operator_device, scenario.step, watched, clock=lambda: omega.get("clock"))
        self.there, self.back = FaultyWire(self._now), FaultyWire(self._now)
        devices = Devices(self._hand, camera=None if apart else camera)
        pace = Pace()  # makes the recorder one of a run in real time
        self._sides: list[Station] = []
        self._links: list[_Link] = []
        if apart:
            sides = (
                build_side(scenario, OPERATOR, self._open, record=record, devices=devices, pace=pace, tell=tell),
                build_side(
                    scenario, TELEROBOT, self._open, record=telerobot_record(record), devices=Devices(camera=camera)
                ),
            )
            self._sides += sides
        else:
            self._sides.append(
                build_station(
                    scenario, record=record, worker=True, devices=devices, pace=pace, meshcat=meshcat, tell=tell
                )
            )
        self.station = self._sides[0]
        self._simulators = [Simulator(side.diagram) for side in self._sides]
        self.tick = 0
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
            end = self.station.diagram.GetSubsystemByName("link")
            context = end.GetMyContextFromRoot(self._simulators[0].get_context())
            shown: NDArray[np.float64] = end.GetOutputPort("received").Eval(context)
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

    @property
    def status(self) -> NDArray[np.float64]:
        """(6) of the supervisor."""
        system = self._hand.system
        context = system.GetMyContextFromRoot(self._simulators[0].get_context())
        return np.array(system.GetOutputPort("status").Eval(context))

    @property
    def armed(self) -> bool:
        """Whether the supervisor lets force through."""
        return bool(self.status[0])

    def told(self) -> str:
        """The supervisor's status in words."""
        return describe(self.status, tuple(self._hand.watched))

    def begin_moment(self) -> float:
        """Forget the greatest force; gives the time by the device's clock [s]."""
        now = self.omega.get("simulated")
        self.omega.set(greatest_force=0.0, last_force_at=now)
        return now

    def close(self) -> None:
        """Bring the device to rest and complete the recordings."""
        for side in self._sides:
            side.__exit__(None, None, None)


class Tally:
    """Moment by moment: the force that the hand felt, and what was not as it must be.

    Attributes:
        felt: moments at which there was a force.
        wrong: a line each.
    """

    def __init__(self, session: Session) -> None:
        self.felt, self.wrong = 0, list[str]()
        self._session, self._greatest, self._slowest = session, 0.0, 0.0

    def armed(self, moment: int | str) -> bool:
        """Have a person arm; whether that came to anything."""
        if self._session.arm():
            return True
        self.wrong.append(f"{moment}: cannot be armed: {self._session.told()}")
        return False

    def begin(self) -> float:
        """The moment is now; its time by the device's clock [s]."""
        self.felt += bool(self._session.omega.vector("applied").any())
        return self._session.begin_moment()

    def force_for(self, moment: int, start: float) -> float:
        """How long there was a force after the moment [s]; it must have been within its limit."""
        omega = self._session.omega
        force, on_for = omega.get("greatest_force"), omega.get("last_force_at") - start
        self._greatest, self._slowest = max(self._greatest, force), max(self._slowest, on_for)
        if force > FORCE * (1 + 1e-9) or omega.get("not_finite"):
            self.wrong.append(f"{moment}: {force:.3g} N")
        return on_for

    def surprise(self, moment: int, on_for: float) -> None:
        """The supervisor did not do what it must."""
        self.wrong.append(f"{moment}: {self._session.told()}, a force for {1e3 * on_for:.1f} ms")

    def must_stay_off(self, moment: int, ticks: int) -> None:
        """Once all is well again, no force comes back in so many ticks."""
        self._session.begin_moment()
        self._session.go(ticks)
        if self._session.omega.get("greatest_force"):
            self.wrong.append(f"{moment}: it went on by itself")

    def recorded(self, record: Path) -> Recording:
        """The operator's recording, which must have every tick."""
        recording = load(record, forces=False)
        if len(recording) != self._session.tick:
            self.wrong.append(f"{self._session.tick} ticks, of which {len(recording)} were recorded")
        return recording

    def row(self, kind: str, where: str, moments: int, recording: Recording, allowed: float | None) -> Row:
        """The line of the table; `allowed` [s] is None where the run goes on."""
        return Row(
            kind=kind,
            where=where,
            moments=moments,
            greatest_force=self._greatest,
            force_limit=FORCE,
            zero_after=math.nan if allowed is None else self._slowest,
            allowed=math.nan if allowed is None else allowed,
            unreadable=(self._session.tick - 1) * PERIOD - float(recording.time[-1]),
            wrong=tuple(self.wrong),
        )
