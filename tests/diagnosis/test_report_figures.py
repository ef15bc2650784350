"""What is drawn of a diagnosis is what the numbers are, and of what is not there nothing is."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from report_samples import TABLE, diagnosis_of

from mmt_drake.diagnosis.tell import figures, figures_summary
from mmt_drake.diagnosis.tell.evidence import Evidence, Series, Spectrum
from mmt_drake.diagnosis.tell.figures_common import binned
from mmt_drake.diagnosis.tell.result import Fit, HeldoutNrmse


def test_the_worst_windows_lie_where_the_error_is_and_in_held_out_blocks_if_these_are_long_enough():
    time = np.arange(0.0, 20.0, 0.01)
    measured, counted = Series("force", "N", np.zeros(len(time))), np.ones(len(time), dtype=bool)
    burst = 0.01 + 1.0 * ((time > 4.0) & (time < 4.5)) + 0.6 * ((time > 12.0) & (time < 13.0))
    free = Evidence("a", "y", time, measured, counted, models={"nominal": 10.0 * np.ones(len(time)), "refit": burst})
    louder, longer = figures.worst_windows(free, count=2, length_s=2.0)
    assert louder[0] <= 4.01 and louder[1] >= 4.49
    assert longer[0] <= 12.01 and longer[1] >= 12.99
    held = replace(free, heldout_s=((10.0, 14.0),))
    assert all(start >= 10.0 and end <= 14.0 + 1e-9 for start, end in figures.worst_windows(held, 5, 2.0))
    unseen = replace(free, counted=(time > 6.0))
    assert figures.worst_windows(unseen, 1, 2.0)[0][0] == pytest.approx(12.0, abs=1.1)


def test_no_window_is_worst_where_no_model_is_off():
    time = np.arange(0.0, 5.0, 0.01)
    right = Evidence("a", "", time, Series("x", "m", time), np.ones(len(time), dtype=bool), models={"nominal": time})
    assert figures.worst_windows(right) == []
    assert figures.zooms(right) is None


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


def test_a_spectrum_keeps_its_level_when_it_is_averaged_for_drawing(evidence):
    flat = Spectrum(np.arange(0.0, 250.0, 0.1), {"nominal": np.full(2500, 3e-4)})
    (panel,) = figures.spectra(replace(evidence, spectrum=flat)).axes
    np.testing.assert_allclose(panel.get_lines()[0].get_ydata(), 3e-4)


def test_figures_touch_no_global_state(evidence):
    before = mpl.rcParams.copy()
    found = diagnosis_of("missing_physics")
    drawn = [
        figures.overview(evidence),
        figures.zooms(evidence),
        figures.residual_over_states(evidence),
        figures.curves(evidence),
        figures.spectra(evidence, (0.1, 3.0)),
        figures_summary.heldout_errors(found.fit),
        figures_summary.budget(found.budget),
        figures_summary.where(found.mismatch),
        figures_summary.rivals(found),
        figures_summary.parameters(found),
        figures_summary.learned_law(TABLE),
    ]
    assert all(type(figure) is Figure for figure in drawn)
    assert mpl.rcParams == before
    assert not mpl._pylab_helpers.Gcf.figs  # what pyplot would keep


def test_of_what_is_not_there_no_picture_is_drawn(evidence):
    bare = Evidence("a", "y", evidence.time, evidence.measured, evidence.counted)
    for draw in (figures.zooms, figures.residual_over_states, figures.curves, figures.spectra):
        assert draw(bare) is None
    nothing = diagnosis_of("insufficient_data")
    assert figures_summary.rivals(nothing) is None and figures_summary.parameters(nothing) is None
    assert figures_summary.budget(nothing.budget) is None and figures_summary.where(nothing.mismatch) is None
    assert figures_summary.heldout_errors(Fit((), (), None, HeldoutNrmse(None, None, None))) is None
    assert figures_summary.learned_law(diagnosis_of("missing_physics").effects[0]) is None


def test_a_recording_alone_can_be_looked_at(evidence):
    bare = Evidence("a", "", evidence.time, evidence.measured, evidence.counted)
    (panel,) = figures.overview(bare).axes
    assert panel.get_title(loc="left") == "a"


def test_a_budget_is_drawn_part_by_part_without_what_is_nothing():
    (panel,) = figures_summary.budget(diagnosis_of("missing_physics").budget).axes
    told = ["wrong parameters", "static friction", "what nobody has named", "noise"]
    assert [label.get_text() for label in panel.get_yticklabels()] == told
    assert [bar.get_width() for bar in panel.patches] == [0.31, 0.55, 0.11, 0.03]
