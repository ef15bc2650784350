"""Figures show the recording's own numbers, named and with units."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

from mmt_drake.analysis import charts
from mmt_drake.analysis.figures import THESIS_FIGURES, measured_and_rendered
from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.plotting import PIXELS, envelope, png, save
from mmt_drake.analysis.signals import amplitude_spectrum
from mmt_drake.analysis.windows import dominant_window, frozen_since
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import THETA_UNITS

DELAY_S = 0.4

LINES = {
    8: {"y", "z"},
    9: {"measured", "rendered", "difference"},
    10: {"estimated", "rendered"},
    11: {"estimated", "rendered"},
    14: {"measured", "rendered, 400 ms later", "difference"},
    24: {"y", "z", "measured", "rendered"},
    25: {"measured", "rendered", "difference"},
    26: {"measured", "rendered", "difference"},
    27: {"measured force", "rendered less measured"},
    28: {"measured force", "rendered force"},
    29: {"measured, filtered", "estimated", "difference"},
    30: {"measured", "rendered", "estimated"},
    31: {"measured", "rendered", "estimated"},
    35: {"y", "z", "measured", "rendered, 400 ms later"},
}


def frozen(run):
    """The run with theta standing still from 5 s on."""
    columns = {
        name: np.where(run.time > 5.0, values[5000], values) if name.startswith("theta_") else values
        for name, values in run.columns.items()
    }
    return replace(run, columns=columns)


def lines_of(figure):
    """label -> Line2D, of all panels; grid and marker lines left out."""
    return {
        line.get_label(): line for axes in figure.axes for line in axes.lines if not line.get_label().startswith("_")
    }


def without(run, *prefixes):
    return replace(run, columns={k: v for k, v in run.columns.items() if not k.startswith(prefixes)})


@pytest.mark.parametrize("number", THESIS_FIGURES)
def test_a_thesis_figure_has_its_lines_and_every_axis_its_unit(stroke_run, number):
    delay = DELAY_S if number in (14, 35) else 0.0
    figure = THESIS_FIGURES[number](frozen(stroke_run), delay_s=delay)
    assert set(lines_of(figure)) == LINES[number]
    for axes in figure.axes:
        assert "[" in axes.get_ylabel()
    assert figure.axes[-1].get_xlabel() in ("time [s]", "frequency [Hz]")
    assert png(figure).startswith(b"\x89PNG")


@pytest.mark.parametrize("number", THESIS_FIGURES)
def test_a_thesis_figure_refuses_a_recording_without_its_columns(stroke_run, number):
    position_only = without(stroke_run, "force", "rendered", "estimated", "filtered", "master")
    with pytest.raises(BadInput, match=r"test\.csv: found columns"):
        THESIS_FIGURES[number](frozen(position_only))


def test_a_window_shows_the_recorded_samples_themselves(stroke_run):
    lines = lines_of(measured_and_rendered(stroke_run, window_s=(6.0, 8.0)))
    inside = slice(6000, 8001)
    assert np.array_equal(lines["measured"].get_xdata(), stroke_run.time[inside])
    assert np.array_equal(lines["measured"].get_ydata(), stroke_run["force_y"][inside])
    assert np.array_equal(lines["rendered"].get_ydata(), stroke_run["rendered_force_y"][inside])
    difference = stroke_run["rendered_force_y"][inside] - stroke_run["force_y"][inside]
    assert np.array_equal(lines["difference"].get_ydata(), difference)


def test_the_rendered_force_is_shown_later_by_the_delay(stroke_run):
    lines = lines_of(measured_and_rendered(stroke_run, delay_s=DELAY_S, window_s=(6.0, 8.0), axis="x"))
    shifted = lines["rendered, 400 ms later"].get_ydata()
    assert np.array_equal(shifted, stroke_run["rendered_force_x"][5600:7601])


def test_a_window_outside_the_recording_is_refused(stroke_run):
    with pytest.raises(BadInput, match=r"window_s: found \(70\.0, 80\.0\)"):
        measured_and_rendered(stroke_run, window_s=(70.0, 80.0))


def test_thinning_keeps_ends_extremes_and_gaps_and_bounds_the_size():
    rng = np.random.default_rng(1)
    time = np.arange(100_000) * 1e-3
    values = rng.standard_normal(len(time))
    values[[4321, 77_777]] = 9.0, -9.0
    values[50_000:60_000] = np.nan
    thin_time, thin = envelope(time, values, bins=500)
    assert len(thin) <= 2 * 500 + 2
    assert (thin_time[0], thin_time[-1]) == (time[0], time[-1])
    assert (thin_time[np.nanargmax(thin)], thin_time[np.nanargmin(thin)]) == (time[4321], time[77_777])
    assert np.all(np.isnan(thin[(thin_time > 50.2) & (thin_time < 59.8)]))
    kept = np.round(thin_time / 1e-3).astype(int)
    assert np.array_equal(thin, values[kept], equal_nan=True)
    short_time, short = envelope(time[:900], values[:900], bins=500)
    assert np.array_equal(short, values[:900]) and np.array_equal(short_time, time[:900])


def test_a_minute_at_a_kilohertz_is_drawn_from_a_few_thousand_points(stroke_run):
    lines = lines_of(measured_and_rendered(stroke_run))
    assert all(len(line.get_xdata()) <= 2 * PIXELS + 2 for line in lines.values())
    assert np.max(lines["measured"].get_ydata()) == np.max(stroke_run["force_y"])


def test_a_spectrum_peaks_at_the_amplitude_of_a_sine():
    time = np.arange(60_000) * 1e-3
    frequency, amplitude = amplitude_spectrum(3.0 + 0.7 * np.sin(2 * np.pi * 2.5 * time), 1e3)
    assert frequency[0] > 0.0
    assert frequency[np.argmax(amplitude)] == pytest.approx(2.5)
    assert np.max(amplitude) == pytest.approx(0.7, rel=1e-6)


def test_windows_are_found_where_their_band_dominates(recording_of):
    time = np.arange(60_000) * 1e-3
    slow = 2.0 * np.sin(2 * np.pi * 0.2 * time)
    fast = np.where((time > 30.0) & (time < 40.0), 2.0, 0.05) * np.sin(2 * np.pi * 5.0 * time)
    slow = np.where((time > 30.0) & (time < 40.0), 0.2, 1.0) * slow
    force = np.column_stack([0 * time, slow + fast, 0 * time])
    run = recording_of(time, force=force, in_contact=np.ones_like(time))
    first, last = dominant_window(run, "3_to_10_hz", 3.0)
    assert 30.0 <= first < last <= 40.0 and last - first == pytest.approx(3.0, abs=2e-3)
    first, last = dominant_window(run, "below_0.3_hz", 8.0)
    assert last < 30.1 or first > 39.9


def test_frozen_parameters_are_told_from_moving_ones(stroke_run):
    assert frozen_since(frozen(stroke_run)) == pytest.approx(5.0, abs=2e-3)
    rng = np.random.default_rng(2)
    moving = {**stroke_run.columns, "theta_m": 1.0 + 1e-6 * rng.standard_normal(len(stroke_run))}
    with pytest.raises(BadInput, match=r"changes up to 59\.999 s, expected parameters that stand still"):
        frozen_since(replace(stroke_run, columns=moving))
    unknown = {**stroke_run.columns, "theta_m": np.full(len(stroke_run), np.nan)}
    with pytest.raises(BadInput, match="no estimate"):
        frozen_since(replace(stroke_run, columns=unknown))


def test_the_timeline_shows_contacts_in_the_operators_time_and_each_lag(stroke_run):
    figure = charts.contact_timeline(stroke_run, delay_s=DELAY_S)
    bars, late = figure.axes
    assert [label.get_text() for label in bars.get_yticklabels()] == ["plant", "rendered"]
    plant = bars.collections[0].get_paths()
    assert plant[0].get_extents().x0 == pytest.approx(-DELAY_S)
    released = stroke_run.time[np.flatnonzero(stroke_run["in_contact"] == 0.0)[0]] - DELAY_S
    assert plant[0].get_extents().x1 == pytest.approx(released, abs=2e-3)
    told = charts.contact_timeline(replace(stroke_run, made_by={"to_telerobot_delay_s": str(DELAY_S)}))
    assert told.axes[0].collections[0].get_paths()[0].get_extents().x0 == pytest.approx(-DELAY_S)
    touches = next(line for line in late.lines if "touch" in line.get_label())
    assert touches.get_ydata() == pytest.approx([800.0] * 4)
    assert "median 800 ms" in touches.get_label()


def test_parameters_are_drawn_beside_their_true_values(stroke_run):
    figure = charts.parameters(stroke_run, truth={"m": 1.0, "k2": 510.0})
    by_name = {axes.get_ylabel(): axes for axes in figure.axes if axes.get_ylabel()}
    assert set(by_name) == {f"{name} [{unit}]" for name, unit in THETA_UNITS.items()}
    k2 = by_name["k2 [N/m]"]
    assert {line.get_label() for line in k2.lines} == {"estimated", "true"}
    assert next(line for line in k2.lines if line.get_label() == "true").get_ydata()[0] == 510.0
    assert k2.get_ylim()[0] < 500.0 and k2.get_ylim()[1] > 510.0
    with pytest.raises(BadInput, match="truth: mass"):
        charts.parameters(stroke_run, truth={"mass": 1.0})


def test_energy_is_drawn_as_computed(stroke_run):
    lines = lines_of(charts.energy(stroke_run))
    assert set(lines) == {"from the hand", "into the environment", "difference", "worst, not passive"}
    assert lines["worst, not passive"].get_ydata()[0] == np.min(lines["from the hand"].get_ydata())


def test_bars_stand_as_high_as_the_errors_in_percent(stroke_run):
    found = measure(stroke_run, delay_s=DELAY_S)
    figure = charts.error_bars({"rendered": found.rendered_error, "estimated": found.estimated_error})
    heights = [[bar.get_height() for bar in group] for group in figure.axes[0].containers]
    assert heights[0] == pytest.approx([100.0 * ratio for ratio in found.rendered_error.tangential.values()])
    assert heights[1] == pytest.approx([2.0] * 4)
    with pytest.raises(BadInput, match="cases"):
        charts.error_bars({})


def test_bars_are_labelled_with_two_digits_and_no_exponent(stroke_run):
    found = measure(stroke_run, delay_s=DELAY_S).rendered_error
    large = replace(found, tangential=dict(zip(found.tangential, (4.4012, 0.0123456, 18.18, None), strict=True)))
    figure = charts.error_bars({"large": large})
    assert {text.get_text() for text in figure.axes[0].texts} == {"440", "1.2", "1800", ""}


def test_drawing_leaves_the_callers_matplotlib_alone(stroke_run):
    with mpl.rc_context({"font.size": 17.0, "axes.grid": False}):
        before = dict(mpl.rcParams)
        figure = measured_and_rendered(stroke_run, window_s=(6.0, 7.0))
        assert dict(mpl.rcParams) == before
        assert figure.axes[0].title.get_fontsize() == 10.0
    assert pyplot.get_fignums() == []


def test_a_figure_is_saved_whole_or_not_at_all(stroke_run, tmp_path):
    figure = measured_and_rendered(stroke_run, window_s=(6.0, 7.0))
    assert save(figure, tmp_path / "new" / "figure.png").read_bytes().startswith(b"\x89PNG")
    assert save(figure, tmp_path / "figure.pdf").read_bytes().startswith(b"%PDF")
    with pytest.raises(BadInput, match="gif"):
        save(figure, tmp_path / "figure.gif")
    (tmp_path / "taken.png").mkdir()
    with pytest.raises(BadInput, match=r"taken\.png"):
        save(figure, tmp_path / "taken.png")
    with pytest.raises(BadInput, match=r"figure\.pdf/below_a_file\.png"):
        save(figure, tmp_path / "figure.pdf" / "below_a_file.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["figure.pdf", "new", "taken.png"]
