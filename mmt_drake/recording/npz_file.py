"""Recordings as NPZ: one array per column, as numpy keeps them."""

import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from mmt_drake.errors import BadInput, readable
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.bounds import MOST_COLUMNS, check_size, check_unpacked
from mmt_drake.recording.check import completed, mapped
from mmt_drake.recording.column_map import ColumnMap, left_out, units_of
from mmt_drake.recording.public import find, read_public
from mmt_drake.recording.recording import Cloud, Recording

_CLOUDS = ("cloud_time", "cloud_size", "cloud_points")


def load_npz(path: Path, forces: bool, columns: ColumnMap) -> list[Recording]:
    """Read the recordings of an ``.npz`` file.

    In the contract's form the arrays are the columns, each (n,); numbers without a
    dimension are ``Recording.constants``; ``cloud_time`` (m,), ``cloud_size`` (m,) and
    ``cloud_points`` (sum of sizes, 3) are the clouds. ``columns`` says what other arrays are. Without ``time`` the
    public data sets of ``public`` are recognised by their array names.

    Raises:
        BadInput: no NPZ file, a truncated one, arrays that are no numbers or not (n,), an
            unknown form, or what ``check.completed`` finds.
    """
    source = str(path)
    arrays = arrays_of(path)
    taken = columns.taken([name for name, a in arrays.items() if a.ndim == 1 and name not in _CLOUDS], source)
    if "time" not in {column.name for column in taken}:
        if "time" in arrays:
            shape = arrays["time"].shape
            raise BadInput(source, at="time", found=f"shape {shape}" if shape else "a single number", expected="(n,)")
        return [mapped(recording, columns, forces) for recording in read_public(find(arrays, source), arrays, source)]
    constants = {name: float(array) for name, array in arrays.items() if array.ndim == 0}
    clouds = _read_clouds({name: arrays.pop(name) for name in _CLOUDS if name in arrays}, source)
    for name, array in arrays.items():
        if array.ndim > 1 and not columns:
            raise BadInput(source, at=name, found=f"shape {array.shape}", expected="(n,), one array per column")
    read: dict[str, Array] = {}
    for column in taken:
        array = arrays.pop(column.column)  # let go one by one: a long recording does not stand in memory twice
        read[column.name] = array.astype(np.float64, copy=False)
        if column.factor != 1.0:
            read[column.name] = column.factor * read[column.name]
    time, units = read.pop("time"), units_of(taken)
    notes = left_out([name for name, array in arrays.items() if array.ndim > 0], ())
    return [completed(time, read, source, forces=forces, notes=notes, clouds=clouds, constants=constants, units=units)]


def names_of(path: Path) -> tuple[str, ...]:
    """The names of the arrays (n,) of a file.

    Raises:
        BadInput: see ``load_npz``.
    """
    return tuple(name for name, array in arrays_of(path).items() if array.ndim == 1)


def arrays_of(path: Path, *, texts: bool = False) -> dict[str, np.ndarray[Any, Any]]:
    """Every array of the file; what is no array of numbers, or too much, is refused before it is read.

    Args:
        path: of the file.
        texts: it may have texts beside the numbers, which are left out.

    Raises:
        BadInput: no NPZ file, a truncated one, arrays of other things, more than ``bounds`` allows.
    """
    source = str(path)
    with readable(source, "a file", "a complete NPZ file"):
        with path.open("rb") as file:
            if file.read(len(np.lib.format.MAGIC_PREFIX)) == np.lib.format.MAGIC_PREFIX:
                raise BadInput(source, found="a single array", expected="an NPZ file, one array per column")
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
            if len(members) > MOST_COLUMNS:
                raise BadInput(source, found=f"{len(members)} arrays", expected=f"at most {MOST_COLUMNS}")
            size = sum(member.file_size for member in members)
            check_size(source, size)
            check_unpacked(source, size, path.stat().st_size)
            arrays: dict[str, np.ndarray[Any, Any]] = {}
            for member in members:
                name = member.filename.removesuffix(".npy")
                if name in arrays:
                    raise BadInput(source, at=name, found="the same name twice", expected="each array once")
                array = _array(archive, member, name, source, texts)
                if array is None:
                    continue
                arrays[name] = array
                check_size(source, 8 * sum(array.size for array in arrays.values()))  # bytes may become float64
            return arrays


