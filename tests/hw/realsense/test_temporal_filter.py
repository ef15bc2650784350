"""The temporal filter averages noise away, follows a jump at once, and never shows what is no longer seen."""

import math

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import TemporalFilter


def filtered(smooth: TemporalFilter, frames: np.ndarray, unit: float = 1e-4) -> list[np.ndarray]:
    out, before = [], None
    for frame in frames:
        before = smooth(before, frame.astype(np.uint16), unit)
        out.append(before)
    return out


def test_white_noise_comes_out_as_small_as_the_formula_says() -> None:
    smooth = TemporalFilter(alpha=0.2, step=1.0)
    noise = np.random.default_rng(1).normal(5000.0, 20.0, (60, 80, 80))
    late = filtered(smooth, np.round(noise))[-1]
    assert late.std() == pytest.approx(20e-4 * math.sqrt(smooth.alpha / (2.0 - smooth.alpha)), rel=0.05)
    assert late.mean() == pytest.approx(0.5, abs=1e-4)


def test_a_ramp_is_seen_late_by_so_many_frames() -> None:
    ramp = 5000.0 + 10.0 * np.arange(80)[:, None, None] * np.ones((1, 2, 2))
    late = filtered(TemporalFilter(alpha=0.25), ramp)[-1]
    np.testing.assert_allclose(late, 0.5 + 1e-3 * (79 - 0.75 / 0.25), atol=1e-6)


def test_a_jump_is_followed_at_once_and_a_lost_pixel_is_lost() -> None:
    frames = np.full((4, 2, 2), 5000.0)
    frames[1:, 0, 0] = 5200.0  # 20 mm
    frames[1, 1, 1] = 0.0
    shown = filtered(TemporalFilter(alpha=0.1, step=0.01), frames)
    assert shown[1][0, 0] == pytest.approx(0.52)
    assert [image[1, 1] for image in shown] == pytest.approx([0.5, 0.0, 0.5, 0.5])


@pytest.mark.parametrize("changes", [{"alpha": 0.0}, {"alpha": 1.1}, {"step": -1.0}])
def test_a_filter_without_meaning_is_refused(changes: dict) -> None:
    with pytest.raises(BadInput, match=next(iter(changes))):
        TemporalFilter(**changes)
