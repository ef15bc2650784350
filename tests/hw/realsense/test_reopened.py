"""A camera that went is opened anew; what stands in the way is told each time."""

import pytest

from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.reopened import ReopenedStream
from mmt_drake.hw.realsense.stream import DepthFrame


class Fake:
    """A stream that gives, or raises, what it is told to."""

    def __init__(self, intrinsics: Intrinsics) -> None:
        self.intrinsics, self.error, self.closed = intrinsics, "", 0

    def read(self, timeout: float = 0.1) -> DepthFrame | None:
        if self.error:
            raise RuntimeError(self.error)
        return None

    def close(self) -> None:
        self.closed += 1
        if self.error:
            raise RuntimeError("not there any more")


class Cameras:
    """Opens one stream after the other; `gone` while there is none."""

    def __init__(self, intrinsics: Intrinsics) -> None:
        self.intrinsics, self.opened, self.gone = intrinsics, list[Fake](), False

    def __call__(self) -> Fake:
        if self.gone:
            raise DeviceError("realsense: no camera found")
        self.opened.append(Fake(self.intrinsics))
        return self.opened[-1]


@pytest.fixture
def cameras(small_camera: Intrinsics) -> Cameras:
    return Cameras(small_camera)


def test_after_an_error_it_is_closed_and_opened_again(cameras: Cameras) -> None:
    with ReopenedStream(cameras) as stream:
        cameras.opened[0].error = "device disconnected"
        with pytest.raises(RuntimeError, match="disconnected"):
            stream.read()
        cameras.gone = True
        for _ in range(2):
            with pytest.raises(DeviceError, match="no camera found"):
                stream.read()
        cameras.gone = False
        assert stream.read() is None
    assert [fake.closed for fake in cameras.opened] == [1, 1]


def test_after_a_long_silence_too(cameras: Cameras) -> None:
    now = [100.0]
    with ReopenedStream(cameras, lambda: now[0]) as stream:
        now[0] += 1.9
        assert stream.read() is None
        now[0] += 0.2
        with pytest.raises(DeviceError, match="no depth frame within 2 s"):
            stream.read()
        assert stream.read() is None and len(cameras.opened) == 2


def test_another_camera_is_refused(cameras: Cameras) -> None:
    """Its pixels would be taken for those of the first."""
    with ReopenedStream(cameras) as stream:
        cameras.opened[0].error = "device disconnected"
        with pytest.raises(RuntimeError):
            stream.read()
        cameras.intrinsics = Intrinsics(640, 480, 610.0, 610.0, 319.5, 239.5)
        with pytest.raises(DeviceError, match="another camera"):
            stream.read()
    assert cameras.opened[1].closed == 1


def test_a_camera_that_is_not_there_at_first_is_an_error(cameras: Cameras) -> None:
    cameras.gone = True
    with pytest.raises(DeviceError, match="no camera found"):
        ReopenedStream(cameras)
