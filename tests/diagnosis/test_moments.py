"""A moment is found wherever it is, and a stretch that nothing was fitted to is not held against what begins in it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from trial_samples import model, problem_of, recorded

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.event_times import at_best_times, released
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Problem
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.effects import LIBRARY

EXACT = model()
CHANGED = Hypothesis(EXACT).adding(LIBRARY["mass_change"])


def with_change(time: float, dm: float = 0.25):
    return recorded(("mass_change", (("time", time), ("dm", dm))), seed=3)


def numbers(time: float, dm: float = 0.25):
    return CHANGED.vector({}, {"mass_change": {"time": time, "dm": dm}})


def stretches(problem: Problem, *, heldout: bool) -> list[tuple[float, float]]:
    """(from, to) [s] of the stretches that are held out, or that are not."""
    track = problem.tracks[0]
    edges = [0, *np.flatnonzero(np.diff(track.heldout)) + 1, len(track.time)]
    pairs = [(a, b) for a, b in pairwise(edges) if track.heldout[a] == heldout]
    return [(float(track.time[a]), float(track.time[b - 1])) for a, b in pairs]


@pytest.fixture(scope="module")
def exact() -> Problem:
    return problem_of(recorded(seed=3), EXACT)


@pytest.fixture(scope="module")
def hidden(exact) -> float:
    """The middle of a stretch that is held out."""
    start, end = stretches(exact, heldout=True)[1]
    return 0.5 * (start + end)


def test_a_moment_is_found_from_the_other_end_of_the_recording(exact):
    start, end = stretches(exact, heldout=False)[1]
    true = 0.5 * (start + end)
    problem = problem_of(with_change(true), EXACT)
    for wrong in (start - 2.0, end + 2.0):
        x = at_best_times(problem, CHANGED, numbers(wrong))
        # Where the hand rests, one moment is as good as another.
        assert problem.unchanged(CHANGED, x).cost <= 1.01 * problem.unchanged(CHANGED, numbers(true)).cost
        assert abs(x[-2] - true) < 1.0
        others = np.delete(x, -2), np.delete(numbers(wrong), -2)
        np.testing.assert_array_equal(*others)


def test_without_event_times_nothing_is_sought_and_nothing_released(exact):
    plain = Hypothesis(EXACT)
    x = plain.base()
    assert at_best_times(exact, plain, x) is x
    assert released(exact, [exact.unchanged(plain, x)]) is exact


def test_the_stretch_around_a_moment_is_released_and_no_other(exact, hidden):
    freed = released(exact, [exact.unchanged(CHANGED, numbers(hidden))])
    before, after = (set(stretches(p, heldout=True)) for p in (exact, freed))
    (gone,) = before - after
    assert gone[0] < hidden < gone[1] and after < before
    fitted = stretches(exact, heldout=False)[1]
    assert released(exact, [exact.unchanged(CHANGED, numbers(sum(fitted) / 2.0))]) is exact


def test_a_stretch_in_which_the_moment_may_as_well_be_is_released_too(exact):
    start, end = stretches(exact, heldout=True)[1]
    changed = problem_of(with_change(0.5 * (start + end)), EXACT)
    just_before = changed.unchanged(CHANGED, numbers(start - 1e-3))
    far_before = changed.unchanged(CHANGED, numbers(start - 0.5))
    assert just_before.cost < far_before.cost - 100.0
    assert (start, end) not in stretches(released(changed, [just_before]), heldout=True)
    assert released(changed, [far_before]) is changed


def test_the_last_stretch_is_never_released(exact, hidden):
    track = exact.tracks[0]
    inside = np.zeros_like(track.heldout)
    start, end = stretches(exact, heldout=True)[1]
    inside[(track.time >= start) & (track.time <= end)] = True
    alone = replace(exact, tracks=tuple(replace(t, heldout=inside) for t in exact.tracks))
    assert released(alone, [alone.unchanged(CHANGED, numbers(hidden))]) is alone


def test_what_happens_in_a_held_out_stretch_is_named_with_its_moment(hidden):
    library = [LIBRARY[name] for name in ("mass_change", "coulomb_friction")]
    said = diagnose([with_change(hidden)], EXACT, library=library).diagnosis
    assert said.verdict == "missing_physics" and [e.name for e in said.effects] == ["mass_change"]
    values = said.effects[0].parameters
    assert values["time"].value == pytest.approx(hidden, abs=0.1)
    assert values["dm"].value == pytest.approx(0.25, rel=0.03)
    # The figures are of what was still held out.
    assert said.fit is not None and not any(a < hidden < b for a, b in said.fit.heldout_s) and said.fit.heldout_s


def test_a_moment_between_two_touches_is_known_to_them_and_no_better(exact):
    """Nothing shows in between: the cost is flat there, and its slope says nothing of how far."""
    track = exact.tracks[0]
    away = np.flatnonzero(np.diff(np.concatenate([[1], track.smoothed.in_contact.astype(int), [1]])))
    pauses = [(float(track.time[a]), float(track.time[b - 1])) for a, b in away.reshape(-1, 2)]
    start, end = max(pauses, key=lambda pause: pause[1] - pause[0])
    assert end - start > 0.2
    problem = problem_of(with_change(0.5 * (start + end)), EXACT)
    fitted = problem.fit(CHANGED, numbers(0.5 * (start + end)))
    (low, high), _ = intervals(problem, fitted)[-2:]
    assert start - 0.5 < low < start + 0.05 and end - 0.05 < high < end + 0.5
