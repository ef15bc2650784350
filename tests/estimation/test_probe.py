"""The wrist's force, cleared of the probe: exact on a known motion, zeroed in free space, and never by a contact."""

from __future__ import annotations

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.estimation.probe import ProbeOptions, compensate, initial_readout, settings

STEP = 1e-3
MASS, OFFSET = 0.2, np.array([0.4, -0.3, 1.2])
WEIGHT = (0.0, 0.0, -MASS * 9.81)
OPTIONS = ProbeOptions(mass=MASS, weight=WEIGHT, step=STEP)
LATE = round(OPTIONS.delay / STEP)

Array = np.ndarray


def contact(seconds: float = 3.0) -> tuple[Array, Array, Array, Array]:
    """Raw samples (n, 9), the flag, the force on the tip (n, 3) and the time: free, touched from 1 to 2 s, free."""
    t = np.arange(round(seconds / STEP)) * STEP
    w = 2.0 * np.pi * np.array([1.0, 2.5, 0.7])
    position, velocity = 0.01 * np.sin(np.outer(t, w)), 0.01 * w * np.cos(np.outer(t, w))
    flag = ((t >= 1.0) & (t < 2.0)).astype(float)
    force = flag[:, None] * np.column_stack([np.sin(9.0 * t), np.cos(4.0 * t), 2.0 + 0.0 * t])
    acceleration = -0.01 * w**2 * np.sin(np.outer(t, w))
    read = force + MASS * (np.array([0.0, 0.0, -9.81]) - acceleration) + OFFSET
    return np.hstack([position, velocity, read]), flag, force, t


def run(raw: Array, flag: Array, options: ProbeOptions = OPTIONS) -> Array:
    fixed = settings(options)
    readout = initial_readout(fixed)
    out = np.empty((len(raw), 13))
    for k in range(len(raw)):
        compensate(raw[k], flag[k], readout, fixed)
        out[k] = readout[:13]
    return out


def test_what_is_left_is_the_force_on_the_tip_of_the_sample_in_the_middle() -> None:
    raw, flag, force, _ = contact()
    out = run(raw, flag)
    late, then = slice(500, None), slice(500 - LATE, -LATE)
    np.testing.assert_array_equal(out[late, :6], raw[then, :6])
    np.testing.assert_array_equal(out[late, 9], flag[then])
    # The slope over 20 ms of a sine of 2.5 Hz is short of its acceleration by (w T)^2 / 10.
    slack = 1.5 * MASS * 0.01 * (2 * np.pi * 2.5) ** 2 * (2 * np.pi * 2.5 * 0.01) ** 2 / 10.0 + 1e-3
    assert np.abs(out[late, 6:9] - force[then]).max() < slack


def test_the_offset_is_found_in_free_space_and_kept_in_contact() -> None:
    raw, flag, _, t = contact()
    offset = run(raw, flag)[:, 10:13]
    np.testing.assert_array_equal(offset[t < OPTIONS.clear], 0.0)
    np.testing.assert_allclose(offset[900], OFFSET, atol=2e-3)
    touched = offset[(t > 1.0) & (t < 2.0)]
    assert (touched == touched[0]).all()


def test_a_drift_of_the_offset_is_taken_off_at_the_next_lift() -> None:
    raw, flag, _, t = contact()
    raw[:, 6:] += (0.5 * (t > 1.5))[:, None]
    offset = run(raw, flag)[:, 10:13]
    np.testing.assert_allclose(offset[-1], OFFSET + 0.5, atol=2e-3)


def test_a_weight_that_is_taken_wrong_ends_in_the_offset_and_not_in_the_force() -> None:
    raw, flag, force, _ = contact()
    wrong = ProbeOptions(mass=MASS, weight=(0.0, 0.0, 0.8 * WEIGHT[2]), step=STEP)
    out = run(raw, flag, wrong)
    assert np.abs(out[900:1500, 8] - force[900 - LATE : 1500 - LATE, 2]).max() < 5e-3


@pytest.mark.parametrize("column", [0, 4, 8])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_sample_that_is_not_finite_is_handed_on_and_forgotten(column: int, bad: float) -> None:
    raw, flag, _, _ = contact()
    expected = run(raw, flag)
    raw[[400, 1500], column] = bad  # free, and touched
    out = run(raw, flag)
    finite = np.isfinite(out).all(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(~finite), [400 + LATE, 1500 + LATE])
    # A velocity that is missing from a slope, or a sample from the mean, makes a little difference.
    np.testing.assert_allclose(out[finite], expected[finite], atol=2e-3)


def test_where_the_flag_is_not_known_the_offset_is_not_renewed() -> None:
    raw, flag, _, t = contact()
    flag[flag > 0.5] = np.nan
    offset = run(raw, flag)[:, 10:13]
    np.testing.assert_allclose(offset[(t > 1.0) & (t < 2.0)], np.tile(offset[999], (999, 1)), rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mass": -0.1}, "mass: found -0.1"),
        ({"step": 0.0}, "step: found 0"),
        ({"slope": 1.0}, "slope: found 1"),
        ({"weight": (0.0, 0.0, float("nan"))}, "weight"),
    ],
)
def test_options_that_make_no_sense_are_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        ProbeOptions(**options)  # type: ignore[arg-type]
