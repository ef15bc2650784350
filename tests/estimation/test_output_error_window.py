"""The window of samples: touches, gaps, weights."""

import numpy as np
import pytest

from mmt_drake.estimation.output_error.smoothing import filter_bank
from mmt_drake.estimation.output_error.window import (
    CONTACT,
    FORCE_GOOD,
    MOTION_GOOD,
    POSITION,
    SAMPLE_SIZE,
    VELOCITY,
    Window,
)

H = 0.005
BANK = filter_bank(H, 5)


def samples(n: int, touch: float = 1.0) -> np.ndarray:
    """A probe that comes down steadily through the surface at `touch` [s] and slides."""
    t = np.arange(n) * H
    made = np.ones((n, SAMPLE_SIZE))
    made[:, POSITION] = np.column_stack([0.02 * np.sin(3 * t), 0 * t, 0.05 * (touch - t)])
    made[:, VELOCITY] = np.column_stack([0.06 * np.cos(3 * t), 0 * t, -0.05 + 0 * t])
    made[:, CONTACT] = t >= touch
    return made


def grown(made: np.ndarray, at_once: int) -> Window:
    window = Window.empty()
    for k in range(0, len(made), at_once):
        window = window.extended(made[k : k + at_once], H, BANK)
    return window


def test_a_window_that_grows_in_pieces_is_the_one_that_is_given_at_once() -> None:
    made = samples(900)
    pieces, whole = grown(made, 10), grown(made, 900)
    np.testing.assert_array_equal(pieces.samples, whole.samples)
    np.testing.assert_array_equal(pieces.contact, whole.contact)
    inner = slice(210, -210)
    np.testing.assert_allclose(pieces.motion[inner], whole.motion[inner], atol=2e-6)


@pytest.mark.parametrize("late", [-4, 0, 3, 8])
def test_a_touch_is_where_the_probe_crosses_the_surface_however_late_it_is_told(late: int) -> None:
    made = samples(600, touch=1.0031)
    made[:, CONTACT] = np.roll(made[:, CONTACT], late)
    made[:20, CONTACT], made[-20:, CONTACT] = 0.0, 1.0
    window = grown(made, 600)
    (k,) = np.flatnonzero(np.diff(window.contact)) + 1
    assert (k - 1 + window.switch[k]) * H == pytest.approx(1.0031, abs=2e-5)


def test_force_that_is_not_compared_is_not_when_more_samples_come_either() -> None:
    made = samples(600)
    window = grown(made[:400], 400).shortened(250).not_compared(20)
    later = window.extended(made[400:], H, BANK)
    assert not later.weight[:20].any() and later.weight[20:].all()


def test_a_touch_far_from_the_surface_is_where_it_is_told() -> None:
    made = samples(600)
    made[:, POSITION] += (0.0, 0.0, 1.0)
    window = grown(made, 600)
    assert list(np.flatnonzero(np.diff(window.contact)) + 1) == [200]
    assert window.switch[200] == 1.0


def test_a_gap_in_the_motion_is_bridged_and_what_follows_it_waits() -> None:
    made = samples(900)
    truth = made[:, POSITION].copy()
    made[500:520, POSITION] = 7.0
    made[500:520, MOTION_GOOD] = 0.0
    window = grown(made, 10)
    assert np.abs(window.samples[:, POSITION] - truth).max() < 2e-4
    assert not window.weight[500:575].any()
    assert window.weight[590:, 0].all()


def test_a_gap_longer_than_the_filters_reach_is_bridged_in_pieces_as_it_is_at_once() -> None:
    made = samples(1200)
    made[500:900, POSITION] = 7.0
    made[500:900, MOTION_GOOD] = 0.0
    np.testing.assert_allclose(grown(made, 10).samples, grown(made, 1200).samples, atol=1e-12)


def test_bad_force_does_not_count_and_takes_nothing_else_with_it() -> None:
    made = samples(900)
    made[500:520, FORCE_GOOD.start + 1] = 0.0
    window = grown(made, 10)
    assert not window.weight[500:520, 1].any()
    assert window.weight[500:520, [0, 2]].all()


def test_nothing_counts_in_free_space_and_about_a_touch() -> None:
    window = grown(samples(600), 600)
    assert not window.weight[:202].any()
    assert window.weight[203:].all()


def test_a_window_is_not_copied_with_a_context() -> None:
    from copy import deepcopy

    window = grown(samples(50), 50)
    assert deepcopy(window) is window
