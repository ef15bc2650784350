"""Changes of a scenario: what experiments put in that should not be there, or leave out that should."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, Final

from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.effects import LIBRARY
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.network.config import ChannelConfig
from mmt_drake.rendering.updates import AtOnce, Blended
from mmt_drake.systems.flexible_box import SensorNoise

Change = Callable[[Scenario], Scenario]


@dataclass(frozen=True)
class Cause:
    """One cause of an error of the rendered force, or several together.

    Attributes:
        name: in a few words.
        group: where it sits: in a block of the station, in several, or `none`.
        change: what it makes of a scenario.
    """

    name: str
    group: str
    change: Change


NOISE: Final = SensorNoise(force=0.02, position=1e-5, velocity=5e-4)
"""Of set-up 1's sensors, where an experiment has any; what those of a Franka arm may have."""


def unchanged(scenario: Scenario) -> Scenario:
    """The scenario as it is."""
    return scenario


def together(*changes: Change) -> Change:
    """Several, one after the other."""
    return lambda scenario: reduce(lambda changed, change: change(changed), changes, scenario)


def estimating(**options: Any) -> Change:
    """Other options of the thesis's estimator."""
    return lambda scenario: replace(scenario, estimator=replace(scenario.rls, **options))


def forgetting(memory_s: float) -> Change:
    """The estimator forgets: samples count 1/e of what they did after this time, and the parameters vary."""
    return lambda scenario: estimating(forgetting=math.exp(-scenario.step / memory_s))(scenario)


def touching(thing: Callable[[FlexibleBoxModel], FlexibleBoxModel]) -> Change:
    """Another object, made of the one that is there."""

    def change(scenario: Scenario) -> Scenario:
        world = scenario.single
        return replace(scenario, environment=replace(world, object=thing(world.object)))

    return change


def sliding(friction: Friction) -> Change:
    """Other friction of the object."""
    return touching(lambda thing: replace(thing, friction=friction))


def stroking(**parameters: float | int | str) -> Change:
    """The hand strokes in another way, see `mmt_drake.motion.along_axis.strokes`."""
    return lambda scenario: replace(scenario, operator=Scripted("strokes", dict(parameters)))


def stiffening(rate: float) -> Change:
    """The object's contact spring grows stiffer by this share of itself in a second [1/s]."""
    return touching(lambda thing: LIBRARY["stiffness_drift"].apply(thing, {"rate": rate}))


def sensing(noise: SensorNoise) -> Change:
    """Noise of the telerobot's sensors."""
    return lambda scenario: replace(scenario, environment=replace(scenario.environment, noise=noise))


def at_once(name: str) -> Scenario:
    """A shipped scenario whose renderer takes up parameters as they come, as the thesis's does."""
    return rendering(updates=AtOnce())(load_scenario(name))


def noisy(name: str, **changes: Any) -> Scenario:
    """The same, changed, with noise in its sensors."""
    return sensing(NOISE)(replace(at_once(name), **changes))


def input_late(seconds: float) -> Change:
    """The hand's motion reaches the renderer late."""
    return lambda scenario: replace(scenario, to_renderer=ChannelConfig(delay=seconds))


def input_held(seconds: float) -> Change:
    """The hand's motion reaches the renderer once in a while and is held in between."""
    return lambda scenario: replace(scenario, to_renderer=ChannelConfig(rate_limit=1.0 / seconds))


def rendering(**options: Any) -> Change:
    """Other options of the renderer."""
    return lambda scenario: replace(scenario, renderer=replace(scenario.renderer, **options))


def input_placed(scenario: Scenario) -> Scenario:
    """The renderer sets its probe to each new position; what velocity it has is lost."""
    return rendering(probe="placed")(scenario)


def taken_up(seconds: float) -> Change:
    """The renderer follows new parameters with a lag of first order, and all but ignores those that change fast."""
    return rendering(updates=Blended(seconds))
