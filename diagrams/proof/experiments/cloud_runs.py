"""Contact detection on a measured cloud: the experiment the thesis planned and did not make, in simulation."""

import math
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Demultiplexer, LogVectorOutput

from mmt_drake.analysis.signals import stretches
from mmt_drake.cloud import ProxySettings
from mmt_drake.diagrams.proof.studies.study import Progress, unheard
from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import DepthToCloud, TemporalFilter
from mmt_drake.hw.realsense.extrinsics import Calibration, calibrate_on_table
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.rendered import RenderedScene
from mmt_drake.hw.realsense.settings import CloudSettings
from mmt_drake.hw.realsense.simulated import SimulatedDepthCameraSystem, SimulatedFrames
from mmt_drake.hw.realsense.untouched import Untouched, untouched
from mmt_drake.hw.realsense.view import BOX, View
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.motion.analytic import AnalyticMotion, Row, step
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.scripted_operator import ScriptedOperator

_CLEARANCE = 0.004  # of a hovering tip above the surface [m]
_HOVER, _MOVE, _DWELL = 0.3, 0.4, 0.5  # [s]
_LATENCY = 0.03  # [s] from the moment a frame shows to its cloud
_REACH = 0.05  # greatest |x|, |y| of a touch [m]


@dataclass(frozen=True)
class CloudPlan:
    """One experiment.

    Attributes:
        touches: how often the hand comes down.
        noise: camera noise, in parts of what a stereo camera has at that distance, one detector each;
        voxel: by edges of the voxel filter [m].
        alpha: and by temporal filters (`TemporalFilter`); 1: each frame stands alone.
        view: the camera, and where it stands.
        rate: frames per second [Hz].
        seed: of hand and camera.

    Raises:
        BadInput: no touches, or nothing to compare.
    """

    touches: int = 16
    noise: tuple[float, ...] = (0.0, 0.5, 1.0, 2.0)
    voxel: tuple[float, ...] = (0.002, 0.003, 0.005)
    alpha: tuple[float, ...] = (1.0, 0.2)
    view: View = field(default_factory=View)
    rate: float = 30.0
    seed: int = 0

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

        def along_the_table(seconds: float, by: Array) -> None:
            steps.extend(step(axis, now, now + seconds, float(by[axis])) for axis in (0, 1))

        for _ in range(self.touches):
            there = random.uniform(-_REACH, _REACH, 2)
            depth = random.uniform(0.002, 0.006)
            speed = 10.0 ** random.uniform(-2.0, math.log10(0.2))
            takes = 1.875 * (_CLEARANCE + depth) / speed  # 1.875: of a minimum-jerk step, greatest to mean speed
            along_the_table(_MOVE, there - here)
            now += _MOVE + _HOVER
            steps.append(step(2, now, now + takes, -_CLEARANCE - depth))
            now += takes
            slide = random.uniform(-0.02, 0.02, 2)
            along_the_table(_DWELL, slide)
            here = there + slide
            now += _DWELL + 0.1
            steps.append(step(2, now, now + takes, _CLEARANCE + depth))
            now += takes
        along_the_table(_MOVE, -here)
        return AnalyticMotion((0.0, 0.0, _CLEARANCE), steps=steps, cycle=now + _MOVE + _HOVER)


_MERGED = 0.0045  # [s] from the last sample of a detection to the first of the next that still is the same
_BETWEEN = 0.05  # [s] how far from a touch a detection may lie that is its early or late part


@dataclass(frozen=True)
class Score:
    """Detections held against contacts.

    Attributes:
        contacts: of the plant.
        missed: contacts without any detection.
        false: detections further than 50 ms from every contact.
        breaks: further beginnings of a detection within or around one contact: it flickers.
        wrong: share of all samples at which the two differ (0 to 1).
        touch_lags: from each contact seen to its first detection [s]; negative is early.
        release_lags: from each end of a contact seen to the end of its last detection [s].
        touch_heights: of the tip at the first detection [m]; above 0 is early.
    """

    contacts: int
    missed: int
    false: int
    breaks: int
    wrong: float
    touch_lags: Array
    release_lags: Array
    touch_heights: Array

    @property
    def slips(self) -> int:
        """How often an operator would have felt a contact that is none, or lost one: missed, false and broken ones."""
        return self.missed + self.false + self.breaks


