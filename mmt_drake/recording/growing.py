"""Columns that grow in place while a file is read."""

import numpy as np

from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.stored import MOST_IN_MEMORY, Column, StoredColumn

_FIRST = 1024
_AT_ONCE = 2**12  # rows that are stored together


class GrowingColumns:
    """Columns of one length to which rows are added.

    Each column is one array from the first row on and is handed out as it is. Columns gathered from pieces would
    stand in memory twice while the pieces are joined. Room grows by an eighth at a time: that is all the memory that
    can be in excess, and large arrays are moved by the memory map, not copied. Columns of more than `MOST_IN_MEMORY`
    rows are stored as they grow.

    Args:
        width: number of columns.
    """

    def __init__(self, width: int):
        self._columns = [np.empty(_FIRST) for _ in range(width)]
        self._stored: list[StoredColumn] = []
        self._length = 0

    def add(self, rows: Array) -> None:
        """Append rows, (n, k): the first ``width`` of their k numbers."""
        end = self._length + len(rows)
        for i, column in enumerate(self._columns):
            if end > len(column):
                column.resize(max(end, len(column) * 9 // 8), refcheck=False)  # no one else has seen it yet
            column[self._length : end] = rows[:, i]
        self._length = end
        if end >= (_AT_ONCE if self._stored else MOST_IN_MEMORY):
            self._store()

    def take(self) -> list[Column]:
        """The columns, (n,) each; nothing is left here."""
        if self._stored:
            self._store()
        columns: list[Array] = self._columns
        files, self._columns, self._stored = self._stored, [], []
        for column in columns:
            column.resize(self._length, refcheck=False)
        return [*files] or [*columns]

    def _store(self) -> None:
        """Put away the rows that are in memory."""
        self._stored = self._stored or [StoredColumn() for _ in self._columns]
        for column, file in zip(self._columns, self._stored, strict=True):
            file.add(column[: self._length])
            column.resize(_FIRST, refcheck=False)
        self._length = 0
