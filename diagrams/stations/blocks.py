"""The station's blocks with the signals of its recordings at their ports, for `mmt_drake.diagnosis.decide.blocks`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from pydrake.systems.framework import DiagramBuilder, System

from mmt_drake.cloud import Cloud
from mmt_drake.diagnosis.decide.blocks import Block, Surface
from mmt_drake.diagrams.stations.nets import Nets, Tap
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.diagrams.stations.station import build_parts, reading, station_nets
from mmt_drake.diagrams.stations.surfaces import SurfaceCloud
from mmt_drake.diagrams.stations.table import RECORDED
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.systems.flexible_box import SensorNoise

_BLOCKS: Final = {
    "to_telerobot": ("position", "velocity"),
    "environment": ("force", "in_contact", "body_position"),
    "detector": ("detected_contact", "proxy_position"),
    "estimator": ("filtered_force", "estimated_force", "theta", "theta_stable"),
    "renderer": ("rendered_force",),
}
"""Blocks in the order of the signal's way -> what is compared of each."""

_BEFORE: Final = {"renderer": ("to_operator", "to_renderer", "renderer")}  # what arrives there is not recorded
_SENSED: Final = {"position": "tip[0:3]", "velocity": "tip[3:6]"}  # measured by sensors; what a block had is this


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
    world, renderer = scenario.single, scenario.renderer
    for at, chosen, good, expected in (
        ("renderer", renderer, renderer.name == "runge_kutta", "!ImpedanceReflection"),
        ("telerobot", scenario.telerobot, scenario.telerobot is None, "none: blocks are those of set-up 1"),
        ("environment.cloud", world.cloud, isinstance(world.cloud, SurfaceCloud), "!SurfaceCloud"),
        ("environment.surface", scenario.shape, scenario.shape is None, "none: its normals are not recorded"),
        ("touch", scenario.touch, scenario.touch is None, "null: the corrected cloud is not recorded"),
    ):
        if not good:
            raise BadInput(scenario.name, at=at, found=f"!{type(chosen).__name__}", expected=expected)
    # Noise is no part of what is believed; what it does to the outputs is found by the comparison.
    quiet = replace(world, noise=SensorNoise(), object=world.object if model is None else model)
    site = Site(replace(scenario, environment=quiet))
    parts = build_parts(site)
    nets = station_nets(site, parts)
    known = [*RECORDED.items(), *_SENSED.items()]
    recorded = {tap: name for name, net in known if (tap := nets.tap(net)) is not None}
    environment = parts["environment"]
    shown: Cloud = environment.GetOutputPort("point_cloud").Eval(environment.CreateDefaultContext())  # undisplaced
    surface = Surface("point_cloud", shown, 1.0 / world.cloud.rate, site.surface.noise)
    blocks = []
    for name, compared in _BLOCKS.items():
        inside = [part for part in _BEFORE.get(name, (name,)) if part in parts]
        system, inputs = _cut(nets, inside, recorded)
        of_block = {signal: tap for tap, signal in recorded.items() if tap.part == name}
        outputs = {signal: (of_block[signal].port, of_block[signal].start) for signal in compared if signal in of_block}
        sees = surface if name == "detector" else None
        blocks.append(Block(name, system, inputs, outputs, sees, sensed=name in ("environment", "detector")))
    return tuple(blocks)


def _cut(nets: Nets, inside: Sequence[str], recorded: Mapping[Tap, str]) -> tuple[System, dict[str, tuple[str, ...]]]:
    """Parts of a station by themselves, with the outputs of the last: their inputs, and the signals that make these up.

    What was not recorded stays unconnected.
    """
    last, within, inputs = inside[-1], {}, {}
    for name, sources in reading(inside).items():
        taps = [] if nets.input(name) is None else nets.taps(sources)
        if taps and taps[0].part in inside:
            within[name] = sources
        elif signals := tuple(signal for tap in taps for signal in _signals(tap, recorded)):
            inputs[name] = signals
    if len(inside) == 1:
        return nets.parts[last], {name.partition(".")[2]: signals for name, signals in inputs.items()}
    builder = DiagramBuilder()
    for part in inside:
        builder.AddNamedSystem(part, nets.parts[part])
    shown = {tap.port for tap in recorded if tap.part == last}
    nets.connect(builder, within, {port: f"{last}.{port}" for port in shown})
    for name in inputs:
        builder.ExportInput(nets.input(name), name)
    return builder.Build(), inputs


def _signals(tap: Tap, recorded: Mapping[Tap, str]) -> list[str]:
    """The signals that a tap is recorded as, one after the other; none if it is not recorded whole."""
    found, start = [], tap.start
    while start < tap.start + tap.size:
        part = next((other for other in recorded if other[:3] == (tap.part, tap.port, start)), None)
        if part is None:
            return []
        found.append(recorded[part])
        start += part.size
    return found
