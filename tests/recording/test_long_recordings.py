"""Reading a long recording takes little more memory than its columns."""

import errno
import os
import pickle
from dataclasses import replace
from pathlib import Path
from tempfile import gettempdir

import numpy as np
import pytest
from memory import peak_of
from samples import contact, same

from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, growing, load, one_clock, save, stored
from mmt_drake.recording.growing import GrowingColumns


def size_of(recording: Recording) -> int:
    """Bytes of all columns."""
    return recording.time.nbytes + sum(column.nbytes for column in recording.columns.values())


def long_recording(repetitions: int = 60) -> Recording:
    """Two seconds of every column, again and again."""
    part = contact(2.0)
    columns = {name: np.tile(column, repetitions) for name, column in part.columns.items()}
    return Recording(np.arange(len(part) * repetitions) * 1e-3, columns)


def test_reading_peaks_at_one_and_a_half_times_the_columns(tmp_path: Path) -> None:
    written = long_recording()
    save(long_recording(1), tmp_path / "short.mcap")
    save(written, tmp_path / "long.mcap")
    load(tmp_path / "short.mcap")  # what is compiled and imported at first use does not grow with the recording
    read, peak = peak_of(lambda: load(tmp_path / "long.mcap"))
    assert len(read) == 120_000
    assert size_of(read) < peak < 1.5 * size_of(read)
    assert all(column.base is None for column in read.columns.values()), "a view keeps all of what it looks at"
    same(written, read, clock=1e-9)


def test_what_is_longer_than_fits_stands_on_disk_and_is_read_column_by_column(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (growing, one_clock, stored):
        monkeypatch.setattr(module, "MOST_IN_MEMORY", 2**13)
    written = long_recording()
    clouds = tuple((float(i), np.full((i + 1, 3), i, dtype=np.float32)) for i in range(9))
    save(replace(written, clouds=clouds), tmp_path / "long.mcap")
    load(tmp_path / "long.mcap")
    read, peak = peak_of(lambda: load(tmp_path / "long.mcap"))
    assert peak < size_of(read) / 8, (peak / read.time.nbytes, size_of(read) / read.time.nbytes)
    same(written, read, clock=1e-9)
    assert [(time, points.tolist()) for time, points in read.clouds] == [(t, p.tolist()) for t, p in clouds]
    assert [len(points) for _, points in read.clouds[-2:]] == [8, 9]
    more = read.columns | {"force_x": read["force_y"], "load": read.time}
    assert list(more) == [*read.columns, "load"] and np.array_equal(more["force_x"], read["force_y"])
    read["force_x"][:] = np.nan  # of whoever asked, not of the recording
    same(written, pickle.loads(pickle.dumps(read)), clock=1e-9)


def test_a_full_disk_for_what_is_read_is_not_blamed_on_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    for module in (growing, one_clock, stored):
        monkeypatch.setattr(module, "MOST_IN_MEMORY", 2**9)
    monkeypatch.setattr(stored.StoredColumn, "add", refuse)
    save(long_recording(1), tmp_path / "long.mcap")
    with pytest.raises(
        BadInput, match=rf"^{gettempdir()}: found No space left .* room for what is read of .*long\.mcap"
    ):
        load(tmp_path / "long.mcap")


def test_growing_columns_hold_what_was_added_and_no_spare_room() -> None:
    rng = np.random.default_rng(0)
    blocks = [rng.standard_normal((rows, 5)) for rows in (1, 0, 1023, 1, 700, 5000, 3)]
    growing = GrowingColumns(3)
    for block in blocks:
        growing.add(block)
    columns = growing.take()
    np.testing.assert_array_equal(np.column_stack(columns), np.concatenate(blocks)[:, :3])
    assert [column.nbytes for column in columns] == [8 * sum(map(len, blocks))] * 3
    assert growing.take() == []
