"""Frames of librealsense - a software device, a recording - arrive whole, newest first or every one."""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mmt_drake.errors import BadInput, MissingDependency
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.emulator import software_camera
from mmt_drake.hw.realsense.sdk import load_sdk
from mmt_drake.hw.realsense.stream import (
    DepthFrame,
    DepthStream,
    RecordedStream,
    open_camera,
    open_sensor,
    recorded_frames,
)


def test_without_the_library_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(MissingDependency, match=r"pip install 'mmt_drake\[realsense\]'") as said:
        load_sdk()
    assert "\n" not in str(said.value)


def test_a_software_device_is_a_camera(software: Any, small_camera: Intrinsics) -> None:
    with open_sensor(software.sensor, software.device) as stream:
        assert stream.intrinsics == small_camera
        assert stream.read(0.02) is None
        image = np.arange(120 * 160, dtype=np.uint16).reshape(120, 160)
        software.show(image)
        frame = stream.read(1.0)
        assert frame is not None
        np.testing.assert_array_equal(frame.depth, image)
        assert frame.unit == pytest.approx(software.unit, rel=1e-6)
        assert (frame.number, frame.device_time) == (1, 1.0)
        assert abs(frame.arrival - time.monotonic()) < 5.0
    with pytest.raises(DeviceError, match="closed"):
        stream.read()


def test_colours_come_beside_depth_from_where_their_sensor_stands(realsense: Any, small_camera: Intrinsics) -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    pixels = np.random.default_rng(0).integers(0, 256, (3, 4, 3)).astype(np.uint8)
    beside = ColourImage(pixels, Intrinsics(4, 3, 100.0, 100.0, 1.5, 1.0), turn, np.array([0.015, 0.0, 1e-3]))
    camera = software_camera(small_camera, beside)
    with open_sensor(camera.sensor, camera.device, colour=True) as stream:
        camera.show(np.ones((120, 160), np.uint16))
        first = stream.read(1.0)
        camera.show_colour(pixels)
        camera.show(np.full((120, 160), 2, np.uint16))
        second = stream.read(1.0)
    assert first is not None and first.colour is None
    assert second is not None and second.colour is not None
    np.testing.assert_array_equal(second.colour.pixels, pixels)
    np.testing.assert_allclose(second.colour.rotation, turn)
    np.testing.assert_allclose(second.colour.translation, [0.015, 0.0, 1e-3])
    assert second.colour.intrinsics == beside.intrinsics


def test_a_camera_without_colour_says_so_where_it_is_asked_for(software: Any) -> None:
    with pytest.raises(DeviceError, match="no colour sensor"):
        open_sensor(software.sensor, software.device, colour=True)


def test_a_colour_sensor_that_does_not_start_ends_the_depth_too(realsense: Any, small_camera: Intrinsics) -> None:
    camera = software_camera(small_camera, ColourImage(np.zeros((3, 4, 3), np.uint8), Intrinsics(4, 3, 9, 9, 1, 1)))

    class Taken:
        def open(self, profile: object) -> None:
            raise RuntimeError("busy")

    assert camera.colour is not None
    with pytest.raises(DeviceError, match="colour stream does not start: busy"):
        DepthStream(camera.sensor, camera.profile, camera.device, colour=(Taken(), camera.colour[1]))
    with open_sensor(camera.sensor, camera.device):  # it can be opened: it was closed
        pass


def test_a_sensor_that_does_not_start_is_closed(software: Any) -> None:
    class Busy:
        def __init__(self) -> None:
            self.calls: list[str] = []

        def open(self, profile: object) -> None:
            self.calls.append("open")

        def start(self, frames: object) -> None:
            raise RuntimeError("busy")

        def close(self) -> None:
            self.calls.append("close")

    sensor = Busy()
    with pytest.raises(DeviceError, match="does not start: busy"):
        DepthStream(sensor, software.profile)
    assert sensor.calls == ["open", "close"]


def test_of_several_frames_the_newest_is_read(software: Any) -> None:
    with open_sensor(software.sensor, software.device) as stream:
        for k in range(1, 6):
            software.show(np.full((120, 160), k, np.uint16))
        time.sleep(0.2)
        frame = stream.read(1.0)
        assert frame is not None
        assert (frame.number, frame.depth[0, 0]) == (5, 5)
        assert stream.read(0.02) is None


@pytest.mark.parametrize("slow", [0.0, 0.02])
def test_every_frame_of_a_recording_is_read_however_slowly(
    recorded: Path, slow: float, small_camera: Intrinsics
) -> None:
    intrinsics, frames = recorded_frames(recorded)
    assert intrinsics == small_camera
    seen = []
    for frame in frames:
        time.sleep(slow)
        seen.append((frame.number, int(frame.depth[60, 80]), round(frame.device_time * 30.0)))
    assert seen == [(k + 1, 1000 + k, 30 + k) for k in range(12)]


def test_a_recording_may_be_left_in_the_middle(recorded: Path) -> None:
    _, frames = recorded_frames(recorded)
    assert next(frames).number == 1
    started = time.monotonic()
    frames.close()  # type: ignore[attr-defined]
    assert time.monotonic() - started < 2.0


def test_a_recording_plays_at_its_own_pace_over_and_over(recorded: Path, small_camera: Intrinsics) -> None:
    with RecordedStream(recorded) as stream:
        assert stream.intrinsics == small_camera
        frames = list[DepthFrame]()
        ends = time.monotonic() + 60.0
        while len(frames) < 14 and time.monotonic() < ends:
            frame = stream.read(0.05)
            frames += [] if frame is None else [frame]
    assert [frame.number for frame in frames] == [*range(1, 13), 1, 2]
    assert [frame.depth[0, 0] for frame in frames[:12]] == list(range(1000, 1012))
    assert frames[11].arrival - frames[0].arrival > 0.99 * 11 / 30.0


def test_the_next_frame_is_waited_for_as_long_as_told_and_no_longer(recorded: Path) -> None:
    with RecordedStream(recorded) as stream:
        assert stream.read(1.0) is not None
        assert stream.read(0.0) is None
        frame = stream.read(1.0)
        assert frame is not None and frame.number == 2


@pytest.mark.parametrize("opening", [RecordedStream, recorded_frames])
def test_what_is_no_recording_is_refused_in_one_line(realsense: Any, opening: Callable, tmp_path: Path) -> None:
    broken = tmp_path / "broken.db3"
    broken.write_bytes(b"nothing of the kind")
    for path, found in ((tmp_path / "none.db3", "no such file"), (broken, "broken.db3")):
        with pytest.raises(BadInput, match=found) as said:
            opening(path)
        assert "\n" not in str(said.value)


def test_without_a_camera_one_line_says_so(realsense: Any) -> None:
    if len(realsense.context().query_devices()):
        pytest.skip("there is a camera")
    with pytest.raises(DeviceError, match="no camera found"):
        open_camera()
