"""Large parts of a recording, long columns and clouds, on disk and read piece by piece."""

import ctypes
import os
import weakref
from collections.abc import Iterator, Mapping, Sequence
from tempfile import TemporaryFile
from typing import IO, overload

import numpy as np

from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.recording import Cloud, Points

MOST_IN_MEMORY = 2**18
"""Rows of a column from which on it is stored: four minutes at 1 kHz."""


def return_freed() -> None:
    """Let the system have the memory back that reading a long file has left free in the allocator, where glibc is."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


class _Stored:
    """A temporary file, which is gone with the last who holds it."""

    def __init__(self, buffering: int = -1) -> None:
        self._file: IO[bytes] = TemporaryFile(buffering=buffering)  # noqa: SIM115 - closed when nobody holds this any more
        weakref.finalize(self, self._file.close)


class StoredColumn(_Stored):
    """Numbers in a temporary file."""

    def add(self, values: Array) -> None:
        """Append numbers, (n,)."""
        self._file.write(np.ascontiguousarray(values).data)

    def read(self) -> Array:
        """All of them, (n,): a private copy, page by page where it is written to."""
        self._file.flush()
        return np.asarray(np.memmap(self._file, dtype=np.float64, mode="c"))


Column = Array | StoredColumn


def as_array(column: Column) -> Array:
    """The numbers of a column, (n,)."""
    return column.read() if isinstance(column, StoredColumn) else column


def stored(values: Array) -> Column:
    """The column that these numbers, (n,), are to be kept as: stored, if they are many."""
    if len(values) < MOST_IN_MEMORY:
        return values
    column = StoredColumn()
    column.add(values)
    return column


class LongColumns(Mapping[str, Array]):
    """Columns by name. One that is stored is read anew each time it is asked for.

    Args:
        parts: a name that is in several counts as in the last of them.
    """

    def __init__(self, *parts: Mapping[str, Column]):
        self._columns: dict[str, Column] = {}
        for part in parts:
            self._columns.update(part._columns if isinstance(part, LongColumns) else part)

    def __getitem__(self, name: str) -> Array:
        return as_array(self._columns[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __or__(self, more: Mapping[str, Array]) -> "LongColumns":
        """These and more, which count where a name is in both, as with a dict."""
        return LongColumns(self, more)

    def __reduce__(self) -> tuple[type[dict[str, Array]], tuple[dict[str, Array]]]:
        return dict, (dict(self.items()),)  # a file does not go to another process


class StoredPoints(_Stored):
    """The points of clouds, one cloud after the other, in a temporary file."""

    def __init__(self) -> None:
        super().__init__(buffering=0)
        self._end = 0

    def add(self, points: Points) -> tuple[int, int]:
        """Append a cloud, (m, 3); where it begins, in bytes, and how many points it has."""
        start = self._end
        self._end += self._file.write(np.ascontiguousarray(points, dtype=np.float32).data)
        return start, len(points)

    def read(self, start: int, count: int) -> Points:
        """The cloud that begins there, (m, 3)."""
        points: Points = np.frombuffer(bytearray(os.pread(self._file.fileno(), 12 * count, start)), dtype=np.float32)
        return points.reshape(count, 3)


class StoredClouds(Sequence[Cloud]):
    """Clouds of a recording. One is read anew each time it is asked for.

    Args:
        points: holds them.
        placed: of each, its time [s], where it begins and how many points it has.
    """

    def __init__(self, points: StoredPoints, placed: Sequence[tuple[float, int, int]]):
        self._points, self._placed = points, placed

    @overload
    def __getitem__(self, index: int) -> Cloud: ...
    @overload
    def __getitem__(self, index: slice) -> "StoredClouds": ...
    def __getitem__(self, index: int | slice) -> "Cloud | StoredClouds":
        if isinstance(index, slice):
            return StoredClouds(self._points, self._placed[index])
        time, start, count = self._placed[index]
        return time, self._points.read(start, count)

    def __len__(self) -> int:
        return len(self._placed)

    def __reduce__(self) -> tuple[type[tuple[Cloud, ...]], tuple[list[Cloud]]]:
        return tuple, (list(self),)
