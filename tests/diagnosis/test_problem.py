"""What is fitted: noise counted as theory counts it, floors that the exact model reaches, blocks that never mix."""

import math
from dataclasses import replace

import numpy as np
import pytest
from trial_samples import SPRING, changed, model, problem_of, recorded, spring

from mmt_drake.diagnosis.fit.box_tracks import BoxTrack
from mmt_drake.diagnosis.fit.floors import weighed, with_floors
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import BLOCK_S, Problem, share, split
from mmt_drake.diagnosis.signals.smoother import smooth
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model.kelvin_voigt import KelvinVoigt

EXACT = model()


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Two recordings of the object, one of them with two axes that move."""
    return problem_of([recorded(seed=0), recorded(seed=1)], EXACT)


def measuring(track, values, floor):
    """The track with another measured output (n,) and floor."""
    output = track.smoothed.output.copy()
    output[:, track.column] = values
    return replace(track, smoothed=replace(track.smoothed, output=output), floor=floor)


def alone(problem):
    """A problem of each recording."""
    return [replace(problem, tracks=tracks) for tracks in problem.by_recording()]


def with_noise(track, generator, level):
    """The track as the model itself would have been measured, with white noise of a deviation on the sensor's clock."""
    s = track.smoothed
    white = level * generator.standard_normal(len(s.time) * s.every)
    noise = s.low_pass.apply(white, s.clock.rate_hz, s.every)[: len(s.time)]
    gain = s.low_pass.white_noise_gain(s.clock.rate_hz)
    return measuring(track, track.simulated(EXACT, coarse=1.0) + noise, level * gain)


# noise


def test_of_pure_noise_the_ratio_is_1_and_the_samples_say_how_much_it_scatters(problem):
    generator = np.random.default_rng(0)
    track = problem.tracks[0]
    simulated = track.simulated(EXACT, coarse=1.0)
    made = [with_noise(track, generator, 0.02) for _ in range(300)]
    squares = {False: [], True: []}
    for noisy in made:
        error = (noisy.measured - simulated) / noisy.floor
        for heldout, found in squares.items():
            chosen = (track.heldout == heldout) & (track.weight > 0.0)
            found.append(np.mean(error[chosen] ** 2))
    for heldout, found in squares.items():
        assert math.sqrt(np.mean(found)) == pytest.approx(1.0, rel=0.03)
        # The mean square of n independent normal numbers scatters by sqrt(2/n).
        samples = Problem((track,)).samples(heldout=heldout)
        assert samples == pytest.approx(2.0 / np.var(found), rel=0.3)
    one = Problem((made[0],))
    assert one.ratio(EXACT) == pytest.approx(math.sqrt(squares[False][0]), rel=1e-9)
    assert one.ratio(EXACT, heldout=True) == pytest.approx(math.sqrt(squares[True][0]), rel=1e-9)


def test_the_share_of_independent_samples_is_that_of_an_ideal_filter_of_the_same_width(problem):
    # White noise in a band B has 2 B independent samples per second; the filter's skirt reaches from B to 2 B.
    for track in problem.tracks:
        s = track.smoothed
        per_second = share(s) * s.rate_hz
        assert 2.0 * s.low_pass.band_hz < per_second < 4.0 * s.low_pass.band_hz
    assert share(smooth(recorded(), band_hz=math.inf)) == 1.0


def test_the_residual_of_the_exact_model_is_the_noise_that_the_floor_says(problem):
    # The recordings come from another engine, with noise on force, position and velocity.
    problems = [problem] + [problem_of(recorded(seed=seed), EXACT) for seed in (2, 3, 4, 5)]
    for heldout in (False, True):
        squares = sum(p.ratio(EXACT, heldout=heldout) ** 2 * p.samples(heldout=heldout) for p in problems)
        samples = sum(p.samples(heldout=heldout) for p in problems)
        three_sigma = 3.0 / math.sqrt(2.0 * samples)
        assert math.sqrt(squares / samples) == pytest.approx(1.0, abs=three_sigma + 0.06)
    assert problem.ratios(problem.residual(model(k2=500.0)))["y"] > 5.0


def test_noise_of_the_input_raises_the_floor_by_what_it_does_to_the_force(problem):
    for track in (with_floors([track], EXACT)[0] for track in problem.tracks):
        s, own = track.smoothed, track.smoothed.output_noise[track.column]
        through = math.sqrt(track.floor**2 - own**2)
        # Nearly all of it is the rate's noise through the contact damper, and the body does not follow that fast.
        touching = math.sqrt(np.mean(s.in_contact[track.weight > 0.0]))
        position, rate = s.input_noise[track.column], s.input_rate_noise[track.column]
        expected = EXACT.parameters.b2 * rate
        if track.axis == "z":
            expected = math.hypot(EXACT.normal.b * rate, EXACT.normal.k * position)
        assert through == pytest.approx(touching * expected, rel=0.35)
        silent = replace(s, input_rate_noise=np.zeros(3), input_noise=np.zeros(3))
        (quiet,) = with_floors([replace(track, smoothed=silent)], EXACT)
        assert quiet.floor == pytest.approx(own, rel=1e-12)
        louder = replace(s, input_rate_noise=3.0 * s.input_rate_noise, input_noise=3.0 * s.input_noise)
        (loud,) = with_floors([replace(track, smoothed=louder)], EXACT)
        assert math.sqrt(loud.floor**2 - own**2) == pytest.approx(3.0 * through, rel=0.15)


