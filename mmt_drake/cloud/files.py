"""Clouds from and to files, filtered; Open3D does the work and is imported only here, when needed."""

import contextlib
import io
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.atomic import replacing

SUFFIXES = (".ply", ".pcd", ".xyz")
_HEADER_BYTES = 1 << 16
_MOST_BYTES, _MOST_POINTS = 1 << 26, 5_000_000  # of a file: Open3D takes some hundred bytes a point to read it
_COUNTS = re.compile(rb"^(?:element\s+\w+|POINTS|WIDTH|HEIGHT)\s+(\d{1,250})", re.MULTILINE)
_PCD_LINE = re.compile(rb"^(POINTS|SIZE)[ \t]+(.*)$", re.MULTILINE)


def read_cloud(path: str | Path) -> Cloud:
    """Read a `.ply`, `.pcd` or `.xyz` file whose coordinates are metres in the table frame.

    Raises:
        BadInput: no such file, another ending, nothing readable in it, or a coordinate that is not finite.
    """
    path = _checked_suffix(path)
    if not path.is_file():
        raise BadInput(path, found="no such file", expected="a point cloud")
    points = _read_points(path)
    if len(points) == 0:
        raise BadInput(path, found="no points that Open3D can read", expected=f"a point cloud in {path.suffix} format")
    _check_text_rows(path, len(points))
    try:
        return Cloud(points)
    except BadInput as error:
        raise BadInput(path, found=error.found, expected=error.expected, at=error.at) from None


def write_cloud(cloud: Cloud, path: str | Path) -> None:
    """Write the points where they are now to a `.ply`, `.pcd` or `.xyz` file [m]; whole or not at all.

    Raises:
        BadInput: another ending, or a folder that cannot be written to.
    """
    path = _checked_suffix(path)
    import open3d

    with replacing(path) as temporary:
        if not open3d.io.write_point_cloud(temporary, cloud.to_open3d()):
            raise BadInput(path, found="a file that could not be written", expected="room and permission to write it")


def thinned(cloud: Cloud, voxel: float) -> Cloud:
    """One point, the mean, for each cube of edge `voxel` [m] that holds points."""
    if not voxel > 0.0:
        raise BadInput("voxel filter", at="voxel", found=voxel, expected="an edge above 0 m")
    try:
        return Cloud(np.asarray(cloud.to_open3d().voxel_down_sample(voxel).points), stamp=cloud.stamp)
    except RuntimeError:  # Open3D numbers the cubes along an edge by 32 bits
        raise BadInput("voxel filter", at="voxel", found=voxel, expected="larger cubes for so wide a cloud") from None


def _checked_suffix(path: str | Path) -> Path:
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise BadInput(path, found=f"a name ending in {path.suffix!r}", expected=" or ".join(SUFFIXES))
    return path


def _read_points(path: Path) -> Array:
    """(n, 3) points as Open3D reads them; a warning of its (a file cut short, say) is taken for the error it is."""
    size = path.stat().st_size
    if size > _MOST_BYTES:
        expected = f"at most {_MOST_BYTES >> 20} MiB (a larger cloud is to be thinned)"
        raise BadInput(path, found=f"{size / 2**20:.4g} MiB", expected=expected)
    with path.open("rb") as file:  # Open3D makes room for as many as the header says
        header = file.read(_HEADER_BYTES)
    if path.suffix.lower() == ".pcd":
        _check_pcd(path, header)
    if path.suffix.lower() == ".ply" and b"end_header" not in header:  # Open3D reads on beyond the end of the file
        raise BadInput(path, found="a header without an end", expected="a whole point cloud in .ply format")
    claimed = max(map(int, _COUNTS.findall(header)), default=0)
    if claimed > size:
        raise BadInput(path, found=f"{claimed} elements in {size} bytes", expected="a whole point cloud")
    if claimed > _MOST_POINTS:
        raise BadInput(path, found=f"{claimed} elements", expected=f"at most {_MOST_POINTS}")
    import open3d

    said = io.StringIO()
    level = open3d.utility.VerbosityLevel.Warning
    with open3d.utility.VerbosityContextManager(level), contextlib.redirect_stdout(said), _quiet():
        read = open3d.io.read_point_cloud(path, remove_nan_points=False, remove_infinite_points=False)
    if said.getvalue():
        found = f"{size} bytes that Open3D cannot read to the end"
        raise BadInput(path, found=found, expected=f"a whole point cloud in {path.suffix} format")
    return np.asarray(read.points)


def _check_pcd(path: Path, header: bytes) -> None:
    """Open3D makes room for any number of points where none is said, and reads beyond numbers that are too long."""
    lines = dict(_PCD_LINE.findall(header))
    if not lines.get(b"POINTS", b"").strip().isdigit():
        raise BadInput(path, at="POINTS", found=_text(lines.get(b"POINTS", b"nothing")), expected="how many there are")
    for word in lines.get(b"SIZE", b"").split():
        if word not in (b"1", b"2", b"4", b"8"):
            raise BadInput(path, at="SIZE", found=_text(word), expected="1, 2, 4 or 8 bytes a number")


def _text(raw: bytes) -> str:
    return raw[:40].decode("latin-1").strip()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Nothing on stderr, to which the reader of `.ply` files writes beside the warning that Open3D gives."""
    kept, null = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(null)


def _check_text_rows(path: Path, n: int) -> None:
    """Open3D ends text files quietly at the first row it cannot read; so count the rows and find it."""
    with path.open(encoding="latin-1") as file:
        rows = enumerate(file, 1)
        if path.suffix.lower() == ".pcd":
            for _, line in rows:
                if line.split()[:1] == ["DATA"]:
                    if line.split()[1:] != ["ascii"]:
                        return
                    break
        elif path.suffix.lower() == ".ply":
            return
        found = 0
        for number, line in rows:
            try:
                values = [float(word) for word in line.split()]
            except ValueError:
                values = []
            if len(values) >= 3 and (path.suffix.lower() == ".pcd" or len(values) == 3):
                found += 1
            elif line.strip():
                raise BadInput(path, at=f"line {number}", found=line.strip()[:40], expected="three numbers x y z [m]")
    if found != n:
        raise BadInput(path, found=f"{found} rows", expected=f"{n} points")
