"""The smoother: exact filters, noise as theory says, one clock, touches finer than a sample."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_samples import (
    FORCE_NOISE,
    POSITION_NOISE,
    RELEASES,
    TOP_HZ,
    TOUCHES,
    VELOCITY_NOISE,
    Strokes,
    contact_recording,
    driven_recording,
)
from scipy.integrate import quad
from trial_samples import changed, cut

from mmt_drake.diagnosis.signals.band import rate_noise, top_excitation
from mmt_drake.diagnosis.signals.clocks import clock_of, on_clock
from mmt_drake.diagnosis.signals.fusion import fusion
from mmt_drake.diagnosis.signals.noise import WHITE_DB
from mmt_drake.diagnosis.signals.smoother import noise_floor, smooth
from mmt_drake.diagnosis.signals.touches import ContactTimes
from mmt_drake.errors import BadInput
from mmt_drake.numeric.zero_phase import LowPass
from mmt_drake.recording import Recording


def test_the_filter_multiplies_a_sine_by_its_gain_and_shifts_nothing():
    low_pass, rate = LowPass(16.0), 1000.0
    t = np.arange(4000) / rate
    for frequency in (1.0, 9.7, 15.9, 22.0, 31.0):
        wave = np.sin(2 * np.pi * frequency * t + 0.4)
        gain = low_pass.gain(np.array([frequency]), rate)[0]
        np.testing.assert_allclose(low_pass.apply(wave, rate)[200:-200], gain * wave[200:-200], atol=1e-12)


def test_the_filter_passes_its_band_and_stops_from_twice_the_band_on():
    low_pass = LowPass(16.0)
    for rate in (1000.0, 250.0):
        assert np.abs(low_pass.gain(np.linspace(0.0, 16.0, 200), rate) - 1.0).max() < 2e-4
        assert np.abs(low_pass.gain(np.linspace(32.0, rate / 2.0, 500), rate)).max() < 2e-4


def test_a_force_filtered_fast_and_one_filtered_slowly_agree():
    low_pass = LowPass(16.0)
    fast = np.arange(5001) / 1000.0
    pulse = np.exp(-0.5 * ((fast - 2.5) / 0.02) ** 2)  # half its height at 9.4 Hz
    filtered = low_pass.apply(pulse, 1000.0, every=4)
    np.testing.assert_allclose(low_pass.apply(pulse[::4], 250.0), filtered, atol=2e-5)
    assert np.abs(filtered - pulse[::4]).max() > 1e-3  # it does filter


def test_a_filter_that_the_clock_cannot_carry_is_refused():
    with pytest.raises(BadInput, match=r"low-pass: found 50 samples/s, expected at least 64"):
        LowPass(16.0).kernel(50.0)
    with pytest.raises(BadInput, match="band_hz"):
        LowPass(0.0)
    with pytest.raises(BadInput, match="expected more than 156"):
        LowPass(16.0).apply(np.zeros(100), 1000.0)


@pytest.mark.parametrize("crossover", [50.0, np.inf])
def test_a_steady_motion_stays_as_it_is(crossover):
    filters = fusion(LowPass(16.0), 1000.0, crossover)
    t = (np.arange(len(filters.position_from_p)) - filters.reach) / 1000.0
    from_u = [0.0 if taps is None else taps.sum() for taps in (filters.position_from_u, filters.velocity_from_u)]
    assert filters.position_from_p.sum() == pytest.approx(1.0, abs=1e-12)
    assert filters.velocity_from_p.sum() == pytest.approx(0.0, abs=1e-9)
    assert -(filters.velocity_from_p @ t) + from_u[1] == pytest.approx(1.0, abs=1e-9)
    assert from_u[0] == pytest.approx(0.0, abs=1e-9)


def test_rate_noise_is_the_integral_of_the_best_weights():
    sp, su, band = 2e-13, 5e-10, 21.0
    density = quad(lambda f: 1.0 / (1.0 / (sp * (2 * np.pi * f) ** 2) + 1.0 / su), 0.0, band)[0]
    assert rate_noise(sp, su, band) == pytest.approx(np.sqrt(density), rel=1e-9)
    density = quad(lambda f: sp * (2 * np.pi * f) ** 2, 0.0, band)[0]
    assert rate_noise(sp, np.inf, band) == pytest.approx(np.sqrt(density), rel=1e-9)


@pytest.mark.parametrize("velocity", [True, False])
def test_velocity_noise_falls_by_the_factor_that_theory_says(velocity):
    """Of a steady slide nothing is left but the noise; the transition band adds to that of the ideal filter."""
    n, rate, band, speed = 60_000, 1000.0, 16.0, 0.05
    rng = np.random.default_rng(3)
    noisy = {"position": POSITION_NOISE, "velocity": VELOCITY_NOISE, "force": FORCE_NOISE}
    columns = {name: level * rng.standard_normal(n) for name, level in noisy.items()}
    time = np.arange(n) / rate
    columns["position"] += speed * time
    columns["velocity"] += speed
    slide = Recording(time, columns, derived=frozenset() if velocity else frozenset({"velocity"}))
    result = smooth(slide, band_hz=band)
    left = result.input_rate[500:-500, 0].std()
    assert result.uses_velocity == velocity
    assert left == pytest.approx(result.input_rate_noise[0], rel=0.05)
    f = np.linspace(0.01, 2 * band, 3000)
    sp, su = 2 * POSITION_NOISE**2 / rate, 2 * VELOCITY_NOISE**2 / rate if velocity else np.inf
    best = 1 / (1 / (sp * (2 * np.pi * f) ** 2) + 1 / su)  # of two estimates of the velocity at each frequency
    gain = result.low_pass.gain(f, rate)
    assert left == pytest.approx(np.sqrt(np.trapezoid(gain**2 * best, f)), rel=0.04)
    assert rate_noise(sp, su, band) < left < rate_noise(sp, su, 2 * band)
    differences = POSITION_NOISE * rate / np.sqrt(2)  # central differences of white noise
    assert np.gradient(columns["position"], 1 / rate).std() == pytest.approx(differences, rel=0.02)
    assert differences / left > (85 if velocity else 40)
    assert result.output[:, 0].std() == pytest.approx(result.output_noise[0], rel=0.05)
    assert result.output_noise[0] == pytest.approx(FORCE_NOISE * np.sqrt(2 * 1.5 * band / rate), rel=0.06)


def test_position_and_velocity_are_the_true_ones_to_the_noise_that_is_told(strokes):
    result = smooth(strokes)
    inner = result.weight > 0
    truth = Strokes()
    for error, noise in (
        (result.input[:, 1] - truth.y(result.time), result.input_noise[1]),
        (result.input_rate[:, 1] - truth.y(result.time, 1), result.input_rate_noise[1]),
    ):
        assert np.std(error[inner]) == pytest.approx(noise, rel=0.12)
    assert result.uses_velocity
    rate = np.gradient(result.input[:, 1], result.time)
    assert np.std((rate - result.input_rate[:, 1])[inner]) < 0.01 * np.std(rate)


def test_the_ends_carry_no_more_than_a_few_times_the_noise_of_the_middle(strokes):
    result = smooth(strokes)
    truth = Strokes()
    for end in (slice(0, 40), slice(-40, None)):
        t = result.time[end]
        assert np.abs(result.input[end, 1] - truth.y(t)).max() < 10 * result.input_noise[1]
        assert np.abs(result.input_rate[end, 1] - truth.y(t, 1)).max() < 20 * result.input_rate_noise[1]


def test_without_noise_the_motion_comes_out_as_it_went_in():
    result = smooth(contact_recording(noise=0.0, velocity=False))
    inner = result.weight > 0
    truth = Strokes()
    assert np.abs(result.input[:, 1] - truth.y(result.time))[inner].max() < 3e-4 * np.ptp(truth.y(result.time))
    rate = truth.y(result.time, 1)
    assert np.abs(result.input_rate[:, 1] - rate)[inner].max() < 3e-4 * np.ptp(rate)


@pytest.mark.parametrize("wrong", ["late", "scaled"])
def test_a_velocity_that_contradicts_the_position_is_not_used(strokes, wrong):
    late = {f"velocity_{a}": np.roll(strokes[f"velocity_{a}"], 4) for a in "xyz"}
    scaled = {f"velocity_{a}": 1.05 * strokes[f"velocity_{a}"] for a in "xyz"}
    result = smooth(changed(strokes, **(late if wrong == "late" else scaled)))
    assert not result.uses_velocity
    error = result.input_rate[:, 1] - Strokes().y(result.time, 1)
    assert np.std(error[result.weight > 0]) == pytest.approx(result.input_rate_noise[1], rel=0.15)


def test_the_band_is_about_four_times_the_top_excitation(strokes):
    result = smooth(strokes)
    assert result.top_hz[1] == pytest.approx(TOP_HZ, rel=0.1) and result.top_hz[0] == 0.0
    assert 3.5 * TOP_HZ < result.low_pass.band_hz < 5.5 * TOP_HZ
    assert result.rate_hz == pytest.approx(250.0) and result.rate_hz >= 12 * result.low_pass.band_hz


@pytest.mark.parametrize("level", [0.0, 1e-5, 1e-4])
def test_top_excitation_is_that_of_the_motion_and_not_of_its_noise(level):
    t = np.arange(30_000) / 1000.0
    wave = 0.02 * np.sin(2 * np.pi * 0.5 * t) + 0.004 * np.sin(2 * np.pi * 5.0 * t)
    noisy = wave + level * np.random.default_rng(0).standard_normal(len(t))
    top, speed = top_excitation(noisy, 1000.0, 2 * level**2 / 1000.0)
    assert top == pytest.approx(5.0, abs=0.3)
    assert speed == pytest.approx(2 * np.pi * np.hypot(0.02 * 0.5, 0.004 * 5.0) / np.sqrt(2), rel=0.03)


def test_the_noise_of_every_channel_is_found_to_5_percent(strokes):
    noise = noise_floor(strokes)
    for name, level in (("position", POSITION_NOISE), ("velocity", VELOCITY_NOISE), ("force", FORCE_NOISE)):
        for axis in "xyz":
            assert noise[f"{name}_{axis}"].std == pytest.approx(level, rel=0.05), f"{name}_{axis}"
            assert abs(noise[f"{name}_{axis}"].colour_db or 0.0) < WHITE_DB
    assert noise["force_y"].source == "free space" and noise["position_y"].source == "high frequencies"


def test_force_noise_that_a_logger_has_filtered_is_seen_whole_in_free_space(strokes):
    rng = np.random.default_rng(8)
    coloured = np.empty(len(strokes))
    coloured[0], a = 0.0, 0.95  # a pole at 8 Hz
    for i, w in enumerate(rng.standard_normal(len(strokes) - 1)):
        coloured[i + 1] = a * coloured[i] + np.sqrt(1 - a * a) * 0.05 * w
    noise = noise_floor(changed(strokes, force_y=strokes["force_y"] + coloured))["force_y"]
    assert noise.std == pytest.approx(np.hypot(0.05, FORCE_NOISE), rel=0.12)
    assert noise.colour_db > 10.0


def test_little_free_space_does_not_make_white_noise_denser_along_one_axis_than_along_another():
    for seed in range(6):
        brief = smooth(contact_recording(seconds=3.0, seed=seed))
        assert brief.rest.seconds < 1.5
        told = brief.output_noise / brief.low_pass.white_noise_gain(brief.clock.rate_hz)
        assert told == pytest.approx(np.full(3, FORCE_NOISE), rel=0.25)


def test_a_sensor_that_stands_on_one_count_in_free_space_tells_its_noise_in_contact(strokes):
    count = 5.0 * FORCE_NOISE
    counted = changed(strokes, force_y=np.round(strokes["force_y"] / count) * count)
    noise = noise_floor(counted)["force_y"]
    assert noise.source == "high frequencies"
    assert noise.std == pytest.approx(np.hypot(FORCE_NOISE, count / np.sqrt(12.0)), rel=0.2)


def test_what_a_mass_at_the_tip_takes_is_told_from_the_noise_in_free_space(strokes):
    inertia = 0.3 * np.gradient(Strokes().y(strokes.time, 1), strokes.time)
    clean, heavy = (smooth(changed(strokes, force_y=strokes["force_y"] - m * inertia)) for m in (0.0, 1.0))
    assert np.std(inertia) > 5.0 * clean.noise["force_y"].std
    assert heavy.noise["force_y"].std == pytest.approx(clean.noise["force_y"].std, rel=0.02)
    assert heavy.noise["force_y"].density == pytest.approx(clean.noise["force_y"].density, rel=0.7)


@pytest.mark.parametrize("frequency", [1.37, 11.0, 50.0])
def test_a_hum_is_told_from_the_noise_in_free_space(strokes, frequency):
    hum = 0.3 * np.sin(2 * np.pi * frequency * strokes.time + 0.7)
    result = smooth(changed(strokes, force_y=strokes["force_y"] + hum + 0.1))
    found = result.rest.hum[1]
    assert found.frequency == pytest.approx(frequency, abs=0.01) and found.amplitude == pytest.approx(0.3, rel=0.02)
    assert result.noise["force_y"].std == pytest.approx(FORCE_NOISE, rel=0.05)
    assert result.rest.mean[1] == pytest.approx(0.1, abs=3e-3)
    assert result.rest.hum[0] is None and result.rest.hum[2] is None


def test_bias_in_free_space_has_an_honest_standard_error():
    off, told = [], []
    for seed in range(12):
        recording = contact_recording(seconds=4.0, seed=seed)
        rest = smooth(changed(recording, force_y=recording["force_y"] + 0.2)).rest
        off.append(rest.mean[1] - 0.2)
        told.append(rest.standard_error[1])
    assert np.mean(told) == pytest.approx(FORCE_NOISE / np.sqrt(1000 * rest.seconds), rel=0.3)
    assert np.sqrt(np.mean(np.square(off))) < 2 * np.mean(told)


@pytest.mark.parametrize("flag", [True, False])
def test_touches_and_releases_are_found_finer_than_a_sample(flag):
    fine = np.linspace(0.0, 20.0, 2_000_001)
    below = Strokes().z(fine) < 0
    true = fine[1:][below[1:] != below[:-1]]
    result = smooth(contact_recording(flag=flag))
    changes = np.sort(np.concatenate([result.contact.touches, result.contact.releases]))
    np.testing.assert_allclose(changes, true, atol=4e-4)
    assert len(result.contact.touches) == len(TOUCHES) and len(result.contact.releases) == len(RELEASES)
    np.testing.assert_array_equal(result.in_contact, result.contact.at(result.time))
    # On the slow clock the height and the flag agree at every sample, so a model finds the same crossing.
    assert np.mean(result.in_contact == (result.input[:, 2] < 0)) == 1.0


def test_the_share_of_contact_about_each_time_is_exact():
    contact = ContactTimes(starts_in=True, changes=np.array([1.0, 2.5]))
    times = np.array([0.0, 0.9, 1.0, 1.2, 2.45, 3.0])
    np.testing.assert_allclose(contact.share(times, 0.4), [1.0, 0.75, 0.5, 0.0, 0.375, 1.0], atol=1e-12)
    np.testing.assert_array_equal(contact.at(times), [True, True, False, False, False, True])
    np.testing.assert_allclose(contact.since(times), [0.0, 0.9, 0.0, 0.0, 0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(ContactTimes(False, np.array([2.5])).since(times)[-2:], [0.0, 0.5], atol=1e-12)
    assert not ContactTimes(False, np.zeros(0)).since(times).any()


def test_noise_about_the_surface_makes_no_chatter():
    n = 6000
    t = np.arange(n) / 1000.0
    rng = np.random.default_rng(2)
    z = np.where(t < 3, 2e-6, -4e-3 * np.clip(t - 3, 0, 1)) + 1e-5 * rng.standard_normal(n)
    assert np.count_nonzero(np.diff(z < 0)) > 1000
    columns = {f"position_{a}": 0.01 * np.sin(5 * t) for a in "xy"} | {"position_z": z}
    columns |= {f"force_{a}": rng.standard_normal(n) for a in "xyz"} | {"in_contact": (z < 0).astype(float)}
    columns |= {f"velocity_{a}": np.gradient(columns[f"position_{a}"], t) for a in "xyz"}
    derived = frozenset({"in_contact", "velocity_x", "velocity_y", "velocity_z"})
    contact = smooth(Recording(t, columns, derived=derived)).contact
    assert len(contact.changes) <= 2 and contact.changes[-1] == pytest.approx(3.0, abs=0.02)


def test_weights_are_zero_at_ends_gaps_and_touches_alone(strokes):
    holed = cut(strokes, (strokes.time < 6.0) | (strokes.time > 6.1))
    result = smooth(holed)
    reach = result.low_pass.half_length_s
    expected = (result.time < reach) | (result.time > result.time[-1] - reach)
    expected |= (result.time > 6.0 - reach - 1e-9) & (result.time < 6.101 + reach)
    for change in result.contact.changes:
        expected |= np.abs(result.time - change) <= 0.25 * reach
    assert np.mean(expected == (result.weight == 0)) > 0.999
    assert len(result.clock.gaps) == 1


def test_resampling_an_uneven_clock_stays_within_its_bound():
    rng = np.random.default_rng(4)
    t = np.cumsum(rng.uniform(0.6e-2, 1.4e-2, 3000))
    wave = 0.02 * np.sin(2 * np.pi * 2.0 * t)
    clock = clock_of(t)
    assert not clock.is_even and len(clock.gaps) == 0
    even = on_clock(t, wave[:, None], clock)[:, 0]
    error = np.abs(even - 0.02 * np.sin(2 * np.pi * 2.0 * clock.times()))[10:-10].max()
    bound = clock.spline_error(0.02 * (2 * np.pi * 2.0) ** 4)
    assert 0.02 * bound < error <= bound


def test_an_uneven_recording_gives_what_an_even_one_does():
    t = np.cumsum(np.random.default_rng(1).uniform(0.7e-3, 1.3e-3, 20_000))
    result = smooth(contact_recording(time=t))
    error = result.input_rate[:, 1] - Strokes().y(result.time, 1)
    assert np.std(error[result.weight > 0]) < 1.5 * result.input_rate_noise[1]
    assert result.rate_hz == pytest.approx(250.0, rel=0.01)


def test_a_driven_body_keeps_the_impulse_of_its_input_and_its_output_passes_the_same_filter():
    recording = driven_recording()
    result = smooth(recording)
    assert result.every > 1
    impulse = np.trapezoid(recording["input"], recording.time)
    assert np.trapezoid(result.input[:, 0], result.time) == pytest.approx(impulse, abs=1e-3)
    thinned = recording["output"][:: result.every]
    inner = result.weight > 0
    np.testing.assert_allclose(result.filter(thinned)[inner], result.output[inner, 0], atol=5e-6)
    assert result.in_contact.all() and len(result.contact.changes) == 0


def test_a_short_driven_recording_is_left_as_it_is():
    t = np.arange(45) / 15.0
    fall = Recording(t, {"input": 0 * t, "output": 47 - 4.9 * t**2, "output_rate": -9.8 * t})
    result = smooth(fall)
    assert result.low_pass.is_identity and result.every == 1
    np.testing.assert_array_equal(result.output[:, 0], fall["output"])
    np.testing.assert_array_equal(result.filter(result.output), result.output)


def test_one_axis_is_always_in_contact():
    t = np.arange(5000) / 500.0
    single = Recording(t, {"position": 0.01 * np.sin(9 * t), "velocity": 0.09 * np.cos(9 * t), "force": np.cos(9 * t)})
    result = smooth(single)
    assert result.in_contact.all() and result.input.shape == result.output.shape == (len(result.time), 1)


def test_positions_without_forces_are_refused(strokes):
    columns = {name: strokes[name] for name in ("position_x", "position_y", "position_z")}
    with pytest.raises(BadInput, match="positions without forces"):
        smooth(replace(strokes, columns=columns))


def test_a_column_that_is_not_one_number_a_sample_is_named():
    time = np.arange(300) / 100.0
    table = Recording(time, {"input": np.zeros((300, 6)), "output": np.sin(time)}, "joints")
    with pytest.raises(BadInput, match=r"joints: input: found an array of the shape \(300, 6\), expected 300 numbers"):
        smooth(table)