def _array(
    archive: zipfile.ZipFile, member: zipfile.ZipInfo, name: str, source: str, texts: bool
) -> np.ndarray[Any, Any] | None:
    """One array, read once its header is known to be that of as many numbers as there are bytes; None if of texts."""
    with archive.open(member) as file:
        if file.read(len(np.lib.format.MAGIC_PREFIX)) != np.lib.format.MAGIC_PREFIX:
            raise BadInput(source, at=name, found="a member that is no array", expected="arrays (.npy) alone")
        file.seek(0)
        major = np.lib.format.read_magic(file)[0]
        read = np.lib.format.read_array_header_1_0 if major == 1 else np.lib.format.read_array_header_2_0
        shape, _, dtype = read(file)
        if texts and dtype.kind == "U":
            return None
        if dtype.kind not in "biuf":
            raise BadInput(source, at=name, found=f"type {dtype}", expected="numbers")
        announced, there = math.prod(shape) * dtype.itemsize, member.file_size - file.tell()
        if announced != there:
            raise BadInput(source, at=name, found=f"{there} bytes", expected=f"{announced}, as its header says")
        file.seek(0)
        array: np.ndarray[Any, Any] = np.lib.format.read_array(file, allow_pickle=False)
        return array


def _read_clouds(arrays: dict[str, np.ndarray[Any, Any]], source: str) -> tuple[Cloud, ...]:
    if not arrays:
        return ()
    times, sizes, points = (arrays.get(name, np.empty(0)) for name in _CLOUDS)
    if len(arrays) < 3 or (times.ndim, sizes.ndim, points.ndim) != (1, 1, 2) or points.shape[1] != 3:
        found = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        expected = "cloud_time (m,), cloud_size (m,), cloud_points (sum, 3)"
        raise BadInput(source, at="clouds", found=found, expected=expected)
    whole = sizes.dtype.kind in "iu" and (sizes >= 0).all() and (sizes <= len(points)).all()
    if len(times) != len(sizes) or not whole or sizes.sum() != len(points):
        found = f"{len(times)} times, sizes {sizes[:4]}{' ...' * (len(sizes) > 4)}, {len(points)} points"
        expected = "a size for each time, which add up to the points"
        raise BadInput(source, at="cloud_size", found=found, expected=expected)
    times = times.astype(np.float64)
    for name, array in ((_CLOUDS[0], times), (_CLOUDS[2], points)):
        bad = ~np.isfinite(array.reshape(len(array), -1)).all(axis=1)
        if bad.any():
            row = int(np.argmax(bad))
            raise BadInput(source, at=f"row {row + 1}, array {name!r}", found=array[row], expected="finite numbers")
    if (np.diff(times) <= 0.0).any():
        row = int(np.argmax(np.diff(times) <= 0.0)) + 1
        found = f"{times[row]} s after {times[row - 1]} s"
        raise BadInput(source, at=f"row {row + 1}, array 'cloud_time'", found=found, expected="times that increase")
    parts = np.split(points.astype(np.float32), np.cumsum(sizes)[:-1])
    return tuple((float(time), part) for time, part in zip(times, parts, strict=True))


def write_npz(recording: Recording, path: Path) -> None:
    """Write every column, the constants and the clouds.

    Args:
        path: where to write; whoever calls renames it when it is whole.
    """
    arrays: dict[str, Any] = {"time": recording.time, **recording.columns, **recording.constants}
    if recording.clouds:
        times, clouds = zip(*recording.clouds, strict=True)
        contents = (np.array(times), np.array([len(points) for points in clouds]), np.concatenate(clouds))
        arrays |= dict(zip(_CLOUDS, contents, strict=True))
    with zipfile.ZipFile(path, "w") as archive:  # as `numpy.savez` does, which has names of its own: `file`
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
