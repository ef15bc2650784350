"""Velocity from position: exact on clean data, as quiet as theory says on noise, without lag."""

from pathlib import Path

import numpy as np
import pytest

from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.derive import motion_of, rate_of, touches
from mmt_drake.simulation import simulate

STEP = 1e-3


def even_clock(count: int) -> np.ndarray:
    return np.arange(count) * STEP


def uneven_clock(count: int) -> np.ndarray:
    return np.cumsum(np.random.default_rng(4).uniform(0.5 * STEP, 1.5 * STEP, count))


def test_the_rate_of_a_parabola_is_exact_on_an_uneven_clock() -> None:
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(2e-4, 4e-3, 500))
    parabolas = np.column_stack([1.0 + 2.0 * time - 3.0 * time**2, -time])
    expected = np.column_stack([2.0 - 6.0 * time, np.full(500, -1.0)])
    np.testing.assert_allclose(rate_of(time, parabolas), expected, atol=1e-9)


def test_white_noise_leaves_the_deviation_of_savitzky_and_golay() -> None:
    noise = 1e-5 * np.random.default_rng(2).standard_normal(200_000)
    rate = rate_of(np.arange(len(noise)) * STEP, noise)
    half = 10  # samples in 10 ms
    expected = 1e-5 * np.sqrt(3.0 / (half * (half + 1) * (2 * half + 1))) / STEP
    assert abs(np.std(rate) / expected - 1.0) < 0.02


def test_positions_of_a_derived_rate_are_its_integral_and_the_samples_where_those_have_no_noise() -> None:
    time = even_clock(4000)
    clean = 0.03 * np.sin(5.0 * time)
    np.testing.assert_array_equal(motion_of(time, clean)[0], clean)
    noisy = clean + 1e-5 * np.random.default_rng(6).standard_normal(len(time))
    position, rate = motion_of(time, noisy)
    half = 10  # samples in 10 ms; the middle of a parabola weighs 3 (3 M^2 + 3 M - 1) / ((2 M - 1) (2 M + 1) (2 M + 3))
    weight = 3.0 * (3.0 * half * (half + 1) - 1.0) / ((2 * half - 1) * (2 * half + 1) * (2 * half + 3))
    assert abs(np.std(position - clean) / (1e-5 * np.sqrt(weight)) - 1.0) < 0.1
    way = np.abs(np.diff(position) - STEP * (rate[1:] + rate[:-1]) / 2.0)
    assert way.mean() < 0.2 * np.abs(np.diff(noisy) - STEP * (rate[1:] + rate[:-1]) / 2.0).mean()


@pytest.mark.parametrize("clock", [even_clock, uneven_clock])
@pytest.mark.parametrize("frequency", [0.2, 1.0, 3.0, 3.6, 10.0])
def test_the_rate_of_a_clean_sine_is_right_to_1e_6_up_to_the_ends(frequency: float, clock) -> None:
    time, omega = clock(5000), 2.0 * np.pi * frequency
    sine, constant = np.sin(omega * time + 0.3), np.ones(5000)
    rates = rate_of(time, np.column_stack([sine, constant]))
    assert np.abs(rates[:, 0] / omega - np.cos(omega * time + 0.3)).max() < 1e-7
    np.testing.assert_array_equal(rates[:, 1], 0.0)


def test_clean_fast_motion_is_off_by_the_sixth_power_of_its_frequency() -> None:
    time = even_clock(20_000)
    for frequency in (40.0, 80.0):
        omega = 2.0 * np.pi * frequency
        rate = rate_of(time, np.sin(omega * time))[3:-3]
        lost = 1.0 - rate @ np.cos(omega * time)[3:-3] / (np.cos(omega * time)[3:-3] ** 2).sum() / omega
        assert abs(lost / ((omega * STEP) ** 6 / 140.0) - 1.0) < 0.1


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 8])
def test_a_few_samples_of_a_parabola_are_enough(count: int) -> None:
    time = 0.1 + uneven_clock(count)
    np.testing.assert_allclose(rate_of(time, 0.01 - 3.0 * time**2), -6.0 * time, rtol=1e-9)


@pytest.mark.parametrize("clock", [even_clock, uneven_clock])
def test_noise_of_10_um_on_a_slow_motion_leaves_no_more_than_on_a_resting_one(clock) -> None:
    time, omega = clock(100_000), 2.0 * np.pi * 0.2
    noise = 1e-5 * np.random.default_rng(5).standard_normal(len(time))
    resting = np.std(rate_of(time, noise))
    moving = rate_of(time, noise + 0.03 * np.sin(omega * time)) - 0.03 * omega * np.cos(omega * time)
    assert resting < 0.05 * 1e-5 / STEP  # 0.036 for the whole window, 0.71 for central differences
    assert abs(np.std(moving) / resting - 1.0) < 0.03


@pytest.mark.parametrize("clock", [even_clock, uneven_clock])
def test_a_csv_of_clean_positions_simulates_as_one_with_velocities_to_1e_6(clock, tmp_path: Path) -> None:
    """From the first to the last sample: no transient is left out at the ends."""
    time = clock(3000)
    columns = {}
    for axis, phase in zip("xyz", (0.0, 1.0, 2.0), strict=True):
        middle = -0.004 if axis == "z" else 0.0
        waves = [(0.002, 0.7), (0.001, 3.6), (0.0003, 10.0)]
        columns[f"position_{axis}"] = middle + sum(a * np.sin(2 * np.pi * f * time + phase) for a, f in waves)
        columns[f"velocity_{axis}"] = sum(a * 2 * np.pi * f * np.cos(2 * np.pi * f * time + phase) for a, f in waves)
        columns[f"force_{axis}"] = np.zeros(3000)
    whole = Recording(time, columns)
    bare = Recording(time, {name: values for name, values in columns.items() if not name.startswith("velocity")})
    save(whole, tmp_path / "whole.csv")
    save(bare, tmp_path / "bare.csv")
    model = FlexibleBoxModel(BoxParameters(m=0.7, k1=50, k2=600, b1=20, b2=30))
    read = load(tmp_path / "bare.csv")
    assert {"velocity_x", "velocity_y", "velocity_z"} <= read.derived and "velocity_x" in read.notes[0]
    forces = simulate(model, read).vector("force")
    expected = simulate(model, load(tmp_path / "whole.csv")).vector("force")
    for axis in range(3):
        off = np.sqrt(np.mean((forces[:, axis] - expected[:, axis]) ** 2))
        assert off < 1e-6 * np.sqrt(np.mean(expected[:, axis] ** 2))


def test_there_is_no_lag() -> None:
    time = np.arange(20_000) * STEP
    omega = 2.0 * np.pi * 3.0
    noisy = np.sin(omega * time) + 1e-4 * np.random.default_rng(3).standard_normal(len(time))
    rate = rate_of(time, noisy)
    phase = np.angle(np.exp(-1j * omega * time) @ rate) - np.angle(np.exp(-1j * omega * time) @ np.cos(omega * time))
    assert abs(phase / omega) < 2e-5


def test_the_measured_velocity_of_a_real_damper_is_its_position_s_rate(recordings) -> None:
    with np.load(recordings / "mr_damper" / "10mm1Hz1A.npz") as data:
        rate = rate_of(data["t_s"], data["x_m"])
        assert np.std(rate - data["v_mps"]) < 0.005 * np.std(data["v_mps"])


def test_contact_is_below_the_surface_not_on_it() -> None:
    np.testing.assert_array_equal(touches(np.array([1e-9, 0.0, -0.0, -1e-9])), [0.0, 0.0, 0.0, 1.0])