def score(time: Array, height: Array, contact: Flags, detected: Flags) -> Score:
    """Compare two flags.

    Args:
        time: (n) [s], evenly spaced.
        height: (n) of the tip above the undeformed surface [m].
        contact: (n) the plant's contact.
        detected: (n) the detector's.
    """
    true, seen = stretches(contact), _merged(stretches(detected), time)
    owner = [_nearest(begin, end, true, time) for begin, end in seen]
    touches, releases, heights = [], [], []
    missed = breaks = 0
    for number, (begin, end) in enumerate(true):
        own = [stretch for stretch, of in zip(seen, owner, strict=True) if of == number]
        if not any(first <= end and last >= begin for first, last in own):
            missed += 1
            continue
        breaks += len(own) - 1
        first, last = own[0][0], own[-1][1]
        touches.append(time[first] - time[begin])
        heights.append(height[first])
        if end < len(time) - 1 and last < len(time) - 1:
            releases.append(time[last] - time[end])
    return Score(
        contacts=len(true),
        missed=missed,
        false=sum(of is None for of in owner),
        breaks=breaks,
        wrong=float(np.mean(contact != detected)),
        touch_lags=np.array(touches),
        release_lags=np.array(releases),
        touch_heights=np.array(heights),
    )


def _merged(found: list[tuple[int, int]], time: Array) -> list[tuple[int, int]]:
    merged: list[tuple[int, int]] = []
    for begin, end in found:
        if merged and time[begin] - time[merged[-1][1]] <= _MERGED:
            merged[-1] = merged[-1][0], end
        else:
            merged.append((begin, end))
    return merged


def _nearest(begin: int, end: int, contacts: list[tuple[int, int]], time: Array) -> int | None:
    """The contact that a detection belongs to; None if all are further away than `_BETWEEN`."""
    if not contacts:
        return None
    gaps = [max(time[a] - time[end], time[begin] - time[b], 0.0) for a, b in contacts]
    best = int(np.argmin(gaps))
    return best if gaps[best] <= _BETWEEN else None


_STEP = 1e-3
_R2 = ProxySettings().r2
_CALIBRATION_FRAMES, _FIRST_CALIBRATION_FRAME = 8, 1_000_000  # frames that no run reaches
_CHECKED_EVERY = 0.5  # [s] between two calls of `progress`


@dataclass(frozen=True)
class CameraCase:
    """One camera and its detector.

    Attributes:
        noise: in parts of a stereo camera's.
        voxel: edge of the voxel filter [m].
        alpha: of the temporal filter; 1: none.
        untouched: what the camera shows of the object before the first touch; its offset is the detector's.
        score: what the detector did.
    """

    noise: float
    voxel: float
    alpha: float
    untouched: Untouched
    score: Score


@dataclass(frozen=True)
class Result:
    """What came of a plan: one case for each temporal filter, noise and voxel, in the plan's order."""

    plan: CloudPlan
    seconds: float
    cases: tuple[CameraCase, ...]


def cases_of(result: Result, **of: float) -> list[CameraCase]:
    """The cases with this noise, voxel or alpha, in the plan's order."""
    return [case for case in result.cases if all(getattr(case, name) == value for name, value in of.items())]


