"""From recordings to a problem: the normal axis where its sensor fails, and which of several recordings is meant."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_samples import MODEL, NORMAL_B, NORMAL_K
from trial_samples import changed, cut

from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.model.parameters import NORMAL
from mmt_drake.recording import Recording


def normal_fit(recording):
    """k and b of the normal axis, their intervals, and what the fit leaves along it over the noise."""
    problem = prepare([recording], MODEL).problem
    problem = replace(problem, tracks=tuple(track for track in problem.tracks if isinstance(track, NormalTrack)))
    hypothesis = Hypothesis(MODEL)
    fitted = problem.fit(hypothesis, hypothesis.base())
    names = [parameter.symbol for parameter in hypothesis.free_parameters()]
    ci = intervals(problem, fitted)
    return [(fitted.x[i], ci[i]) for i in map(names.index, NORMAL)], problem.left(fitted)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6])
def test_the_normal_axis_is_right_whatever_share_of_its_force_is_clipped(strokes, share):
    limit = np.quantile(strokes["force_z"][strokes["in_contact"] > 0.0], 1.0 - share)
    clipped = changed(strokes, force_z=np.minimum(strokes["force_z"], limit))
    ((k, k_ci), (b, b_ci)), left = normal_fit(clipped)
    assert k == pytest.approx(NORMAL_K, rel=3e-3) and b == pytest.approx(NORMAL_B, rel=0.03)
    assert k_ci[0] < NORMAL_K < k_ci[1] and b_ci[0] < NORMAL_B < b_ci[1]
    assert left < 1.5


def test_of_a_normal_force_that_is_always_at_its_limit_or_dead_nothing_is_said(strokes):
    for force in (np.minimum(strokes["force_z"], 0.3), np.zeros(len(strokes))):
        problem = prepare([changed(strokes, force_z=force)], MODEL).problem
        assert [track.axis for track in problem.tracks] == ["y"] and set(NORMAL) <= set(problem.unseen)


def test_a_normal_force_that_is_not_clipped_counts_everywhere(strokes):
    for track in prepare([strokes], MODEL).problem.tracks:
        assert np.isfinite(track.smoothed.output).all()


def short(recording: Recording, source: str) -> Recording:
    return replace(cut(recording, (recording.time > 2.0) & (recording.time < 2.5)), source=source)


def test_of_several_recordings_every_finding_says_which_is_meant(strokes):
    biased = changed(strokes, force_y=strokes["force_y"] + 0.25)
    found = prepare([replace(strokes, source="first.csv"), replace(biased, source="second.csv")], MODEL)
    assert found.reason is None
    warnings = [finding.text for finding in found.findings if finding.severity == "warn"]
    assert len(warnings) == 1 and warnings[0].startswith("second.csv: In free space")
    assert all(finding.text.startswith(("first.csv: ", "second.csv: ")) for finding in found.findings)


def test_what_is_too_short_is_left_out_and_told_where_others_are_not(strokes):
    good = replace(strokes, source="good.csv")
    alone, beside = prepare([good], MODEL), prepare([short(strokes, "short.csv"), good], MODEL)
    assert [recording.source for recording in beside.recordings] == ["good.csv"]
    assert beside.problem.samples() == alone.problem.samples()
    (told,) = [f.text for f in beside.findings if not f.text.startswith("good.csv: ")]
    assert beside.reason is None and told.startswith("short.csv is left out: Too short: 0.5")


def test_a_refusal_says_which_of_several_recordings_is_meant(strokes):
    still = changed(strokes, position_x=0.0 * strokes.time, position_y=0.0 * strokes.time)
    reason = prepare([replace(strokes, source="good.csv"), replace(still, source="still.csv")], MODEL).reason
    assert reason.startswith("still.csv: Nothing moves") and "good.csv" not in reason
    both = prepare([short(strokes, "one.csv"), short(strokes, "other.csv")], MODEL).reason
    assert "one.csv: Too short" in both and "other.csv: Too short" in both
    assert prepare([short(strokes, "short.csv")], MODEL).reason.startswith("Too short")
