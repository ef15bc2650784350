"""Several objects on the remote side's table, as a scenario has them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydrake.systems.framework import System

from mmt_drake.cloud.tracking_options import Tracking
from mmt_drake.diagrams.stations.environment import NOISE_SEED
from mmt_drake.diagrams.stations.surfaces import SimulatedDepthCamera, SurfaceCloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.realsense.view import GREY, Colour, Solid, TableScene
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.scene_layout import MOST
from mmt_drake.model.structure import Additions
from mmt_drake.quantities import Quantity, quantities
from mmt_drake.systems.flexible_box import SensorNoise
from mmt_drake.systems.objects_on_table import ObjectsOnTable
from mmt_drake.systems.on_table import Hang, OnTable
from mmt_drake.systems.scene_tracker import SceneTracker

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site


@dataclass(frozen=True)
class PlacedObject:
    """One of several objects. In a file its `object` may have `effects`, too.

    Attributes:
        at: x, y of the middle of its top at first [m].
        size: its sides along x and y, and its height [m]; of a cylinder the first is the diameter.
        round: it is a cylinder.
        colour: of it, as a camera sees it: sRGB from 0 to 1.
        object: its structure and numbers.
        centre: its centre of mass below its top, where a grip holds it [m]; null: half its height.
    """

    at: tuple[float, float] = (0.0, 0.0)
    size: tuple[float, float, float] = (0.08, 0.08, 0.05)
    round: bool = False
    colour: Colour = GREY
    object: FlexibleBoxModel = FlexibleBoxModel()
    centre: Annotated[float | None, Quantity("m", 0.005, 0.5)] = None

    def __post_init__(self) -> None:
        for value in self.size:
            check_number("object", "size", value, least=0.0, open_interval=True)
        if not all(0.0 <= value <= 1.0 for value in self.colour):
            raise BadInput("object", at="colour", found=self.colour, expected="red, green and blue from 0 to 1")
        if self.centre is not None:
            quantities(PlacedObject)["centre"].check("object", "centre", self.centre)
            if self.centre >= self.size[2]:
                expected = f"within the object, whose height is {self.size[2]:g}"
                raise BadInput("object", at="centre", found=self.centre, expected=expected)

    def hang(self, grip: Hang | None) -> Hang | None:
        """How it hangs in a grip; None: there is no grip, or it has effects, and no grip takes it."""
        if grip is None or self.object.additions != Additions():
            return None
        return replace(grip, centre=0.5 * self.size[2] if self.centre is None else self.centre)


@dataclass(frozen=True)
class SeveralObjects:
    """Several objects that slide on a table and push each other; the tip touches the one whose top it comes down on.

    Attributes:
        things: they, by name.
        noise: of the sensors.
        cloud: how they are seen.
        table: height of the table in the table frame [m].
        tracking: how they are told apart.
        laws: `foreign`: by the simulation that shares no physics with the model, in which they do not meet.
    """

    things: dict[str, PlacedObject] = field(default_factory=lambda: {"box": PlacedObject()})
    noise: SensorNoise = SensorNoise()
    cloud: SurfaceCloud | SimulatedDepthCamera = SurfaceCloud()
    table: Annotated[float, Quantity("m", -1.0, 1.0)] = -0.05
    tracking: Tracking = field(default_factory=Tracking)
    laws: Literal["own", "foreign"] = "own"

    def __post_init__(self) -> None:
        quantities(SeveralObjects)["table"].check("environment", "table", self.table)
        if not 0 < (n := len(self.things)) <= MOST:
            raise BadInput("environment", at="things", found=n or "none", expected=f"one object, {MOST} at most")
        if isinstance(self.cloud, SurfaceCloud) and self.cloud.file is not None:
            expected = "null: the tops of the objects are what is seen"
            raise BadInput("environment", at="cloud.file", found=self.cloud.file, expected=expected)
        self.tracking.refuse_period(1.0 / self.cloud.rate, "environment", "tracking.latency")
        if self.laws == "foreign":
            self._check_foreign()

    def _check_foreign(self) -> None:
        for name, thing in self.things.items():
            for number in ("k1", "b1"):
                if (found := getattr(thing.object.parameters, number)) != 0.0:
                    at = f"things.{name}.object.parameters.{number}"
                    raise BadInput("environment", at=at, found=found, expected="0 where laws are foreign")

    @property
    def object(self) -> FlexibleBoxModel:
        """The first of them, for who asks for one."""
        return next(iter(self.things.values())).object

    def on_table(self, grip: Hang | None = None) -> tuple[OnTable, ...]:
        """All of them, in their order, and how they hang in a grip, if there is one."""
        return tuple(
            OnTable(
                thing.object,
                thing.at,
                thing.size,
                thing.round,
                self.table + thing.size[2],
                thing.hang(grip),
                name=f"things.{name}.",
            )
            for name, thing in self.things.items()
        )

    def sensing(self) -> str | None:
        """See `SensedObject.sensing`."""
        return None if self.noise == SensorNoise() else "noise"

    def solids(self) -> TableScene:
        """What a camera looks at."""
        solids = (
            Solid(each.size, each.at, self.table + each.size[2], each.round, each.colour)
            for each in self.things.values()
        )
        return TableScene(tuple(solids), self.table, probe=0.005)

    def build(self, site: Site) -> System:
        """The plant.

        Raises:
            BadInput: the object is to be a real one; or as `ObjectsOnTable`.
        """
        if site.devices.arm is not None:
            raise BadInput(site.scenario.name, at="environment", found="!SeveralObjects", expected="one, under an arm")
        ideal = self.cloud if isinstance(self.cloud, SurfaceCloud) else None
        carrying = site.scenario.carrying
        return ObjectsOnTable(
            self.on_table(None if carrying is None else carrying.hang),
            laws=self.laws,
            period=site.step,
            noise=replace(self.noise, seed=self.noise.seed + site.scenario.seed + NOISE_SEED),
            spacing=0.0 if ideal is None else ideal.size / max(ideal.points, 1) ** 0.5,
            cloud_period=1.0 / self.cloud.rate,
            cloud_noise=0.0 if ideal is None else ideal.noise,
        )

    def tracker(self, site: Site) -> SceneTracker:
        """What sees them."""
        latency = 0.0 if isinstance(self.cloud, SurfaceCloud) else self.cloud.latency
        # Not in the tick in which a cloud is taken over: that is work enough.
        offset = latency + 1.5 * site.step
        grips = site.scenario.carrying is not None
        return SceneTracker(
            self.table,
            self.tracking,
            period=1.0 / self.cloud.rate,
            offset=offset,
            grips=grips,
            apart=site.apart,
            waits=not site.worker,
        )
