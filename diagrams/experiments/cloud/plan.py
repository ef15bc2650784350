"""What the hand does, where the camera stands, and which clouds are compared."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.temporal import TemporalFilter
from mmt_drake.hw.realsense.view import TableScene, View
from mmt_drake.motion.analytic import AnalyticMotion, Row, step

_CLEARANCE = 0.004  # of a hovering tip above the surface [m]
_HOVER, _DWELL = 0.3, 0.5  # [s]
_REACH = 0.05  # greatest |x|, |y| of a touch [m]


@dataclass(frozen=True)
class Plan:
    """One experiment.

    Attributes:
        touches: how often the hand comes down.
        noise: camera noise, in parts of what a stereo camera has at that distance, one detector each;
        voxel: by edges of the voxel filter [m].
        alpha: and by temporal filters (`TemporalFilter`); 1: each frame stands alone.
        view: the camera, and where it stands.
        rate: frames per second [Hz].
        latency: from the moment a frame shows to its cloud [s].
        seed: of hand and camera.
        scene: the object.

    Raises:
        BadInput: no touches, or nothing to compare.
    """

    touches: int = 16
    noise: tuple[float, ...] = (0.0, 0.5, 1.0, 2.0)
    voxel: tuple[float, ...] = (0.002, 0.003, 0.005)
    alpha: tuple[float, ...] = (1.0, 0.2)
    view: View = field(default_factory=View)
    rate: float = 30.0
    latency: float = 0.03
    seed: int = 0
    scene: TableScene = field(default_factory=TableScene)

    def __post_init__(self) -> None:
        for alpha in self.alpha:
            TemporalFilter(alpha)  # refuses one without meaning
        if self.touches < 1:
            raise BadInput("cloud experiment", at="touches", found=self.touches, expected="1 or more")
        if not (self.noise and self.voxel and self.alpha):
            raise BadInput("cloud experiment", at="noise, voxel, alpha", found="none", expected="one or more of each")

    def motion(self) -> AnalyticMotion:
        """The hand: it hovers, comes down at 1 to 20 cm/s, presses and slides, lifts, and goes to another place."""
        random = np.random.default_rng(self.seed)
        steps: list[Row] = []
        now, here = _HOVER, np.zeros(2)
        for _ in range(self.touches):
            there = random.uniform(-_REACH, _REACH, 2)
            depth = random.uniform(0.002, 0.006)
            speed = 10.0 ** random.uniform(-2.0, math.log10(0.2))
            takes = 1.875 * (_CLEARANCE + depth) / speed  # 1.875: of a minimum-jerk step, greatest to mean speed
            for axis in (0, 1):
                steps.append(step(axis, now, now + 0.4, float(there[axis] - here[axis])))
            here = there
            now += 0.4 + _HOVER
            steps.append(step(2, now, now + takes, -_CLEARANCE - depth))
            now += takes
            slide = random.uniform(-0.02, 0.02, 2)
            for axis in (0, 1):
                steps.append(step(axis, now, now + _DWELL, float(slide[axis])))
            here = here + slide
            now += _DWELL + 0.1
            steps.append(step(2, now, now + takes, _CLEARANCE + depth))
            now += takes
        for axis in (0, 1):
            steps.append(step(axis, now, now + 0.4, float(-here[axis])))
        return AnalyticMotion((0.0, 0.0, _CLEARANCE), steps=steps, cycle=now + 0.4 + _HOVER)


def plan_of(touches: int | None, seed: int) -> Plan:
    """The plan with this seed, and so many contacts where a number is given."""
    return Plan(seed=seed) if touches is None else Plan(seed=seed, touches=touches)