def test_recordings_count_by_what_a_fit_leaves_of_each_and_as_they_did_where_that_is_noise(problem):
    plain = Hypothesis.of(EXACT, 0.0)
    right = problem.unchanged(plain, plain.base())
    first, *others = problem.by_recording()
    quiet = replace(problem, tracks=(*first, *(replace(t, floor=0.1 * t.floor) for tracks in others for t in tracks)))
    found = weighed(quiet, right)
    assert found.tracks[-1].counts / found.tracks[0].counts == pytest.approx(0.1, rel=0.1)
    assert sum(p.samples() * p.tracks[0].counts ** 2 for p in alone(found)) == pytest.approx(quiet.samples())
    assert [t.counts for t in weighed(problem, right).tracks] == pytest.approx([1.0] * len(problem.tracks), rel=0.05)
    assert weighed(replace(problem, tracks=first), right).tracks == first, "one recording"


def test_what_disturbs_one_recording_spoils_a_fit_less_where_they_count_by_what_is_left():
    clean, other = spring(seed=1), spring(seed=2)
    walk = np.cumsum(np.random.default_rng(0).standard_normal(len(other)))
    disturbed = changed(other, force=other["force"] + 0.3 * np.std(other["force"]) * walk / np.std(walk))
    plain = Hypothesis.of(KelvinVoigt(k=450.0, b=22.0, x0=SPRING["x0"]), 0.0)
    problem = problem_of([clean, disturbed], plain.nominal)
    first = problem.fit(plain, plain.base())
    again = weighed(problem, first).fit(plain, first.x)
    off, off_again = (abs(fitted.structure_values["k"] / SPRING["k"] - 1.0) for fitted in (first, again))
    assert off_again < 0.3 * off


def test_an_error_beyond_what_was_measured_takes_no_more_weight_from_a_recording(problem):
    first, *others = problem.by_recording()
    slow = replace(problem, tracks=(*first, *(measuring(t, 1e-3 * t.measured, t.floor) for ts in others for t in ts)))
    plain = Hypothesis.of(EXACT, 0.0)
    found = weighed(slow, slow.unchanged(plain, plain.base()))
    assert alone(found)[1].ratio(EXACT) > 100.0, "a model that is a thousand times too stiff for it"
    assert found.tracks[-1].counts > 0.5


# blocks


def test_of_twelve_blocks_of_equal_count_every_third_is_held_out():
    s = smooth(recorded())
    told = split(s)[(s.weight > 0.0) & s.in_contact].astype(int)
    lengths = np.diff([0, *np.flatnonzero(np.diff(told)) + 1, len(told)])
    assert told[0] == 0 and lengths == pytest.approx(np.tile([2, 1], 4) * len(told) / 12, abs=1.0)


def test_what_is_fitted_and_what_is_held_out_never_mix(problem):
    for track in problem.tracks:
        one = Problem((track,))
        counts = [len(one.residual(EXACT, heldout=heldout)) for heldout in (False, True)]
        assert sum(counts) == np.count_nonzero(track.weight > 0.0)
        spoilt = Problem((measuring(track, track.measured + 9.0 * track.heldout, track.floor),))
        np.testing.assert_array_equal(spoilt.residual(EXACT), one.residual(EXACT))
        assert spoilt.ratio(EXACT, heldout=True) > 100.0
        hypothesis = Hypothesis(EXACT)
        fits = [p.fit(hypothesis, hypothesis.base(), steps=2) for p in (one, spoilt)]
        np.testing.assert_array_equal(fits[0].x, fits[1].x)
        assert spoilt.samples() == one.samples() and spoilt.samples(heldout=True) == one.samples(heldout=True)


def test_samples_where_nothing_can_be_compared_count_nowhere(problem):
    track = problem.tracks[0]
    assert 0.1 < np.mean(track.weight > 0.0) < 1.0
    near_touch = np.abs(track.time[:, None] - track.smoothed.contact.changes).min(axis=1) < 0.01
    assert near_touch.any() and not track.weight[near_touch].any()
    spoilt = Problem((measuring(track, track.measured + 9.0 * (track.weight == 0.0), track.floor),))
    for heldout in (False, True):
        assert spoilt.ratio(EXACT, heldout=heldout) == Problem((track,)).ratio(EXACT, heldout=heldout)


