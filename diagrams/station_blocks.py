"""The station's blocks with the signals of its recordings at their ports, for `mmt_drake.diagnosis.decide.blocks`."""

from __future__ import annotations

from dataclasses import replace

from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import PassThrough

from mmt_drake.cloud import Cloud
from mmt_drake.diagnosis.decide.blocks import Block, Surface
from mmt_drake.diagrams.ports import split
from mmt_drake.diagrams.scenario import ImpedanceReflection, Scenario, SurfaceCloud
from mmt_drake.diagrams.station import station_parts
from mmt_drake.diagrams.station_record import RETURNED
from mmt_drake.diagrams.station_return import returned
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.systems.flexible_box import SensorNoise


def station_blocks(scenario: Scenario, *, model: FlexibleBoxModel | None = None) -> tuple[Block, ...]:
    """The station that one believes in, block by block, in the order of the signal's way.

    `to_telerobot`, `environment`, `detector`, `estimator` and `renderer`, the last with what comes before it, since
    what arrives there is not recorded.

    Args:
        scenario: what one believes was run.
        model: the object that one believes in, in the place of the scenario's.

    Raises:
        BadInput: the scenario cannot be built, or its renderer or its camera needs what no recording has.
    """
    if not isinstance(scenario.renderer, ImpedanceReflection):
        found = f"!{type(scenario.renderer).__name__}"
        raise BadInput(scenario.name, at="renderer", found=found, expected="!ImpedanceReflection")
    if scenario.telerobot is not None:
        found = f"!{type(scenario.telerobot).__name__}"
        raise BadInput(scenario.name, at="telerobot", found=found, expected="none: blocks are those of set-up 1")
    world = scenario.environment
    if not isinstance(world.cloud, SurfaceCloud):
        found = f"!{type(world.cloud).__name__}"
        raise BadInput(scenario.name, at="environment.cloud", found=found, expected="!SurfaceCloud")
    # Noise is no part of what is believed; what it does to the outputs is found by the comparison.
    quiet = replace(world, noise=SensorNoise(), object=world.object if model is None else model)
    parts, _ = station_parts(replace(scenario, environment=quiet))
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
            _with_network(parts["to_operator"], returned(scenario), parts["renderer"], parts.get("to_renderer")),
            {
                "motion": ("master_position", "master_velocity"),
                "sent": tuple(RETURNED[name] for name in returned(scenario)),
                **({"in_contact": ("operator_contact",)} if scenario.switching == "operator" else {}),
            },
            {"rendered_force": ("force", 0)},
        ),
    )


def _surface(environment: System) -> Cloud:
    """The undisplaced surface, which the environment shows before the first update."""
    cloud: Cloud = environment.GetOutputPort("point_cloud").Eval(environment.CreateDefaultContext())
    return cloud


def _with_network(network: System, sent: dict[str, int], renderer: System, from_hand: System | None) -> Diagram:
    """The renderer behind the network and what is between it and the hand.

    Its inputs are `motion`, `sent` (names of the renderer's ports and sizes) and, where that is not sent, `in_contact`.
    """
    builder = DiagramBuilder()
    motion = from_hand or PassThrough(renderer.GetInputPort("motion").size())
    for name, system in (("network", network), ("renderer", renderer), ("from_hand", motion)):
        builder.AddNamedSystem(name, system)
    builder.ExportInput(motion.get_input_port(0), "motion")
    builder.ExportInput(network.GetInputPort("sent"), "sent")
    builder.Connect(motion.get_output_port(0), renderer.GetInputPort("motion"))
    arrived = split(builder, network.GetOutputPort("received"), tuple(sent.values()))
    for port, name in zip(arrived, sent, strict=True):
        builder.Connect(port, renderer.GetInputPort(name))
    if "in_contact" not in sent:
        builder.ExportInput(renderer.GetInputPort("in_contact"), "in_contact")
    builder.ExportOutput(renderer.GetOutputPort("force"), "force")
    return builder.Build()
