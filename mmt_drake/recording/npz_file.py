"""Recordings as NPZ: one array per column, as numpy keeps them."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.recording.check import Clouds, completed
from mmt_drake.recording.public import find, read_public
from mmt_drake.recording.recording import Array, Recording

_CLOUDS = ("cloud_time", "cloud_size", "cloud_points")


def load_npz(path: Path, forces: bool) -> list[Recording]:
    """Read the recordings of an ``.npz`` file.

    In the contract's form the arrays are the columns, each (n,); numbers without a
    dimension are ``Recording.constants``; ``cloud_time`` (m,), ``cloud_size`` (m,) and
    ``cloud_points`` (sum of sizes, 3) are the clouds. Without ``time`` the public data sets
    of ``public`` are recognised by their array names.

    Raises:
        BadInput: no NPZ file, a truncated one, arrays that are no numbers or not (n,), an
            unknown form, or what ``check.completed`` finds.
    """
    source = str(path)
    arrays = _arrays(path)
    if "time" not in arrays:
        return read_public(find(arrays, source), arrays, source)
    constants = {name: float(array) for name, array in arrays.items() if array.ndim == 0}
    clouds = _read_clouds({name: arrays.pop(name) for name in _CLOUDS if name in arrays}, source)
    columns: dict[str, Array] = {}
    for name, array in arrays.items():
        if array.ndim > 1:
            raise BadInput(source, at=name, found=f"shape {array.shape}", expected="(n,), one array per column")
        if array.ndim == 1:
            columns[name] = array.astype(np.float64)
    if "time" not in columns:
        raise BadInput(source, at="time", found="a single number", expected="(n,)")
    time = columns.pop("time")
    return [completed(time, columns, source, forces=forces, clouds=clouds, constants=constants)]


def _arrays(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    source = str(path)
    try:
        loaded = np.load(path, allow_pickle=False)
        if isinstance(loaded, np.lib.npyio.NpzFile):
            with loaded as file:
                arrays = {name: file[name] for name in file.files}
        else:
            arrays = None
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError) as error:
        raise BadInput(source, found=f"a file that cannot be read ({error})", expected="a complete NPZ file") from error
    if arrays is None:
        raise BadInput(source, found="a single array", expected="an NPZ file, one array per column")
    for name, array in arrays.items():
        if array.dtype.kind not in "biuf":
            raise BadInput(source, at=name, found=f"type {array.dtype}", expected="numbers")
    return arrays


def _read_clouds(arrays: dict[str, np.ndarray[Any, Any]], source: str) -> Clouds:
    if not arrays:
        return ()
    times, sizes, points = (arrays.get(name, np.empty(0)) for name in _CLOUDS)
    if (
        len(arrays) < 3
        or points.ndim != 2
        or points.shape[1] != 3
        or len(times) != len(sizes)
        or sizes.sum() != len(points)
    ):
        found = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise BadInput(
            source, at="clouds", found=found, expected="cloud_time (m,), cloud_size (m,), cloud_points (sum, 3)"
        )
    parts = np.split(points.astype(np.float32), np.cumsum(sizes.astype(int))[:-1])
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
    with path.open("wb") as file:
        np.savez(file, **arrays)