def run_cloud(plan: CloudPlan, progress: Progress = unheard) -> Result:
    """Carry out a plan.

    Every camera is first calibrated on the bare table through its own noise, and its detector is given the offset that
    was measured on a few frames of the untouched object. The plant is in contact where the tip is below the undeformed
    top.

    Args:
        plan: what to do.
        progress: called now and then with the simulated time [s].

    Raises:
        BadInput: a camera that does not see the object.
    """
    intrinsics, where = plan.view.intrinsics(), plan.view.extrinsics()
    seen = RenderedScene(intrinsics, where)
    depth, table = seen.depth(), replace(seen, scene=replace(BOX, solids=())).depth()
    motion = plan.motion()

    builder = DiagramBuilder()
    hand = builder.AddSystem(ScriptedOperator(motion))
    box = builder.AddSystem(FlexibleBox(FlexibleBoxModel()))
    builder.Connect(hand.GetOutputPort("motion"), box.GetInputPort("motion"))
    truth = LogVectorOutput(box.GetOutputPort("in_contact"), builder, _STEP)
    halves = builder.AddSystem(Demultiplexer([3, 3]))
    builder.Connect(hand.GetOutputPort("motion"), halves.get_input_port())
    tip = halves.get_output_port(0)
    position = LogVectorOutput(tip, builder, _STEP)

    prepared = []
    for number, amount in enumerate(plan.noise):
        noise = replace(DepthNoise.stereo(intrinsics.fx).scaled(amount), seed=1000 * plan.seed + number)
        calibration = calibrate(plan, table, noise)
        frames = builder.AddSystem(SimulatedFrames(seen, noise, rate=plan.rate))
        builder.Connect(box.GetOutputPort("body"), frames.GetInputPort("body"))
        for alpha, voxel in product(plan.alpha, plan.voxel):
            smooth = None if alpha == 1.0 else TemporalFilter(alpha)
            convert = DepthToCloud(intrinsics, calibration.extrinsics, CloudSettings(voxel=voxel), smooth)
            shown = untouched(convert, noise, depth, BOX.solids[0], _R2)
            camera = builder.AddSystem(SimulatedDepthCameraSystem(convert, rate=plan.rate, latency=_LATENCY))
            detector = builder.AddSystem(ContactDetector(ProxySettings(r2=_R2, surface_offset=shown.offset)))
            builder.Connect(frames.GetOutputPort("frame"), camera.GetInputPort("frame"))
            builder.Connect(camera.GetOutputPort("point_cloud"), detector.GetInputPort("point_cloud"))
            builder.Connect(tip, detector.GetInputPort("position"))
            detected = LogVectorOutput(detector.GetOutputPort("in_contact"), builder, _STEP)
            prepared.append((partial(CameraCase, amount, voxel, alpha, shown), detected))

    simulator = Simulator(builder.Build())
    due = 0.0

    def watch(_: object) -> None:
        nonlocal due
        now = simulator.get_context().get_time()
        if now >= due:
            due = now + _CHECKED_EVERY
            progress(now)

    simulator.set_monitor(watch)
    simulator.AdvanceTo(motion.cycle)
    context = simulator.get_context()
    time, contact = truth.FindLog(context).sample_times(), truth.FindLog(context).data()[0] > 0.5
    height = position.FindLog(context).data()[2]
    cases = [
        case(score(time, height, contact, detected.FindLog(context).data()[0] > 0.5)) for case, detected in prepared
    ]
    cases.sort(key=lambda case: plan.alpha.index(case.alpha))  # stable: noise and voxel stay in order
    return Result(plan, motion.cycle, tuple(cases))


def calibrate(plan: CloudPlan, table: NDArray[np.float32], noise: DepthNoise) -> Calibration:
    """The camera's pose, found from a few noisy frames of the bare table.

    Args:
        plan: whose camera and object.
        table: (height, width) depth of the bare table [m].
        noise: of the camera.
    """
    intrinsics, where = plan.view.intrinsics(), plan.view.extrinsics()
    frames = range(_CALIBRATION_FRAMES)
    points = [
        intrinsics.points(noise.apply(table, intrinsics, _FIRST_CALIBRATION_FRAME + k), noise.unit) for k in frames
    ]
    x, y, _ = where.position
    tolerance = max(0.005, 4.0 * noise.axial_z2)
    return calibrate_on_table(np.concatenate(points)[::7], object_height=-BOX.low, foot=(x, y), tolerance=tolerance)
