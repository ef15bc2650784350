"""The station's blocks with the signals of its recordings at their ports, for `mmt_drake.diagnosis.blocks`."""

from __future__ import annotations

from dataclasses import replace

from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import Demultiplexer, PassThrough

from diagrams.scenario import ImpedanceReflection, Scenario
from diagrams.station import station_parts
from mmt_drake.cloud import Cloud
from mmt_drake.diagnosis.blocks import Block, Surface
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.recording import Recording
from mmt_drake.systems.flexible_box import SensorNoise

_MODEL = (8, 1, 1)  # what crosses the network: theta, stable, in_contact


def station_blocks(
    scenario: Scenario, *, model: FlexibleBoxModel | None = None, operator: Recording | None = None
) -> tuple[Block, ...]:
    """The station that one believes in, block by block, in the order of the signal's way.

    `to_telerobot`, `environment`, `detector`, `estimator` and `renderer`, the last with the network before it, since
    what arrives there is not recorded.

    Args:
        scenario: what one believes was run.
        model: the object that one believes in, in the place of the scenario's.
        operator: whose hand replaced the scenario's.

    Raises:
        BadInput: the scenario cannot be built, or its renderer sees clouds, of which no recording has all.
    """
    if not isinstance(scenario.renderer, ImpedanceReflection):
        raise BadInput(scenario.name, at="renderer", found="!ProxySpring", expected="!ImpedanceReflection")
    world = scenario.environment
    # Noise is no part of what is believed; what it does to the outputs is found by the comparison.
    quiet = replace(world, noise=SensorNoise(), object=world.object if model is None else model)
    parts, _ = station_parts(replace(scenario, environment=quiet), operator=operator)
    return (
        Block(
            "to_telerobot",
            parts["to_telerobot"],
            {"sent": ("master_position", "master_velocity")},
            {"position": ("received", 0), "velocity": ("received", 3)},
        ),
        Block(
            "environment",
            parts["environment"],
            {"motion": ("position", "velocity")},
            {"force": ("measurement", 6), "in_contact": ("in_contact", 0), "body_position": ("body", 0)},
            sensed=True,
        ),
        Block(
            "detector",
            parts["detector"],
            {"position": ("position",)},
            {"detected_contact": ("in_contact", 0), "proxy_position": ("proxy", 0)},
            surface=Surface("point_cloud", _surface(parts["environment"]), 1.0 / world.cloud.rate, world.cloud.noise),
            sensed=True,
        ),
        Block(
            "estimator",
            parts["estimator"],
            {"measurement": ("position", "velocity", "force"), "in_contact": ("detected_contact",)},
            {
                "filtered_force": ("filtered_force", 0),
                "estimated_force": ("estimated_force", 0),
                "theta": ("theta", 0),
                "theta_stable": ("stable", 0),
            },
        ),
        Block(
            "renderer",
            _with_network(parts["to_operator"], parts["renderer"]),
            {
                "motion": ("master_position", "master_velocity"),
                "sent": ("theta", "theta_stable", "detected_contact"),
            },
            {"rendered_force": ("force", 0)},
        ),
    )


def _surface(environment: System) -> Cloud:
    """The undisplaced surface, which the environment shows before the first update."""
    cloud: Cloud = environment.GetOutputPort("point_cloud").Eval(environment.CreateDefaultContext())
    return cloud


def _with_network(network: System, renderer: System) -> Diagram:
    """The renderer behind the network, with the inputs `motion` and `sent`."""
    builder = DiagramBuilder()
    for system in (network, renderer):
        builder.AddSystem(system)
    motion = builder.AddSystem(PassThrough(renderer.GetInputPort("motion").size()))
    split = builder.AddSystem(Demultiplexer(list(_MODEL)))
    builder.ExportInput(motion.get_input_port(), "motion")
    builder.ExportInput(network.GetInputPort("sent"), "sent")
    builder.Connect(motion.get_output_port(), renderer.GetInputPort("motion"))
    builder.Connect(network.GetOutputPort("received"), split.get_input_port())
    for i, name in enumerate(("theta", "stable", "in_contact")):
        builder.Connect(split.get_output_port(i), renderer.GetInputPort(name))
    builder.ExportOutput(renderer.GetOutputPort("force"), "force")
    return builder.Build()
