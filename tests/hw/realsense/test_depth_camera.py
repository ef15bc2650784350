"""The camera block shows the newest cloud, says how old it is, and lets go of a surface that nobody sees any more."""

import math
import os
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem
from realsense_samples import UNIT, plane_depth, told

from mmt_drake.beside import Later, WorkProcess
from mmt_drake.errors import BadInput
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.camera import DepthCameraSystem
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.depth import DepthToCloud, Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.faults import BLIND, FAILED, FROZEN, NO_FRAME, STALE, WELL
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.rendered import RenderedScene
from mmt_drake.hw.realsense.simulated import SimulatedDepthCameraSystem, SimulatedFrames, simulated_camera
from mmt_drake.hw.realsense.stream import DepthFrame
from mmt_drake.hw.realsense.view import Solid, TableScene
from mmt_drake.hw.realsense.worker import CloudWorker


class Fed:
    """A source of frames that the test hands in one by one."""

    def __init__(self) -> None:
        self._new = threading.Condition()
        self._frame: DepthFrame | None = None
        self.broken = False

    def __call__(self, timeout: float) -> DepthFrame | None:
        with self._new:
            if self._frame is None and not self.broken:
                self._new.wait(timeout)
            if self.broken:
                raise DeviceError("realsense: unplugged")
            frame, self._frame = self._frame, None
            return frame

    def show(self, frame: DepthFrame) -> None:
        with self._new:
            self._frame = frame
            self._new.notify()

    def unplug(self, out: bool = True) -> None:
        with self._new:
            self.broken = out
            self._new.notify()


def until(true: Callable[[], object]) -> None:
    ends = time.monotonic() + 20.0
    while not true():
        assert time.monotonic() < ends, "waited 20 s"
        time.sleep(0.002)


@pytest.fixture
def convert(small_camera: Intrinsics, tilted: Extrinsics) -> DepthToCloud:
    return DepthToCloud(small_camera, tilted)


