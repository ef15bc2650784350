"""`python -m mmt_drake.hw.realsense`: find a camera's pose from the bare table and by touch, look at its cloud."""

import argparse
import math
import sys
from collections import deque
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from mmt_drake.cloud import Cloud, ProxySettings
from mmt_drake.cloud.files import read_cloud, write_cloud
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.by_touch import calibrate_by_touch
from mmt_drake.hw.realsense.depth import DepthToCloud, Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics, calibrate_on_table
from mmt_drake.hw.realsense.settings import CloudSettings
from mmt_drake.hw.realsense.stream import DepthFrame, open_camera, recorded_frames
from mmt_drake.hw.realsense.touches import touches_of
from mmt_drake.hw.realsense.untouched import measured_offset
from mmt_drake.recording import load

_PATIENCE = 5.0  # for one frame of a camera [s]
_TRIED_ON = 100_000  # points of a calibration
_AVERAGED = 8  # frames, for the offset


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; 0, or 2 with one line on standard error."""
    parser = argparse.ArgumentParser(prog="python -m mmt_drake.hw.realsense", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    calibrate = commands.add_parser("calibrate", help="from the bare table to a file with the camera's pose")
    calibrate.add_argument("--object-height", type=float, default=0.0, help="of the object's top above the table [m]")
    calibrate.add_argument("--foot", type=float, nargs=2, default=(0.0, 0.0), help="x, y below the camera [m]")
    calibrate.add_argument("--heading", type=float, default=0.0, help="of the image's x axis on the table [deg]")
    calibrate.add_argument("--out", required=True, help="YAML file to write")
    cloud = commands.add_parser("cloud", help="one frame to a point cloud file")
    cloud.add_argument("--extrinsics", required=True, help="YAML file from `calibrate`")
    cloud.add_argument("--out", required=True, help=".ply, .pcd or .xyz file to write")
    touch = commands.add_parser("touch", help="the whole pose, from touches of what the camera sees")
    touch.add_argument("touches", metavar="REC", help="recording of an arm that touches the object here and there")
    touch.add_argument("--cloud", metavar="FILE", help=".ply, .pcd or .xyz from `cloud`; the first of REC by default")
    touch.add_argument("--extrinsics", required=True, help="YAML file with the pose by which the cloud was made")
    touch.add_argument("--level", type=float, default=0.5, help="force from which on it touches [N] (default: 0.5)")
    touch.add_argument("--tip-radius", type=float, default=0.0, help="of the ball at the tip [m] (default: 0)")
    touch.add_argument("--keep-level", action="store_true", help="height and tilt are known: only heading and foot")
    touch.add_argument("--out", required=True, help="YAML file to write")
    for command in (calibrate, cloud):
        command.add_argument("--recording", help=".db3 file instead of a camera")
        command.add_argument("--serial", help="of the camera; the first one by default")
        command.add_argument("--frames", type=int, default=30, help="how many to use, or to skip (cloud)")
    given = parser.parse_args(arguments)
    try:
        {"calibrate": _calibrate, "cloud": _cloud, "touch": _touch}[given.command](given)
    except MmtError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _calibrate(given: argparse.Namespace) -> None:
    intrinsics, frames = _frames(given)
    points = [intrinsics.points(frame.depth, frame.unit) for frame in frames]
    every = np.concatenate(points or [np.empty((0, 3))])
    found = calibrate_on_table(
        every[:: max(1, len(every) // _TRIED_ON)],
        object_height=given.object_height,
        foot=tuple(given.foot),
        heading=math.radians(given.heading),
    )
    found.extrinsics.write(given.out)
    height = found.extrinsics.position[2]
    print(f"{given.out}: {height:.4f} m above the object's top; {found.share:.0%} of the points on one plane,")
    print(f"{found.residual * 1e3:.2f} mm from it (standard deviation), {len(points)} frames")


def _cloud(given: argparse.Namespace) -> None:
    extrinsics = Extrinsics.read(given.extrinsics)
    intrinsics, frames = _frames(given)
    last = deque(frames, maxlen=_AVERAGED)  # by then exposure has settled
    if not last:
        raise DeviceError("realsense: no depth frame came")
    convert = DepthToCloud(intrinsics, extrinsics, CloudSettings())
    made = [convert(frame.depth, frame.unit) for frame in last]
    cloud, lost, _ = made[-1]
    write_cloud(cloud, given.out)
    print(f"{given.out}: {len(cloud)} points, {lost:.1%} of the pixels without depth")
    widest = ProxySettings().widest_spacing
    if cloud.spacing > widest:
        apart = f"{1e3 * cloud.spacing:.1f} mm apart: from {1e3 * widest:.1f} mm on"
        print(f"{apart} the detector's proxy comes through when one presses")
    offsets = [_offset(each.cloud.points()) for each in made]
    print(f"if that is the untouched object: detector.surface_offset={np.mean(offsets):.6f}")


def _touch(given: argparse.Namespace) -> None:
    said = Extrinsics.read(given.extrinsics)
    recording = load(given.touches)
    touches = touches_of(recording, level=given.level)
    if given.cloud is None and not recording.clouds:
        expected = "the cloud that the camera saw, or --cloud FILE"
        raise BadInput(given.touches, at="clouds", found="none", expected=expected)
    cloud = read_cloud(given.cloud) if given.cloud is not None else Cloud(recording.clouds[0][1])
    found = calibrate_by_touch(
        cloud, touches.positions, said, spread=touches.spread, tip_radius=given.tip_radius, keep_level=given.keep_level
    )
    found.extrinsics.write(given.out)
    print("\n".join([f"{given.out}: {line}" if i == 0 else line for i, line in enumerate(found.lines())]))


def _offset(points: NDArray[np.float64]) -> float:
    """What a detector should take a flat top for, whose rim is where the points end.

    Raises:
        BadInput: there is none.
    """
    r2 = ProxySettings().r2
    if not len(points):
        raise BadInput("camera", found="no points", expected="the object's top in the box that is kept")
    low, high = points[:, :2].min(axis=0) + 2.0 * r2, points[:, :2].max(axis=0) - 2.0 * r2
    return measured_offset(points, r2, (low[0], low[1]), (high[0], high[1]))


def _frames(given: argparse.Namespace) -> tuple[Intrinsics, Iterator[DepthFrame]]:
    if given.frames < 1:
        raise BadInput("--frames", found=given.frames, expected="1 or more")
    if given.recording:
        intrinsics, frames = recorded_frames(given.recording)
        return intrinsics, islice(frames, given.frames)
    stream = open_camera(given.serial)

    def live() -> Iterator[DepthFrame]:
        with stream:
            for _ in range(given.frames):
                frame = stream.read(_PATIENCE)
                if frame is None:
                    raise DeviceError(f"realsense: no depth frame within {_PATIENCE:g} s")
                yield frame

    return stream.intrinsics, live()


if __name__ == "__main__":
    sys.exit(main())
