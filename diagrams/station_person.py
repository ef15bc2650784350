"""Whose hand it is, of those that are simulated."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import resources
from pathlib import Path

from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, System

from mmt_drake.diagrams import scenario as options
from mmt_drake.diagrams.scenario import Scenario
from mmt_drake.errors import BadInput
from mmt_drake.motion.placement import place
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.recording import Recording, load
from mmt_drake.systems.interactive_operator import InteractiveOperator
from mmt_drake.systems.recorded_operator import RecordedOperator
from mmt_drake.systems.scripted_operator import ScriptedOperator
from mmt_drake.systems.yielding_hand import YieldingHand
from mmt_drake.viewer.viewer import Viewer

_BUILTIN = "builtin:"
ORIGIN = (0.0, 0.0)


def load_operator(file: str | Path) -> Recording:
    """A recording of a hand; `builtin:NAME` is one that the package ships.

    Raises:
        BadInput: there is none, or it cannot be read.
    """
    name = str(file)
    if not name.startswith(_BUILTIN):
        return load(file, forces=False)
    shipped = resources.files("mmt_drake") / "data" / f"{name.removeprefix(_BUILTIN)}.npz"
    with resources.as_file(shipped) as path:
        if not path.exists():
            raise BadInput("operator", found=name, expected="builtin:hand_reaching or a file")
        return replace(load(path, forces=False), source=name)


def person(
    scenario: Scenario, recording: Recording | None, meshcat: Viewer | None
) -> tuple[System, float | None, tuple[float, float]]:
    """As `_operator`, and the hand yields if it is to.

    Raises:
        BadInput: a motion that cannot be read or made, or sliders without a viewer.
    """
    with told_of(scenario, "operator"):
        hand, length, middle = _operator(scenario, recording, meshcat)
        if scenario.hand is None:
            return hand, length, middle
        return _yielding(hand, YieldingHand(scenario.hand, period=scenario.step)), length, middle


def _operator(
    scenario: Scenario, recording: Recording | None, meshcat: Viewer | None
) -> tuple[LeafSystem, float | None, tuple[float, float]]:
    """The hand, how long its motion is [s] if it ends, and the middle (x, y) of what it covers [m]."""
    hand = scenario.operator
    if recording is not None:
        return _repeating(place(recording))
    if isinstance(hand, options.Recorded):
        return _repeating(place(load_operator(hand.file), hand.placement))
    if isinstance(hand, options.Scripted):
        scripted = scripted_motion(hand.motion, **hand.parameters)
        return ScriptedOperator(scripted), scripted.cycle, ORIGIN
    if meshcat is None:
        raise BadInput("operator", found="!Interactive", expected="a viewer: run with --meshcat")
    sliders = InteractiveOperator(
        meshcat, period=scenario.step, bandwidth=hand.bandwidth, greatest_speed=hand.greatest_speed
    )
    return sliders, None, ORIGIN


def _repeating(motion: SampledMotion) -> tuple[LeafSystem, float, tuple[float, float]]:
    x, y = 0.5 * (motion.position[:, :2].min(axis=0) + motion.position[:, :2].max(axis=0))
    operator = RecordedOperator(motion.time, motion.position, motion.velocity)
    return operator, motion.duration, (float(x), float(y))


@contextmanager
def told_of(scenario: Scenario, part: str) -> Iterator[None]:
    """Lets what a part refuses be told with the scenario and the part's place in it.

    Raises:
        BadInput: what the part raises, told so.
    """
    try:
        yield
    except BadInput as error:
        if isinstance(error.source, Path) or Path(str(error.source)).suffix:
            raise  # a file that the scenario names: that is the place
        at = part if error.at is None else f"{part}.{error.at}"
        raise BadInput(scenario.name, at=at, found=error.found, expected=error.expected) from None


def _yielding(intention: LeafSystem, hand: YieldingHand) -> Diagram:
    """An operator whose hand yields."""
    builder = DiagramBuilder()
    for system in (intention, hand):
        builder.AddSystem(system)
    builder.Connect(intention.GetOutputPort("motion"), hand.GetInputPort("intended"))
    builder.ExportInput(hand.GetInputPort("force"), "force")
    builder.ExportOutput(hand.GetOutputPort("motion"), "motion")
    return builder.Build()
