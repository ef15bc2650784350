"""The noise of a signal read off its spectrum, jumps of friction in it or not."""

import numpy as np
import pytest
from scipy import signal

from mmt_drake.diagnosis.signals.noise import noise_of, spectrum

STD = 0.02


def rubbed(rate_hz: float, level: float, seed: int = 0) -> np.ndarray:
    """20 s of a spring, and of dry friction that turns with the motion; white noise."""
    t = np.arange(0.0, 20.0, 1.0 / rate_hz)
    x, v = np.sin(2.0 * t) + 0.5 * np.sin(3.7 * t), 2.0 * np.cos(2.0 * t) + 1.85 * np.cos(3.7 * t)
    return 3.0 * x + level * np.sign(v) + STD * np.random.default_rng(seed).standard_normal(len(t))


@pytest.mark.parametrize("rate_hz", [100.0, 200.0, 500.0])
@pytest.mark.parametrize("level", [0.0, 1.2, 5.0])
def test_jumps_of_friction_are_no_noise(rate_hz: float, level: float) -> None:
    assert noise_of(rubbed(rate_hz, level), rate_hz).above(2.0).std == pytest.approx(STD, rel=0.3)


def test_coloured_noise_without_jumps_keeps_its_colour() -> None:
    white = np.random.default_rng(1).standard_normal(20_000)
    wandering = np.cumsum(white) * 0.01 + white
    found = noise_of(wandering, 1000.0)
    assert len(found.frequency) > 0 and found.above(20.0).std == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("count", [31, 500, 4001])
@pytest.mark.parametrize("segment", [32, 33, 1024])
def test_the_spectrum_is_that_of_welch_by_scipy(count: int, segment: int) -> None:
    values = np.cumsum(np.random.default_rng(2).standard_normal(count))
    length = min(segment, count)
    found = spectrum(values, 250.0, segment)
    expected = signal.welch(values, 250.0, "nuttall", length, detrend="linear", average="median")
    for mine, theirs in zip(found, expected, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-12 * theirs.max())
