"""Where a tip touched, by force alone."""

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.touches import touches_of
from mmt_drake.recording import Recording


def pressed(heights: np.ndarray, k: float = 500.0, noise: float = 0.0) -> Recording:
    """A tip that goes through heights [m] above a spring at z = 0, at 1 kHz."""
    time = 1e-3 * np.arange(len(heights))
    rng = np.random.default_rng(0)
    force = np.maximum(-k * heights, 0.0)
    columns = {f"position_{axis}": np.zeros(len(time)) for axis in "xy"} | {"position_z": heights}
    columns |= {f"force_{axis}": noise * rng.standard_normal(len(time)) for axis in "xy"}
    return Recording(time, columns | {"force_z": force + noise * rng.standard_normal(len(time))}, "pressed")


def presses(depth: float = 0.004) -> np.ndarray:
    """Three presses from 6 mm above, a second each."""
    return 0.001 - (0.001 + depth) * np.sin(2.0 * np.pi * np.arange(3000) / 1000.0 - 0.5 * np.pi)


def test_a_touch_is_where_the_force_begins() -> None:
    for noise in (0.0, 0.02):
        found = touches_of(pressed(presses(), noise=noise))
        assert len(found.positions) == 3
        assert np.abs(found.positions[:, 2]).max() < 2e-4
        assert (found.spread < 1e-3).all()
        assert np.diff(found.times) == pytest.approx([1.0, 1.0], abs=5e-3)


def test_a_hard_touch_is_where_the_tip_was_before_the_jump() -> None:
    heights = np.where(np.arange(1000) < 500, 0.006, -0.1) - 1e-5 * np.arange(1000)
    (height,) = touches_of(pressed(heights)).positions[:, 2]
    assert height == pytest.approx(0.006 - 0.00499)


def test_what_begins_in_contact_is_no_touch() -> None:
    found = touches_of(pressed(-presses() + 0.001))
    assert found.times == pytest.approx([0.75, 1.75, 2.75], abs=1e-2)


def test_a_level_that_cannot_be_is_refused() -> None:
    with pytest.raises(BadInput, match="touches of 50 N or more"):
        touches_of(pressed(presses()), level=50.0)
    with pytest.raises(BadInput, match="free space, with less than"):
        touches_of(pressed(np.full(100, -0.01)))
    with pytest.raises(BadInput, match="level"):
        touches_of(pressed(presses()), level=0.0)
