"""The remote side's object and its sensors."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantValueSource

from mmt_drake.cloud import Cloud
from mmt_drake.diagrams.stations.surfaces import DepthCamera, SimulatedDepthCamera, SurfaceCloud
from mmt_drake.errors import BadInput
from mmt_drake.foreign.numbers import Numbers
from mmt_drake.foreign.options import ForeignLaws, ForeignSensors
from mmt_drake.foreign.plant import STEP_S
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Additions, Friction
from mmt_drake.quantities import Quantity, quantities
from mmt_drake.surfaces import Cylinder, HeightField, Mesh, Plane, Saddle, Shape, Sphere, Step, locate
from mmt_drake.systems.flexible_box import FlexibleBox, SensorNoise
from mmt_drake.systems.foreign_box import ForeignBoxSystem
from mmt_drake.systems.objects_on_table import ObjectsOnTable
from mmt_drake.systems.on_table import Hang, OnTable

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site

#: Karnopp friction of the thesis's set-up 1 (section 4.1).
THESIS_FRICTION = Friction(Fs=0.1, Fd=0.05, v_d=0.005)

Top = Plane | Sphere | Cylinder | Saddle | Step | HeightField | Mesh

NOISE_SEED = 101
"""Apart from the station's other random streams."""


@dataclass(frozen=True)
class SensedObject:
    """Base of the environments: the remote side's object and sensors.

    Attributes:
        object: its structure and numbers.
        noise: of the sensors.
        cloud: how its top is seen.
    """

    laws_when_carried: ClassVar[Literal["own", "foreign"]] = "own"
    object: FlexibleBoxModel = FlexibleBoxModel(friction=THESIS_FRICTION)
    noise: SensorNoise = SensorNoise()
    cloud: SurfaceCloud | SimulatedDepthCamera | DepthCamera = SurfaceCloud()

    def __post_init__(self) -> None:
        try:
            self.object.kernel_vector()
        except BadInput as error:
            at = f"object.parameters.{error.at}"
            raise BadInput("environment", at=at, found=error.found, expected=error.expected) from None

    def build(self, site: Site) -> System:
        """The object; of a real one under an arm its top as it was measured.

        Raises:
            BadInput: the hand starts below its surface.
        """
        if site.devices.arm is not None:
            return _still(site.surface.shown)
        if site.scenario.shape is not None:
            _check_start(site, site.scenario.shape)
        carrying = site.scenario.carrying
        return (self.simulated if carrying is None else partial(self.graspable, carrying.hang))(
            period=site.step,
            noise=replace(self.noise, seed=self.noise.seed + site.scenario.seed + NOISE_SEED),
            surface=site.surface.shown,
            cloud_period=1.0 / self.cloud.rate,
            cloud_noise=site.surface.noise,
        )

    def graspable(self, hang: Hang, *, surface: Cloud, **shown: Any) -> System:
        """The object in simulation where a grip may carry it; its surface, and `shown` as for `simulated`."""
        return ObjectsOnTable([OnTable(self.object, hang=hang, surface=surface)], laws=self.laws_when_carried, **shown)

    @property
    def plain(self) -> bool:
        """Whether there is nothing but an object and white noise."""
        return True

    def sensing(self) -> str | None:
        """The first field that says something of sensors, if any does: a telerobot has its own."""
        return None if self.noise == SensorNoise() else "noise"

    @abstractmethod
    def simulated(self, **shown: Any) -> System:
        """The object in simulation.

        Args:
            shown: period, noise and surface, as `FlexibleBox` takes them.
        """


@dataclass(frozen=True)
class Environment(SensedObject):
    """The remote side's object and sensors; the defaults are the thesis's set-up 1.

    In a file the object may have `effects` too, as in a model file.

    Attributes:
        surface: the shape of its top; null: level, z = 0 without end. A hand that is scripted or recorded over a level
            one is laid over it where it stays and is smooth. An estimator then reads what is measured in the frame of
            the surface, and a detector beside the operator says where that is.
    """

    surface: Top | None = None

    def simulated(self, **shown: Any) -> System:
        """See `SensedObject.simulated`."""
        return FlexibleBox(self.object, shape=self.surface, **shown)


@dataclass(frozen=True)
class ForeignBox(SensedObject):
    """The same object by a simulation that shares no physics with the model: the test of whoever knows the model.

    Friction is a vector in the plane and sticks by a spring-slider without Karnopp's band (`mmt_drake.foreign.plant`).

    Attributes:
        sensors: errors of the telerobot's sensors beside white noise.
        laws: what no estimator here knows of.
        surface: height of the true surface above where it is seen and rendered, z = 0 [m].
    """

    laws_when_carried = "foreign"
    sensors: ForeignSensors = ForeignSensors()
    laws: ForeignLaws = ForeignLaws()
    surface: Annotated[float, Quantity("m", -0.02, 0.02)] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        quantities(ForeignBox)["surface"].check("environment", "surface", self.surface)
        if self.object.additions != Additions():
            found, expected = "effects of the model", "none: a !ForeignBox has `laws` of its own"
            raise BadInput("environment", at="object.effects", found=found, expected=expected)
        self._numbers()

    def sensing(self) -> str | None:
        """See `SensedObject.sensing`."""
        return super().sensing() or (None if self.sensors == ForeignSensors() else "sensors")

    @property
    def plain(self) -> bool:
        """See `SensedObject.plain`."""
        return (self.sensors, self.laws, self.surface) == (ForeignSensors(), ForeignLaws(), 0.0)

    def simulated(self, **shown: Any) -> System:
        """See `SensedObject.simulated`."""
        return ForeignBoxSystem(self._numbers(), self.sensors, **shown)

    def _numbers(self) -> Numbers:
        numbers = self.laws.added_to(numbers_of(self.object)._replace(surface=self.surface))
        numbers.checked(STEP_S)
        return numbers


def numbers_of(model: FlexibleBoxModel) -> Numbers:
    """An object without effects, for the simulation that shares no physics with it."""
    body, normal = model.parameters, model.normal
    friction = model.friction or Friction.coulomb(body.Fc)
    return Numbers(
        **{name: getattr(body, name) for name in ("m", "k1", "k2", "b1", "b2")},
        normal_k=normal.k,
        normal_b=normal.b,
        Fs=friction.Fs,
        Fd=friction.Fd,
    )


def _check_start(site: Site, shape: Shape) -> None:
    x, y, z = site.start.tolist()
    depth, _ = locate(shape.packed(), (x, y, z), (0.0, 0.0, 0.0))
    if depth > 0.0:
        found, expected = f"a surface {1e3 * depth:.1f} mm above where the hand starts", "one below it: `at` moves it"
        raise BadInput(site.scenario.name, at="environment.surface", found=found, expected=expected)


def _still(surface: Cloud) -> Diagram:
    """A surface that does not move, `point_cloud`."""
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantValueSource(AbstractValue.Make(surface)))
    builder.ExportOutput(source.get_output_port(), "point_cloud")
    diagram = builder.Build()
    diagram.set_name("still_surface")
    return diagram
