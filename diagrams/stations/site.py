"""The site where the parts of a station are built: what each of them may know of the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import System

from mmt_drake.beside import Later, WorkProcess, at_once
from mmt_drake.closing import Closing, close_all
from mmt_drake.cloud import ProxySettings
from mmt_drake.diagrams.stations.hands import Person, repeating
from mmt_drake.diagrams.stations.nets import shown_first
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.diagrams.stations.surfaces import SeenSurface
from mmt_drake.errors import BadInput
from mmt_drake.hw.link.options import Role
from mmt_drake.motion.placement import place
from mmt_drake.network.config import ChannelConfig
from mmt_drake.realtime import Pace
from mmt_drake.recording import Recording
from mmt_drake.viewer.viewer import Viewer

if TYPE_CHECKING:  # a simulation loads no driver
    from mmt_drake.diagrams.stations.devices import Camera, Hand, RemoteArm

T = TypeVar("T")
_ENDLESS_DURATION = 60.0  # [s] of a run whose operator has no end


@dataclass(frozen=True)
class Devices:
    """The devices of a run, open, each in place of what simulates it; None: it is simulated.

    Attributes:
        hand: a person's.
        arm: at a real object.
        camera: that sees the surface.
    """

    hand: Hand | None = None
    arm: RemoteArm | None = None
    camera: Camera | None = None

    @property
    def watched(self) -> tuple[str, ...]:
        """What the hand's supervisor has to find fresh."""
        return () if self.hand is None else tuple(self.hand.watched)

    def close(self) -> None:
        """Bring all of them to rest, the hand first: no force stays on while the others end; may be called again."""
        with ExitStack() as closing:  # from the last to the first, whatever becomes of one of them
            for device in (self.camera, self.arm, self.hand):
                if device is not None:
                    closing.callback(device.close)


@dataclass
class Site:
    """What a station is built of and for.

    Attributes:
        scenario: what to build.
        operator: replaces the scenario's hand by this recording's motion, placed automatically.
        meshcat: shows the run, and has the sliders of an interactive hand.
        worker: let an estimator that can do so, a simulated camera and what makes out its clouds work beside the clock,
            for a run in real time.
        devices: in place of what the scenario simulates.
        pace: of the run to come, to be recorded.
        tell: called with a line for a person whenever a device or its supervisor has something new.
        side: of two machines; None: both are here.
        sliders_move_hardware: an arm follows a hand on sliders too, slowly.
        spread: for a long run by simulated time: let these have processes of their own, too. Numbers are the same.
        parts: name -> system, those built so far.
        begun: processes, to be closed.
    """

    scenario: Scenario
    operator: Recording | None = None
    meshcat: Viewer | None = None
    worker: bool = False
    devices: Devices = Devices()
    pace: Pace | None = None
    tell: Callable[[str], None] | None = None
    side: Role | None = None
    sliders_move_hardware: bool = False
    spread: bool = False
    parts: dict[str, System] = field(default_factory=dict)
    begun: list[Closing] = field(default_factory=list)

    def apart(self, work: Callable[..., T], prepare: Callable[[], object] | None = None) -> Callable[..., Later[T]]:
        """How work of a part is done, as `mmt_drake.beside.Apart`."""
        if not (self.spread or self.worker):
            return at_once(work, prepare)
        beside = WorkProcess(work, prepare, in_real_time=self.worker)
        self.begun.append(beside)
        return beside.later

    def close(self) -> None:
        """End the processes that were begun; of a station that was built it does so itself."""
        close_all(self.begun)

    @property
    def step(self) -> float:
        """Of the fast path [s]."""
        return self.scenario.step

    @property
    def duration(self) -> float:
        """Of a run by default [s]."""
        return self.scenario.duration or self.person.duration or _ENDLESS_DURATION

    @cached_property
    def person(self) -> Person:
        """Whose hand it is.

        Raises:
            BadInput: a motion that cannot be read or made, or sliders without a viewer.
        """
        if self.devices.hand is not None:
            return Person(self.devices.hand.system)
        with self.refusals_named("operator"):
            if self.operator is not None:
                person = repeating(place(self.operator))
            else:
                person = self.scenario.operator.build(self.step, self.meshcat)
            person = person if self.scenario.shape is None else person.over(self.scenario.shape, self.step)
            return person if self.scenario.hand is None else person.yielding(self.scenario.hand, self.step)

    @cached_property
    def start(self) -> NDArray[np.float64]:
        """(3) where the hand starts [m]."""
        return shown_first(self.person.system, "motion")[:3]

    @cached_property
    def surface(self) -> SeenSurface:
        """What the detectors will see, as far as it is known before the run.

        Raises:
            BadInput: a file of points cannot be read; a camera does not see the object, or is not there.
        """
        with self.refusals_named("environment.cloud"):
            return self.scenario.environment.cloud.surface(self)

    @cached_property
    def proxy(self) -> ProxySettings:
        """Of the telerobot's contact detector."""
        proxy = replace(self.scenario.detector, period=self.step)
        return proxy if proxy.surface_offset is not None else replace(proxy, surface_offset=self.surface.offset)

    def seeded(self, config: ChannelConfig, seed: int) -> ChannelConfig:
        """A network whose random numbers are the scenario's, and this stream's."""
        return replace(config, seed=config.seed + self.scenario.seed + seed)

    @contextmanager
    def refusals_named(self, part: str) -> Iterator[None]:
        """Names the scenario and the part's key in it in what a part refuses.

        Raises:
            BadInput: what the part raises, named so.
        """
        try:
            yield
        except BadInput as error:
            if isinstance(error.source, Path) or Path(str(error.source)).suffix:
                raise  # a file that the scenario names: that is the place
            if error.source == self.scenario.name and error.at is not None:
                raise  # named already, with a key elsewhere in the scenario
            at = part if error.at is None else f"{part}.{error.at}"
            raise BadInput(self.scenario.name, at=at, found=error.found, expected=error.expected) from None
