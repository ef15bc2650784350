"""The bank filters as scipy does, sample by sample."""

import numpy as np
import pytest
import scipy.signal

from mmt_drake.numeric.butterworth import butterworth, lowpass, rest_state, set_at_rest


def filtered(sos: np.ndarray, signals: np.ndarray, state: np.ndarray) -> np.ndarray:
    out = signals.copy()
    for row in out:
        lowpass(sos, row, state)
    return out


@pytest.mark.parametrize(("order", "cutoff"), [(1, 30.0), (2, 10.0), (5, 3.0), (6, 10.0), (8, 100.0)])
def test_the_bank_is_sosfilt_on_every_signal(order: int, cutoff: float) -> None:
    signals = np.random.default_rng(order).standard_normal((2000, 5)) * [1.0, 1e3, 1e-3, 1.0, 50.0]
    sos = butterworth(order, cutoff, 1e-3)
    ours = filtered(sos, signals, np.zeros((len(sos), 2, 5)))
    expected = scipy.signal.sosfilt(scipy.signal.butter(order, cutoff, fs=1000, output="sos"), signals, axis=0)
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-13 * abs(expected).max(axis=0).max())


def test_the_cut_off_is_where_half_the_power_is_left() -> None:
    t = np.arange(8000) * 1e-3
    signals = np.sin(2 * np.pi * 10.0 * t)[:, None]
    sos = butterworth(6, 10.0, 1e-3)
    out = filtered(sos, signals, np.zeros((len(sos), 2, 1)))[4000:]
    assert out.std() / signals[4000:].std() == pytest.approx(np.sqrt(0.5), rel=1e-6)


def test_from_rest_a_constant_passes_without_a_transient() -> None:
    values = np.array([0.05, -3.0, 1e4])
    sos = butterworth(6, 10.0, 1e-3)
    state = np.zeros((len(sos), 2, 3))
    set_at_rest(rest_state(sos), values, state)
    out = filtered(sos, np.tile(values, (500, 1)), state)
    np.testing.assert_allclose(out, np.tile(values, (500, 1)), rtol=1e-9)
