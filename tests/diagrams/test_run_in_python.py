"""`mmt.run`: a station from Python, and what was recorded."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mmt_drake as mmt
from mmt_drake.errors import BadInput


def test_it_gives_what_the_station_records(tmp_path: Path) -> None:
    scenario = mmt.load_scenario("setup1", ["seed=3"])
    mmt.build_station(scenario, record=tmp_path / "a.mcap").simulate(0.5)
    expected = mmt.load(tmp_path / "a.mcap")
    for record in (None, tmp_path / "b.mcap", tmp_path / "c.csv"):
        found = mmt.run(scenario, seconds=0.5, record=record)
        assert list(found.columns) == list(expected.columns)
        np.testing.assert_array_equal(found["rendered_force_z"], expected["rendered_force_z"])
        assert found.source == ("setup1" if record is None else str(record))
        if record is not None:
            np.testing.assert_allclose(mmt.load(record)["force_z"], expected["force_z"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mcap", "b.mcap", "c.csv"]


def test_an_operator_s_recording_is_followed_to_its_end() -> None:
    time = np.arange(0.0, 0.31, 0.01)
    hand = mmt.Recording(time, {f"position_{axis}": 0.01 * np.cos(9.0 * time) for axis in "xyz"})
    assert mmt.run("setup1", operator=hand).time[-1] == pytest.approx(0.3, abs=2e-3)


def test_a_name_that_is_no_recording_s_is_refused_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"a\.txt: found"):
        mmt.run("setup1", seconds=0.1, record=tmp_path / "a.txt")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("seconds", [-1.0, 0.0, float("nan"), "3"])
def test_no_time_to_run_is_told_before_anything_is_built(seconds: Any) -> None:
    with pytest.raises(BadInput, match="run: seconds: found"):
        mmt.run("setup1", seconds=seconds)