def test_what_a_frame_tells_of_colour_is_in_its_cloud_and_in_no_other(
    convert: DepthToCloud, small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    source, depth = Fed(), told(plane_depth(small_camera, tilted))
    shape = small_camera.height, small_camera.width, 3
    red = ColourImage(np.full(shape, [255, 0, 0], np.uint8), small_camera)
    with CloudWorker(source, convert) as worker:
        source.show(DepthFrame(depth, UNIT, 1, 1.0, 0.0, red))
        until(lambda: worker.frames == 1)
        first = worker.latest
        source.show(DepthFrame(depth + 1, UNIT, 2, 1.1, 0.0))
        until(lambda: worker.frames == 2)
        second = worker.latest
    assert first is not None and second is not None and second.cloud.colours is None
    np.testing.assert_array_equal(first.cloud.colours, np.tile([1.0, 0.0, 0.0], (len(first.cloud), 1)))


def test_no_frame_then_a_surface_then_none_again_when_frames_stop(
    convert: DepthToCloud, small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    source, now = Fed(), [100.0]
    depth = told(plane_depth(small_camera, tilted))
    depth[:12] = 0
    with CloudWorker(source, convert) as worker:
        camera = DepthCameraSystem(worker, period=0.01, stale=0.25, clock=lambda: now[0])
        simulator = Simulator(camera)
        show = camera.GetOutputPort("camera"), camera.GetOutputPort("point_cloud")

        def at(t: float) -> tuple[np.ndarray, Any]:
            simulator.AdvanceTo(t)
            return show[0].Eval(simulator.get_context()), show[1].Eval(simulator.get_context())

        said, cloud = at(0.05)
        assert (said[0], len(cloud)) == (NO_FRAME, 0)
        source.show(DepthFrame(depth, UNIT, 7, 5.0, arrival=99.96))
        until(lambda: worker.latest)
        said, cloud = at(0.1)
        assert said[0] == WELL
        assert said[1:] == pytest.approx([0.04, 0.1])
        assert len(cloud) > 1000
        assert cloud.stamp == pytest.approx(0.09 - 0.04)
        now[0] += 0.2
        assert len(at(0.12)[1]) > 1000
        now[0] += 0.02
        said, cloud = at(0.14)
        assert (said[0], len(cloud)) == (STALE, 0)
        source.show(DepthFrame(depth + 1, UNIT, 8, 5.3, arrival=now[0]))
        until(lambda: worker.latest.number == 8)
        assert at(0.16)[0][0] == WELL
        source.unplug()
        until(lambda: worker.failure)
        said, cloud = at(0.18)
        assert (said[0], len(cloud)) == (FAILED, 0)
        assert worker.failure == "realsense: unplugged"


def test_whatever_ends_a_worker_is_a_failure_of_the_camera(convert: DepthToCloud) -> None:
    def spoilt(timeout: float) -> DepthFrame:
        return DepthFrame(np.zeros((1, 1), np.uint16), "no number", 0, 0.0, 0.0)  # type: ignore[arg-type]

    def refuse(*_: object) -> None:
        raise ValueError("not a number")

    with CloudWorker(spoilt, refuse) as worker:  # type: ignore[arg-type]
        until(lambda: worker.failure)
        simulator = Simulator(camera := DepthCameraSystem(worker))
        simulator.AdvanceTo(0.01)
        assert camera.GetOutputPort("camera").Eval(simulator.get_context())[0] == FAILED
        assert worker.failure == "not a number"


def test_a_worker_that_is_busy_skips_to_the_newest_frame_and_never_holds_up_the_reader(
    convert: DepthToCloud, small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    depth = told(plane_depth(small_camera, tilted))
    source, gate, taken = Fed(), threading.Event(), []

    def slow(image: np.ndarray, unit: float, stamp: float, before: None, colour: None) -> Any:
        taken.append(int(stamp))
        gate.wait(20.0)
        return convert(image, unit, stamp)

    with CloudWorker(source, slow) as worker:  # type: ignore[arg-type]
        source.show(DepthFrame(depth, UNIT, 1, 1.0, 0.0))
        until(lambda: taken)
        for number in range(2, 6):
            source.show(DepthFrame(depth + number, UNIT, number, float(number), 0.0))
        camera = DepthCameraSystem(worker)
        simulator = Simulator(camera)
        simulator.AdvanceTo(0.1)  # returns although the worker hangs
        assert camera.GetOutputPort("camera").Eval(simulator.get_context())[0] == NO_FRAME
        gate.set()
        until(lambda: worker.latest and worker.latest.number == 5)
    assert taken == [1, 5]


def frame(depth: np.ndarray, number: int, **changed: Any) -> DepthFrame:
    return DepthFrame(depth, UNIT, number, number / 30.0, float(number))._replace(**changed)


TELL_NOTHING: dict[str, tuple[Callable[[np.ndarray], DepthFrame], float]] = {
    "no depth": (lambda depth: frame(np.zeros_like(depth), 3), BLIND),
    "unit not a number": (lambda depth: frame(depth + 1, 3, unit=math.nan), BLIND),
    "surface out of the box": (lambda depth: frame(depth // 2, 3), BLIND),
    "the same frame": (lambda depth: frame(depth, 2), FROZEN),
    "the same image": (lambda depth: frame(depth, 3), FROZEN),
    "late": (lambda depth: frame(depth + 1, 1), STALE),
}


@pytest.mark.parametrize("name", TELL_NOTHING)
def test_a_frame_that_tells_nothing_new_leaves_the_last_surface_until_that_is_stale(
    name: str, convert: DepthToCloud, small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    make, told_as = TELL_NOTHING[name]
    depth, source, now = told(plane_depth(small_camera, tilted)), Fed(), [2.0]
    with CloudWorker(source, convert) as worker:
        camera = DepthCameraSystem(worker, period=0.01, stale=0.25, clock=lambda: now[0])
        simulator = Simulator(camera)

        def at(t: float) -> tuple[float, int]:
            simulator.AdvanceTo(t)
            context = simulator.get_context()
            cloud = camera.GetOutputPort("point_cloud").Eval(context)
            return float(camera.GetOutputPort("camera").Eval(context)[0]), len(cloud)

        for shown, given in enumerate((frame(depth, 2), make(depth)), 1):
            source.show(given)
            until(lambda shown=shown: worker.frames == shown)
        assert worker.passed_over == told_as and worker.latest is not None and worker.latest.number == 2
        now[0] += 0.2
        assert at(0.015)[0] == WELL and at(0.015)[1] > 1000
        now[0] += 0.1
        assert at(0.025) == (told_as, 0)
        source.show(frame(depth + 2, 4, arrival=now[0]))
        until(lambda: worker.frames == 3)
        assert at(0.035)[0] == WELL


def test_after_an_error_frames_are_asked_for_again(
    convert: DepthToCloud, small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    source = Fed()
    with CloudWorker(source, convert) as worker:
        source.unplug()
        until(lambda: worker.failure)
        source.unplug(False)
        source.show(frame(told(plane_depth(small_camera, tilted)), 1))
        until(lambda: worker.latest)
        until(lambda: worker.failure is None)


def test_a_rendered_scene_is_where_it_is_said_to_be_and_moves_with_the_body(
    tilted: Extrinsics, convert: DepthToCloud
) -> None:
    diagram = simulated_camera(tilted, convert, rate=30.0, latency=0.02)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    body = diagram.GetInputPort("body").FixValue(context, np.zeros(4))
    out = diagram.GetOutputPort("point_cloud"), diagram.GetOutputPort("camera")
    simulator.AdvanceTo(0.019)
    assert (len(out[0].Eval(context)), out[1].Eval(context)[0]) == (0, NO_FRAME)
    simulator.AdvanceTo(0.025)
    first = out[0].Eval(context)
    assert np.abs(first.points()[:, 2]).max() < 5e-5
    assert first.points()[:, :2].min(axis=0) == pytest.approx([-0.1, -0.1], abs=0.006)
    assert first.points()[:, :2].max(axis=0) == pytest.approx([0.1, 0.1], abs=0.006)
    assert first.stamp == 0.0
    body.GetMutableData().set_value([0.03, -0.02, 0.0, 0.0])
    simulator.AdvanceTo(0.06)
    moved = out[0].Eval(context)
    assert moved.points()[:, :2].max(axis=0) == pytest.approx([0.13, 0.08], abs=0.006)
    assert moved.stamp == pytest.approx(1.0 / 30.0)
    np.testing.assert_allclose(out[1].Eval(context)[:2], [WELL, 0.02])


def test_two_runs_and_a_cloned_context_see_the_same_noise(tilted: Extrinsics, convert: DepthToCloud) -> None:
    diagram = simulated_camera(tilted, convert, noise=DepthNoise.stereo(150.0), rate=30.0)

    def seen(context: Any, until_: float) -> bytes:
        simulator = Simulator(diagram, context)
        simulator.AdvanceTo(until_)
        return diagram.GetOutputPort("point_cloud").Eval(context).points().tobytes()

    contexts = [diagram.CreateDefaultContext() for _ in range(2)]
    for context in contexts:
        diagram.GetInputPort("body").FixValue(context, np.zeros(4))
    early = [seen(context, 0.05) for context in contexts]
    clone = contexts[0].Clone()
    late = [seen(context, 0.12) for context in (*contexts, clone)]
    assert early[0] == early[1]
    assert late[0] == late[1] == late[2] != early[0]


def test_a_simulated_camera_too_says_when_its_frames_show_no_surface(convert: DepthToCloud) -> None:
    camera = SimulatedDepthCameraSystem(convert)
    context = camera.CreateDefaultContext()
    nothing = DepthFrame(np.zeros((120, 160), np.uint16), UNIT, 1, 0.0, 0.0)
    camera.get_input_port().FixValue(context, AbstractValue.Make(nothing))
    Simulator(camera, context).AdvanceTo(0.1)
    assert camera.GetOutputPort("camera").Eval(context)[0] == BLIND


def test_direct_feedthrough_is_declared(small_camera: Intrinsics, tilted: Extrinsics, convert: DepthToCloud) -> None:
    frames = SimulatedFrames(RenderedScene(small_camera, tilted))
    systems: dict[LeafSystem, bool] = {frames: True, SimulatedDepthCameraSystem(convert): False}
    for system, through in systems.items():
        assert system.HasAnyDirectFeedthrough() == through


def test_a_rendered_scene_shows_a_body_where_it_is_and_is_the_same_in_another_process(
    small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    scene = RenderedScene(small_camera, tilted)
    there, lifted = scene.depth(), scene.depth((0.0, 0.0, 0.05))
    v, u = small_camera.height // 2, small_camera.width // 2
    along = tilted.rotation()[2, 2] + tilted.rotation()[2, 1] * small_camera.rays()[v, u, 1]
    assert there[v, u] - lifted[v, u] == pytest.approx(-0.05 / along, abs=2e-4)
    with WorkProcess(RenderedScene.depth, scene.depth, in_real_time=True) as other:
        np.testing.assert_array_equal(other.later(scene, (0.0, 0.0, 0.05)).value, lifted)
        assert os.SCHED_OTHER not in _policies(other.process.pid)


def _policies(pid: int) -> set[int]:
    """Of all threads of a process."""
    return {os.sched_getscheduler(int(thread)) for thread in os.listdir(f"/proc/{pid}/task")}


def test_a_scene_is_seen_from_any_thread(small_camera: Intrinsics, tilted: Extrinsics) -> None:
    scene, seen = RenderedScene(small_camera, tilted), []
    there = scene.depth()
    thread = threading.Thread(target=lambda: seen.append(scene.depth((0.01, 0.0, 0.0))))
    thread.start()
    thread.join()
    assert np.isfinite(seen[0]).mean() == pytest.approx(np.isfinite(there).mean(), abs=0.01)
    np.testing.assert_array_equal(seen[0], scene.depth((0.01, 0.0, 0.0)))


def test_frames_of_several_bodies_have_each_where_it_is_and_the_probe(
    small_camera: Intrinsics, tilted: Extrinsics
) -> None:
    solids = tuple(Solid((0.04, 0.04, 0.05), (x, 0.0)) for x in (-0.05, 0.05))
    frames = SimulatedFrames(RenderedScene(small_camera, tilted, TableScene(solids, -0.05, probe=0.005)))
    context = frames.CreateDefaultContext()
    frames.GetInputPort("bodies").FixValue(context, np.array([0.01, 0.02, 9.0, 9.0, 0.03, 0.0, 0.0, 0.0, 0.0, 0.0]))
    frames.GetInputPort("probe").FixValue(context, np.array([0.1, 0.2, 0.3]))
    frame = frames.GetOutputPort("frame").Eval(context)
    assert np.array(frame.at) == pytest.approx(np.array([[-0.04, 0.02, 0.03], [0.05, 0.0, 0.0], [0.1, 0.2, 0.3]]))
    with pytest.raises(BadInput, match="a probe beside several solids"):
        RenderedScene(small_camera, tilted, TableScene(solids, -0.05))


def test_a_cloud_that_does_not_come_is_told_with_its_age_and_let_go(
    small_camera: Intrinsics, tilted: Extrinsics, convert: DepthToCloud
) -> None:
    answers = [Later.known(convert(told(plane_depth(small_camera, tilted)), UNIT))]
    never = Later(lambda: pytest.fail("nobody waits"), lambda: False)
    camera = SimulatedDepthCameraSystem(
        convert, latency=0.02, waits=False, apart=lambda *_: lambda *_: answers.pop() if answers else never
    )
    context = camera.CreateDefaultContext()
    camera.get_input_port().FixValue(context, AbstractValue.Make(frame(told(plane_depth(small_camera, tilted)), 1)))
    simulator, out = Simulator(camera, context), [camera.GetOutputPort(name) for name in ("camera", "point_cloud")]
    for until_, fault, age in ((0.03, WELL, 0.02), (0.13, WELL, 0.12), (0.5, STALE, 0.02 + 14 / 30)):
        simulator.AdvanceTo(until_)
        assert out[0].Eval(context)[:2] == pytest.approx([fault, age], abs=1e-6)
        assert (len(out[1].Eval(context)) > 0) == (fault == WELL)


def test_pixels_that_are_not_square_are_refused(tilted: Extrinsics) -> None:
    with pytest.raises(BadInput, match="square pixels"):
        RenderedScene(Intrinsics(160, 120, 150.0, 140.0, 79.5, 59.5), tilted)
