"""What is drawn of a diagnosis is what the numbers are, and of what is not there nothing is."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from report_samples import TABLE, diagnosis_of

from mmt_drake.analysis.interactive import THINNED
from mmt_drake.diagnosis.tell import figures, plots
from mmt_drake.diagnosis.tell.evidence import Evidence, Series, Spectrum, worst_windows
from mmt_drake.diagnosis.tell.figures_common import NAMES, binned


def test_the_worst_windows_lie_where_the_error_is_and_in_held_out_blocks_if_these_are_long_enough():
    time = np.arange(0.0, 20.0, 0.01)
    measured, counted = Series("force", "N", np.zeros(len(time))), np.ones(len(time), dtype=bool)
    burst = 0.01 + 1.0 * ((time > 4.0) & (time < 4.5)) + 0.6 * ((time > 12.0) & (time < 13.0))
    free = Evidence("a", "y", time, measured, counted, models={"nominal": 10.0 * np.ones(len(time)), "refit": burst})
    louder, longer = worst_windows(free, count=2, length_s=2.0)
    assert louder[0] <= 4.01 and louder[1] >= 4.49
    assert longer[0] <= 12.01 and longer[1] >= 12.99
    held = replace(free, heldout_s=((10.0, 14.0),))
    assert all(start >= 10.0 and end <= 14.0 + 1e-9 for start, end in worst_windows(held, 5, 2.0))
    unseen = replace(free, counted=(time > 6.0))
    assert worst_windows(unseen, 1, 2.0)[0][0] == pytest.approx(12.0, abs=1.1)


def test_no_window_is_worst_where_no_model_is_off():
    time = np.arange(0.0, 5.0, 0.01)
    right = Evidence("a", "", time, Series("x", "m", time), np.ones(len(time), dtype=bool), models={"nominal": time})
    assert worst_windows(right) == plots.closer(right) == []


def test_binned_medians_are_the_quantiles_of_a_known_law():
    over = np.repeat(np.linspace(-1.0, 1.0, 2001), 11)
    values = 0.3 * over + np.tile(np.linspace(-0.5, 0.5, 11), 2001)
    centre, low, median, high = binned(over, values)
    np.testing.assert_allclose(median, 0.3 * centre, atol=0.01)
    np.testing.assert_allclose(high - median, 0.4, atol=0.01)
    np.testing.assert_allclose(median - low, 0.4, atol=0.01)


def test_drawn_errors_are_measured_minus_simulated_where_samples_count(evidence):
    _, nominal, refit, augmented, enlarged = figures.overview(evidence).axes
    for panel, name in ((nominal, "nominal"), (refit, "refit"), (augmented, "augmented"), (enlarged, "augmented")):
        drawn = panel.get_lines()[0]
        at = np.searchsorted(evidence.time, np.asarray(drawn.get_xdata()))
        expected = np.where(evidence.counted, evidence.residuals[name], np.nan)[at]
        np.testing.assert_array_equal(np.asarray(drawn.get_ydata()), expected)
        assert np.nanmax(drawn.get_ydata()) == evidence.residuals[name][evidence.counted].max()
    assert nominal.get_ylim() == refit.get_ylim() == augmented.get_ylim()


def traces(plot, name: str) -> list:
    return [trace for trace in plot.figure.data if trace.name == name and trace.x[0] is not None]


def test_measured_samples_are_points_and_models_are_lines(evidence):
    plot = plots.over_time(evidence)
    (measured,) = traces(plot, "measured")
    assert measured.mode == "markers" and measured.marker.size >= 4
    assert plot.figure.data[0] is measured  # below the lines, but wider than these
    for name in evidence.models:
        top, error = traces(plot, NAMES[name])
        assert top.mode == error.mode == "lines" and top.line.width < measured.marker.size
        assert error.showlegend is False


def test_long_curves_are_thinned_and_keep_their_peaks(evidence):
    plot = plots.over_time(evidence)
    for trace in plot.figure.data:
        assert len(trace.x) <= THINNED
    (measured,) = traces(plot, "measured")
    assert len(evidence.time) > THINNED
    assert (measured.y.min(), measured.y.max()) == (
        np.float32(evidence.measured.values.min()),
        np.float32(evidence.measured.values.max()),
    )


def test_a_value_that_is_pointed_at_is_told_with_its_units(evidence):
    (measured,) = traces(plots.over_time(evidence), "measured")
    assert measured.hovertemplate == "%{fullData.name}<br>%{x:.4g} s<br>%{y:.3g} N<extra></extra>"


def test_where_it_is_furthest_off_every_sample_is_drawn(evidence):
    (plot,) = plots.closer(evidence)
    for window, trace in zip(sorted(worst_windows(evidence)), traces(plot, "measured"), strict=True):
        inside = (evidence.time >= window[0]) & (evidence.time <= window[1])
        assert len(trace.x) == min(np.count_nonzero(inside), THINNED)


def test_a_spectrum_keeps_its_level_when_it_is_averaged_for_drawing(evidence):
    flat = Spectrum(np.arange(0.0, 250.0, 0.1), {"nominal": np.full(2500, 3e-4)})
    (plot,) = plots.spectrum(replace(evidence, spectrum=flat))
    (trace,) = plot.figure.data
    np.testing.assert_allclose(trace.y, 3e-4, rtol=1e-6)


def test_the_picture_beside_the_report_touches_no_global_state(evidence):
    before = mpl.rcParams.copy()
    assert type(figures.overview(evidence)) is Figure
    assert mpl.rcParams == before
    assert not mpl._pylab_helpers.Gcf.figs  # what pyplot would keep


def test_of_what_is_not_there_no_picture_is_drawn(evidence):
    bare = Evidence("a", "y", evidence.time, evidence.measured, evidence.counted)
    for draw in (plots.closer, plots.spectrum, plots.error_over_states, plots.forces):
        assert draw(bare) == []
    assert plots.learned_law(diagnosis_of("missing_physics").effects[0]) == []


def test_a_recording_alone_can_be_looked_at(evidence):
    bare = Evidence("a", "", evidence.time, evidence.measured, evidence.counted)
    (panel,) = figures.overview(bare).axes
    assert panel.get_title(loc="left") == "a"
    assert [trace.name for trace in plots.over_time(bare).figure.data] == ["measured"]


def test_a_learned_law_is_drawn_over_its_signal_with_its_interval(evidence):
    (plot,) = plots.learned_law(TABLE)
    (learned,) = traces(plot, "learned")
    assert plot.figure.layout.xaxis.title.text.startswith("sliding velocity [")
    np.testing.assert_allclose(learned.y, np.float32(TABLE.parameters["value"].value))


@pytest.mark.parametrize("draw", [plots.error_over_states, plots.forces])
def test_small_figures_stand_side_by_side_with_labels_and_units(evidence, draw):
    found = draw(evidence)
    assert len(found) > 1
    for plot in found:
        assert plot.half and plot.title
        for axis in (plot.figure.layout.xaxis, plot.figure.layout.yaxis):
            assert axis.title.text.endswith("]")