def test_blocks_of_errors_are_stretches_of_time_of_one_track_each(problem):
    for heldout in (False, True):
        numbers = problem.blocks(heldout=heldout)
        assert len(numbers) == len(problem.residual(EXACT, heldout=heldout))
        at = 0
        owners = {}
        for i, track in enumerate(problem.tracks):
            time = track.time[(track.heldout == heldout) & (track.weight > 0.0)]
            own = numbers[at : at + len(time)]
            at += len(time)
            for number in np.unique(own):
                assert owners.setdefault(number, i) == i
                assert np.ptp(time[own == number]) < BLOCK_S
            assert np.all(np.diff(own) >= 0)


# fits


def test_a_fit_finds_wrong_parameters_and_reaches_the_noise(problem):
    wrong = model(m=0.6, k2=400.0, b1=25.0, b2=20.0)
    hypothesis = Hypothesis(wrong, skew=1e-3)
    fitted = problem.fit(hypothesis, hypothesis.base())
    truth = hypothesis.vector({symbol: EXACT.parameter(symbol) for symbol in hypothesis.free}, {})
    normal = fitted.minimum.jacobian.T @ fitted.minimum.jacobian
    standard_error = np.sqrt(np.diag(np.linalg.inv(normal)))
    # Noise that comes in by the motion is coloured, so plain standard errors are about half of what they should be.
    assert np.all(np.abs(fitted.x - truth) < 8.0 * standard_error)
    assert np.all(standard_error[:-1] < 0.03 * truth[:-1])
    assert fitted.cost == pytest.approx(np.sum(fitted.minimum.residual**2))
    assert problem.ratio(wrong) > 10.0
    assert problem.ratio(fitted.model, fitted.skew) < 1.15
    assert problem.ratio(fitted.model, fitted.skew, heldout=True) < 1.2


def test_an_offset_between_the_clocks_is_found_and_not_taken_for_physics(problem):
    late = []
    for track in problem.tracks:
        values = track.simulated(EXACT, skew=4e-4)
        late.append(measuring(track, values, track.floor))
    shifted = Problem(tuple(late), coarse=problem.coarse)
    hypothesis = Hypothesis(EXACT, skew=1e-3)
    assert shifted.ratios(shifted.residual(EXACT))["y"] > 1.0
    alone = shifted.skew_alone(hypothesis, hypothesis.base())
    np.testing.assert_array_equal(alone[:-1], hypothesis.base()[:-1])
    assert alone[-1] == pytest.approx(4e-4, rel=0.02)
    fitted = shifted.fit(hypothesis, hypothesis.base())
    assert fitted.skew == pytest.approx(4e-4, rel=0.15)
    assert hypothesis.structure_values(fitted.x) == pytest.approx(
        hypothesis.structure_values(hypothesis.base()), rel=0.01
    )


def test_what_a_fit_cannot_start_from_stays_where_it_is(problem):
    hypothesis = Hypothesis(EXACT)
    x = hypothesis.base() * 1.05
    there = problem.at(hypothesis, x)
    np.testing.assert_array_equal(there.x, x)
    np.testing.assert_array_equal(there.minimum.residual, problem.objective(hypothesis.model(x), 0.0))
    step = 1e-5 * x
    for j in range(len(x)):
        moved = [x + sign * step * (np.arange(len(x)) == j) for sign in (1.0, -1.0)]
        high, low = (problem.objective(hypothesis.model(m), 0.0) for m in moved)
        slope = (high - low) / (2.0 * step[j])
        np.testing.assert_allclose(there.minimum.jacobian[:, j], slope, atol=0.01 * np.abs(slope).max())


def test_a_model_of_another_structure_is_refused(problem):
    with pytest.raises(BadInput, match="found a kelvin_voigt model, expected flexible_box"):
        problem.residual(KelvinVoigt(k=1.0))


def test_numbers_too_absurd_to_integrate_are_a_simulation_that_fails_as_any_other(problem):
    hypothesis = Hypothesis(EXACT).adding(LIBRARY["hysteresis"])
    x = hypothesis.vector({}, {"hysteresis": {"alpha": 1.0, "beta": 1e12}})
    with pytest.raises(MmtError, match="decays more than 50 times within one step"):
        problem.residual(hypothesis.model(x))


def test_signals_of_a_replay_are_those_of_the_recording(problem):
    track = problem.tracks[0]
    assert isinstance(track, BoxTrack) and track.axis == "y"
    force, states = track.replay(EXACT, coarse=1.0)
    touch = track.smoothed.in_contact
    p = EXACT.parameters
    # In contact the force is that of spring and damper: the signals that a missing force may depend on are true.
    rebuilt = -(p.k2 * states["deflection"] + p.b2 * states["deflection_rate"])
    inside = touch & (track.weight > 0.0)
    np.testing.assert_allclose(force[inside], rebuilt[inside], atol=0.02 * force.std())
    assert np.all(states["load"][~touch] == 0.0) and states["load"][touch].mean() > 1.0
    moved = np.diff(states["position"]) / np.diff(track.time)
    middle = 0.5 * (states["sliding_velocity"][1:] + states["sliding_velocity"][:-1])
    np.testing.assert_allclose(moved, middle, atol=0.03 * middle.std())
