"""Columns that grow in place while a file is read."""

import numpy as np

from mmt_drake.recording.recording import Array

_FIRST = 1024


class GrowingColumns:
    """Columns of one length to which rows are added.

    Each column is one array from the first row on and is handed out as it is. Columns gathered from pieces would
    stand in memory twice while the pieces are joined. Room grows by an eighth at a time: that is all the memory that
    can be in excess, and large arrays are moved by the memory map, not copied.

    Args:
        width: number of columns.
    """

    def __init__(self, width: int):
        self._columns = [np.empty(_FIRST) for _ in range(width)]
        self._length = 0

    def add(self, rows: Array) -> None:
        """Append rows, (n, k): the first ``width`` of their k numbers."""
        end = self._length + len(rows)
        for i, column in enumerate(self._columns):
            if end > len(column):
                column.resize(max(end, len(column) * 9 // 8), refcheck=False)  # no one else has seen it yet
            column[self._length : end] = rows[:, i]
        self._length = end

    def take(self) -> list[Array]:
        """The columns, (n,) each; nothing is left here."""
        columns, self._columns = self._columns, []
        for column in columns:
            column.resize(self._length, refcheck=False)
        return columns
