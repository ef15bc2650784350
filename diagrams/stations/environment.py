"""The remote side's object and its sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantValueSource

from mmt_drake.cloud import Cloud
from mmt_drake.diagrams.stations.surfaces import DepthCamera, SimulatedDepthCamera, SurfaceCloud
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.systems.flexible_box import FlexibleBox, SensorNoise

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.site import Site

#: Karnopp friction of the thesis's set-up 1 (section 4.1).
THESIS_FRICTION = Friction(Fs=0.1, Fd=0.05, v_d=0.005)

_NOISE_SEED = 101  # apart from the station's other random streams


@dataclass(frozen=True)
class Environment:
    """The remote side's object and sensors; the defaults are the thesis's set-up 1.

    In a file the object may have `effects` too, as in a model file.
    """

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
        """The object; of a real one under an arm its top as it was measured."""
        if site.devices.arm is not None:
            return _still(site.surface.shown)
        return FlexibleBox(
            self.object,
            period=site.step,
            noise=replace(self.noise, seed=self.noise.seed + site.scenario.seed + _NOISE_SEED),
            surface=site.surface.shown,
            cloud_period=1.0 / self.cloud.rate,
            cloud_noise=site.surface.noise,
        )


def _still(surface: Cloud) -> Diagram:
    """A surface that does not move, `point_cloud`."""
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantValueSource(AbstractValue.Make(surface)))
    builder.ExportOutput(source.get_output_port(), "point_cloud")
    diagram = builder.Build()
    diagram.set_name("still_surface")
    return diagram
