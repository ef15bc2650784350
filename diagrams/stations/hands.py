"""The simulated hands of a scenario: one follows a named motion, one repeats a recording, one is on sliders."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from scipy.interpolate import CubicSpline

from mmt_drake.diagrams.stations.nets import Nets
from mmt_drake.errors import BadInput
from mmt_drake.motion.analytic import Motion
from mmt_drake.motion.placement import Placement, place
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.motion.yielding import HandImpedance
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, load
from mmt_drake.surfaces import Shape, locate
from mmt_drake.systems.interactive_operator import InteractiveOperator
from mmt_drake.systems.scripted_operator import ScriptedOperator
from mmt_drake.systems.yielding_hand import YieldingHand
from mmt_drake.viewer.viewer import Viewer

_BUILTIN = "builtin:"


class Person(NamedTuple):
    """Somebody's hand.

    Attributes:
        system: with the ports of every operator.
        duration: of the motion, if it ends [s].
        middle: x, y of what the hand covers [m].
        motion: that it makes whatever it feels, if that is known before.
    """

    system: System
    duration: float | None = None
    middle: tuple[float, float] = (0.0, 0.0)
    motion: Motion | None = None

    def over(self, shape: Shape, step: float) -> Person:
        """The same whose motion over a level surface is laid over another, where that is one that stays and is smooth.

        A height above the level becomes one along the normal.

        Args:
            shape: of the surface.
            step: between the samples of the motion [s].

        Raises:
            BadInput: the hand leaves the surface.
        """
        if self.motion is None or self.duration is None or not shape.LAID or shape.fixed_to != "world":
            return self
        time = np.linspace(0.0, self.duration, round(self.duration / step) + 1)
        position = laid(shape, self.motion.sample(time)[0])
        velocity = np.asarray(CubicSpline(time, position)(time, 1), dtype=np.float64)
        return repeating(SampledMotion(time, position, velocity))

    def yielding(self, impedance: HandImpedance, period: float) -> Person:
        """The same who yields to what is felt."""
        parts = {"intention": self.system, "hand": YieldingHand(impedance, period=period)}
        builder = DiagramBuilder()
        for name, system in parts.items():
            builder.AddNamedSystem(name, system)
        Nets(parts).connect(builder, {"hand.intended": "intention.motion"}, {"motion": "hand.motion"})
        builder.ExportInput(parts["hand"].GetInputPort("force"), "force")
        diagram: Diagram = builder.Build()
        return self._replace(system=diagram)


@dataclass(frozen=True)
class Scripted:
    """A hand that follows a named motion (`mmt_drake.motion.SCRIPTED`).

    Attributes:
        motion: its name.
        parameters: of the motion; those left out keep their defaults.
    """

    motion: str = "strokes"
    parameters: dict[str, float | int | str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Whose motion it is, in a word."""
        return self.motion

    def build(self, period: float, meshcat: Viewer | None) -> Person:
        """The hand.

        Raises:
            BadInput: there is no such motion.
        """
        motion = scripted_motion(self.motion, **self.parameters)
        return Person(ScriptedOperator(motion), motion.cycle, motion=motion)


@dataclass(frozen=True)
class Recorded:
    """A hand that repeats a recording.

    Attributes:
        file: any recording with a probe's position; `builtin:NAME` is one that the package ships.
        placement: how it is put onto the table; null chooses by what the recording holds.
    """

    file: str = "builtin:hand_reaching"
    placement: Placement | None = None

    @property
    def name(self) -> str:
        """Whose motion it is, in a word."""
        return self.file

    def build(self, period: float, meshcat: Viewer | None) -> Person:
        """The hand.

        Raises:
            BadInput: the file cannot be read, or its motion not be put onto the table.
        """
        return repeating(place(load_operator(self.file), self.placement))


@dataclass(frozen=True)
class Interactive:
    """A hand on three sliders of the viewer's page.

    Attributes:
        bandwidth: of the filter that smooths the sliders [Hz].
        greatest_speed: of the hand along each axis [m/s].
    """

    bandwidth: float = 2.0
    greatest_speed: float = 0.5
    name = "sliders"

    def build(self, period: float, meshcat: Viewer | None) -> Person:
        """The hand.

        Raises:
            BadInput: there is no viewer for the sliders.
        """
        if meshcat is None:
            raise BadInput("operator", found="!Interactive", expected="a viewer: run with --meshcat")
        sliders = InteractiveOperator(
            meshcat, period=period, bandwidth=self.bandwidth, greatest_speed=self.greatest_speed
        )
        return Person(sliders)


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


def laid(shape: Shape, position: Array) -> Array:
    """(n, 3) positions over a level surface [m] laid over another.

    Raises:
        BadInput: one of them is beyond the surface.
    """
    on, packed = shape.points(position[:, :2]), shape.packed()
    if len(on) < len(position):
        beyond = f"{len(position) - len(on)} of {len(position)} samples beyond it"
        raise BadInput("operator", at="motion", found=beyond, expected="a motion over the surface of the object")
    normals = np.array([locate(packed, tuple(point), (0.0, 0.0, 0.0))[1] for point in on.tolist()])
    return np.asarray(on + position[:, 2:] * normals)


def repeating(motion: SampledMotion) -> Person:
    """A hand that repeats a motion."""
    x, y = 0.5 * (motion.position[:, :2].min(axis=0) + motion.position[:, :2].max(axis=0))
    return Person(ScriptedOperator(motion), motion.duration, (float(x), float(y)), motion)
