"""The wrist's force, cleared of the probe: exact on a known motion, zeroed in free space, never by a contact."""

import math

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.estimation.probe import ProbeOptions, Zero, compensate, initial_readout, settings

STEP = 1e-3
MASS, OFFSET = 0.2, np.array([0.4, -0.3, 1.2])
WEIGHT = (0.0, 0.0, -MASS * 9.81)
OPTIONS = ProbeOptions(mass=MASS, weight=WEIGHT, step=STEP)
LATE = round(OPTIONS.delay / STEP)
CLEAR = round((OPTIONS.delay * 2 + OPTIONS.clear) / STEP) + 1  # ticks that have to be free before a window
WINDOW = round(OPTIONS.window / STEP)
AIR = 0.05  # [m] above the surface

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


def run(raw: Array, flag: Array, options: ProbeOptions = OPTIONS, clearance: Array | float = AIR) -> Array:
    fixed = settings(options)
    readout = initial_readout(options)
    out = np.empty((len(raw), 17))
    above = np.broadcast_to(clearance, len(raw))
    for k in range(len(raw)):
        compensate(raw[k], flag[k], above[k], readout, fixed)
        out[k] = readout[:17]
    return out


def still(force: Array) -> tuple[Array, Array]:
    """Raw samples (n, 9) and the flag of a probe that rests with a force (n, 3) on it, its contact never told."""
    read = force + MASS * np.array([0.0, 0.0, -9.81]) + OFFSET
    return np.hstack([np.zeros((len(force), 6)), read]), np.zeros(len(force))


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
    ("clearance", "told"),
    [(-0.012, Zero.LOST), (-math.inf, Zero.LOST), (math.nan, Zero.LOST), (0.002, Zero.HELD), (AIR, Zero.DEPARTED)],
)
def test_a_press_that_the_detector_loses_is_not_taken_for_the_zero(clearance: float, told: Zero) -> None:
    force = np.zeros((1500, 3))
    force[500:] = (0.0, 3.0, 8.0)
    raw, flag = still(force)
    above = np.full(len(raw), AIR)
    above[500:] = clearance
    out = run(raw, flag, clearance=above)
    np.testing.assert_allclose(out[:, 10:13][-1], OFFSET, atol=1e-12)
    np.testing.assert_allclose(out[-1, 6:9], force[-1], atol=1e-12)
    assert out[499, 16] == Zero.RENEWED and out[-1, 16] == told


def test_the_first_zero_is_taken_once_the_probe_was_free_for_long_enough_and_then_for_a_window() -> None:
    raw, flag = still(np.zeros((400, 3)))
    offset = run(raw, flag)[:, 10:13]
    first = CLEAR + WINDOW  # ticks from the first on
    np.testing.assert_array_equal(offset[: first - 1], 0.0)
    np.testing.assert_allclose(offset[first - 1 :], np.tile(OFFSET, (401 - first, 1)), atol=1e-12)


@pytest.mark.parametrize(("share", "renewed"), [(0.98, True), (1.02, False)])
def test_only_what_departs_less_than_it_may_is_followed(share: float, renewed: bool) -> None:
    options = ProbeOptions(mass=MASS, weight=WEIGHT, step=STEP, departure=0.4)
    force = np.zeros((1000, 3))
    # A step while no one looks: within a window it would be restless.
    force[500:] = share * options.departure * np.array([0.6, 0.0, 0.8])
    raw, flag = still(force)
    flag[490:510] = 1.0
    out = run(raw, flag, options)
    np.testing.assert_allclose(out[-1, 10:13], OFFSET + force[-1] * renewed, atol=1e-12)
    assert out[-1, 16] == (Zero.RENEWED if renewed else Zero.DEPARTED)


@pytest.mark.parametrize(("share", "renewed"), [(0.95, True), (1.05, False)])
def test_only_a_force_as_steady_as_asked_becomes_the_zero(share: float, renewed: bool) -> None:
    """Over a window T a ramp of slope s has the standard deviation s T / sqrt(12), and half of s T as its mean."""
    options = ProbeOptions(mass=MASS, weight=WEIGHT, step=STEP, steady=0.2)
    slope = share * options.steady * math.sqrt(12.0) / options.window
    t = np.arange(CLEAR + WINDOW) * STEP
    raw, flag = still(np.outer(slope * t, [0.0, 0.0, 1.0]))
    out = run(raw, flag, options)
    mean = slope * (t[-WINDOW:].mean() - OPTIONS.delay)  # of the sample in the middle
    np.testing.assert_allclose(out[-1, 10:13], renewed * (OFFSET + np.array([0.0, 0.0, mean])), atol=1e-9)
    assert out[-1, 16] == (Zero.RENEWED if renewed else Zero.RESTLESS)


def test_a_drift_in_a_lift_that_lasts_is_followed() -> None:
    """What remembers 50 windows of 50 ms is 2.5 s behind a steady drift: no lift is too long for it."""
    rate, seconds = 0.1, 60.0
    t = np.arange(round(seconds / STEP)) * STEP
    raw, flag = still(np.outer(rate * t, [1.0, 0.0, 0.0]))
    out = run(raw, flag)
    assert out[-1, 16] == Zero.RENEWED
    behind = OFFSET[0] + rate * seconds - out[-1, 10]
    assert behind == pytest.approx(rate * 50.0 * OPTIONS.window, rel=0.05)


def test_unless_told_a_probe_weighs_nothing_and_its_sensor_is_zeroed_all_the_same() -> None:
    raw, flag, _, _ = contact(0.3)
    out = run(raw, flag, ProbeOptions(step=STEP))
    np.testing.assert_array_equal(out[LATE : CLEAR - 1, 6:9], raw[: CLEAR - 1 - LATE, 6:9])
    assert out[-1, 10:13].all()


def test_the_port_s_numbers_for_the_fate_of_the_offset_stay() -> None:
    assert {zero.name: zero.value for zero in Zero} == dict(HELD=0, RENEWED=1, LOST=2, RESTLESS=3, DEPARTED=4)


def test_a_tick_writes_into_its_own_memory_alone() -> None:
    raw, flag, _, _ = contact(0.4)
    fixed = settings(OPTIONS)
    own = len(initial_readout(OPTIONS))
    beyond = np.full(own + 64, np.nan)
    beyond[:own] = 0.0
    for sample, touched in zip(raw, flag, strict=True):
        compensate(sample, touched, AIR, beyond[:own], fixed)
    assert np.isfinite(beyond[:own]).all() and np.isnan(beyond[own:]).all()


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("mass", 0.0, 100.0),
        ("step", 1e-5, 0.1),
        ("slope", 0.0, 0.5),
        ("clear", 0.0, 10.0),
        ("margin", 0.0, 0.1),
        ("window", 1e-3, 10.0),
        ("steady", 1e-6, 1e3),
        ("departure", 1e-6, 1e3),
    ],
)
def test_an_option_may_reach_its_ends_and_no_further(name: str, least: float, most: float) -> None:
    for value in (least, most):
        assert getattr(ProbeOptions(**{name: value}), name) == value
    for value in (least - 1e-9, most * 1.001, math.nan):
        with pytest.raises(BadInput, match=f"{name}: found"):
            ProbeOptions(**{name: value})


@pytest.mark.parametrize("weight", [(0.0, 0.0, math.nan), (0.0, math.inf, 0.0), (0.0, 0.0)])
def test_a_weight_that_is_no_force_is_refused(weight: tuple[float, ...]) -> None:
    with pytest.raises(BadInput, match="weight"):
        ProbeOptions(weight=weight)  # type: ignore[arg-type]
