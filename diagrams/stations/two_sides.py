"""A scenario on two machines: the operator's side and the telerobot's side, a diagram each, and a link between.

The parts are those of one station, cut where networks cross from side to side; a network that the scenario simulates
stays where its packets are sent, before the real one.
"""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, System

from mmt_drake.ceilings import Bound, Option, looser_options
from mmt_drake.diagrams.stations.hands import Interactive
from mmt_drake.diagrams.stations.nets import Tap
from mmt_drake.diagrams.stations.returned import RETURNED, Returned, returned
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.diagrams.stations.site import Devices, Site
from mmt_drake.diagrams.stations.station import Station, build_parts, built, wire
from mmt_drake.diagrams.stations.table import PARTS
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkSignal, Role
from mmt_drake.hw.link.systems import CloudFromLink, CloudToLink, LinkEnd
from mmt_drake.realtime import Pace
from mmt_drake.recording import Recording
from mmt_drake.viewer.viewer import Viewer

SLIDERS_MOVE_HARDWARE = Option("sliders_move_hardware", Bound(order=("no", "yes")), "yes", "no")
"""What a side tells whose arm follows a hand that can jump."""

OpenLink = Callable[[Role, Mapping[Role, LinkSignal], str], Link]
"""Makes a link from a role, what each role sends, and what else both sides must agree on."""

_CLOUDS = "clouds_to_operator"


@dataclass(frozen=True)
class Side(Station):
    """One side of a scenario, built.

    Attributes:
        link: to the other side.
        wait: for the other side before the clock starts [s]; None: do not wait.
    """

    link: Link
    wait: float | None

    def simulate(
        self, seconds: float | None = None, *, progress: Callable[[float], None] | None = None, pace: Pace | None = None
    ) -> Simulator:
        """Wait for the other side, run from time 0 until the end or its goodbye, and close recording and link.

        Raises:
            BadInput: there is no other side, or it runs another scenario.
        """
        with self:
            if self.wait is not None:
                self.link.connect(self.wait)
            return super().simulate(seconds, progress=progress, pace=pace)

    def _ended(self) -> bool:
        return self.link.ended

    def __exit__(self, kind: type[BaseException] | None = None, *_: object) -> None:
        try:
            self.link.close()  # first: the other side need not wait for its timeout; it takes no time
        finally:
            super().__exit__(kind)


def build_side(
    scenario: Scenario,
    side: Role,
    open_link: OpenLink,
    *,
    record: str | Path | None = None,
    operator: Recording | None = None,
    meshcat: Viewer | None = None,
    worker: bool = False,
    devices: Devices = Devices(),
    pace: Pace | None = None,
    tell: Callable[[str], None] | None = None,
    wait: float | None = None,
    sliders_move_hardware: bool = False,
    command: str = "",
) -> Side:
    """Build one side's diagram.

    Its systems keep their names in `build_station`; `link` is the `LinkEnd`. Outputs are the link's `alive` (1) and
    `status` (12), at the operator's side `motion` (6) and `rendered_force` (3), at the telerobot's `measurement` (9).

    Args:
        scenario: the same on both sides.
        side: which one.
        open_link: makes the link.
        record: file for this side's recording, `.mcap`.
        operator: as for `build_station`; of no use at the telerobot's side but for where the hand starts.
        meshcat: as for `build_station`, which shows what is known at this side.
        worker, pace, tell, command: as for `build_station`.
        devices: likewise; the operator's side has the hand, which watches the ages of `peer` and, where there is one,
            `camera`, the telerobot's the camera, and an arm with switches of its own.
        wait: how long to wait for the other side before the run [s].
        sliders_move_hardware: an arm here follows a hand on sliders too, slowly (`MotionRateLimiter`); else the link
            takes no such peer.

    Raises:
        BadInput: as `build_station`.
    """
    site = Site(scenario, operator, meshcat, worker, devices, pace, tell, side, sliders_move_hardware)
    other = TELEROBOT if side == OPERATOR else OPERATOR
    with ExitStack() as refused:
        refused.callback(site.close)
        everything = build_parts(site)
        signals = _signals(site)
        link = open_link(side, signals, f"{scenario.name}, step {scenario.step:g} s")
        refused.callback(link.close)
        builder = DiagramBuilder()
        end = LinkEnd(link, signals[side], signals[other], scenario.step, aged=devices.hand is not None)
        parts: dict[str, System] = {"link": end}
        parts |= {part.name: everything[part.name] for part in PARTS if part.name in everything and part.side != other}
        reads = {"link.sent": " + ".join(_crossing(everything, side)), "link.sent_age": "hand_age.age"}
        over, start = dict[str, Tap](), 0
        for net, size in _crossing(everything, other).items():
            over[net], start = Tap("link", "received", start, size), start + size
        if _CLOUDS in everything:
            frame = 1.0 / scenario.environment.cloud.rate
            if side == OPERATOR:
                parts["clouds"] = CloudFromLink(link, frame)
                over[f"{_CLOUDS}.received"] = Tap("clouds", "received")
            else:
                parts["clouds"] = CloudToLink(link, frame)
                reads["clouds.sent"] = f"{_CLOUDS}.received"
        looser = looser_options(link.options, "link") + (SLIDERS_MOVE_HARDWARE,) * sliders_move_hardware
        recorder = wire(builder, site, parts, record, over=over, reads=reads, looser_link=looser, command=command)
        diagram = built(builder, f"{scenario.name}-{side}")
        refused.pop_all()
    return Side(scenario, diagram, site.duration, recorder, devices, link, wait, begun=site.begun)


def _crossing(parts: Mapping[str, System], side: Role) -> dict[str, int]:
    """The nets that cross from a side to the other, but for clouds, and the sizes of their vectors."""
    return {
        f"{part.name}.{part.crosses}": parts[part.name].GetOutputPort(part.crosses).size()
        for part in PARTS
        if part.side == side and part.crosses is not None and part.name in parts and part.name != _CLOUDS
    }


def _may_jump(site: Site) -> bool:
    """Whether this side sends motion of a hand on sliders, or takes it."""
    if site.side == TELEROBOT:
        return site.devices.arm is None or site.sliders_move_hardware
    return site.devices.hand is None and site.operator is None and isinstance(site.scenario.operator, Interactive)


def _signals(site: Site) -> dict[Role, LinkSignal]:
    """What crosses the link. A lost operator's probe stands still; of a lost telerobot's object nothing is felt."""
    keep, more = np.nan, sum(_crossing(site.parts, OPERATOR).values()) - 6
    motion = LinkSignal(
        "motion",
        np.concatenate([site.start, np.zeros(3 + more)]),
        when_lost=np.array([keep] * 3 + [0.0] * 3 + [keep] * more),
        motion=6,
        may_jump=_may_jump(site),
    )
    back = returned(site.scenario)
    back |= {"camera_age": 1} if "camera_age" in site.parts else {}
    sizes, told = list(back.values()), [RETURNED.get(name, Returned("", 1)) for name in back]
    model = LinkSignal(
        " ".join(back),
        np.zeros(sum(sizes)),
        when_lost=np.repeat([keep if signal.kept else 0.0 for signal in told], sizes),
        may_be_nan=np.repeat([signal.may_be_nan for signal in told], sizes),
    )
    return {OPERATOR: motion, TELEROBOT: model}
