"""A recording in Python: units of its columns, a short text, a table in a notebook, a DataFrame where pandas is."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from samples import contact

from mmt_drake.errors import MissingDependency
from mmt_drake.recording import Recording, save
from mmt_drake.recording.signals import SIGNALS

WHOLE = contact(0.1)


def test_every_column_has_its_unit() -> None:
    units = WHOLE.units
    assert set(units) == {"time", *WHOLE.columns}
    assert (units["time"], units["position_x"], units["velocity_z"], units["true_force_y"]) == ("s", "m", "m/s", "N")
    assert (units["theta_m"], units["theta_normal_b"], units["theta_deviation_v_d"]) == ("kg", "N s/m", "m/s")
    assert (units["in_contact"], units["stored_energy"], units["held_body_stamp_y"]) == ("", "J", "s")
    driven = Recording(np.arange(3.0), {"input": np.zeros(3), "output": np.zeros(3)})
    assert driven.units == {"time": "s", "input": "", "output": ""}  # its own, which no recording tells
    axis = Recording(np.arange(3.0), {"position": np.zeros(3), "force": np.zeros(3)})
    assert axis.units == {"time": "s", "position": "m", "force": "N"}
    assert all(len(signal.units) == signal.size for signal in SIGNALS)


def test_it_prints_in_a_line_and_a_notebook_shows_signals_with_units() -> None:
    recording = Recording(np.arange(3.0), {"position": np.zeros(3), "force": np.zeros(3)}, source="a<b>.csv")
    assert repr(recording) == "Recording(a<b>.csv: single_axis, 2 s, 3 rows of 2 columns)"
    assert len(repr(WHOLE)) < 100
    shown = recording._repr_html_()
    assert "a&lt;b&gt;.csv" in shown and "<tr><td>force</td><td>N</td></tr>" in shown
    assert "<td>theta_m, theta_k1" in WHOLE._repr_html_() and "<td>kg, N/m, N s/m, N, m/s</td>" in WHOLE._repr_html_()
    assert repr(Recording(np.zeros(0), {})) == "Recording(recording: contact, 0 s, 0 rows of 0 columns)"


def test_a_data_frame_has_columns_and_units_over_time(monkeypatch: pytest.MonkeyPatch) -> None:
    pandas = SimpleNamespace(
        Index=lambda values, name: (name, values),
        DataFrame=lambda data, index: SimpleNamespace(data=data, index=index, attrs={}),
    )  # what of it is called
    monkeypatch.setitem(sys.modules, "pandas", pandas)
    frame = WHOLE.to_dataframe()
    assert list(frame.data) == list(WHOLE.columns) and frame.index == ("time", WHOLE.time)
    assert frame.attrs == {"units": WHOLE.units}


def test_without_pandas_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingDependency, match="to_dataframe: pandas is not installed: pip install pandas"):
        WHOLE.to_dataframe()


def test_channels_of_an_mcap_file_name_their_columns_and_units(tmp_path) -> None:
    save(WHOLE, tmp_path / "a.mcap")
    with (tmp_path / "a.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    told = {channel.topic: channel.metadata for channel in summary.channels.values()}
    assert told["/estimator/theta"]["columns"].startswith("theta_m, theta_k1, theta_k2")
    assert told["/estimator/theta"]["units"].startswith("kg, N/m, N/m")
    assert told["/telerobot/wrench"] == {"columns": "force_x, force_y, force_z", "units": "N, N, N"}


def test_one_recording_where_several_are_expected_is_told_so() -> None:
    with pytest.raises(TypeError, match=r"put it into a list, \[recording\]"):
        list(WHOLE)  # type: ignore[call-overload]
