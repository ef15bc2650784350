"""Which set-points reach the arm, without an arm."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.hw.franka.faults import ArmFault
from mmt_drake.hw.franka.guard import SetpointGuard
from mmt_drake.hw.franka.settings import FrankaSettings

SETTINGS = FrankaSettings("robot")
STEP = 1e-3
HOME = np.array([0.01, 0.0, 0.1])


def at(x: float, velocity: float = 0.0) -> np.ndarray:
    return np.array([x, 0.0, 0.1, velocity, 0.0, 0.0])


@pytest.fixture
def guard() -> SetpointGuard:
    """One that follows."""
    guard = SetpointGuard(SETTINGS)
    guard.start(HOME)
    assert guard.advance(at(0.01), 0.0, STEP) is ArmFault.NONE and guard.following
    return guard


def test_the_first_setpoint_is_approached_at_the_speed_that_is_set_and_then_followed() -> None:
    guard = SetpointGuard(SETTINGS)
    guard.start(HOME)
    positions = []
    while not guard.following:
        assert guard.advance(at(0.06, 0.1), 0.0, STEP) is ArmFault.NONE
        positions.append(guard.position[0])
    assert len(positions) == pytest.approx(0.05 / SETTINGS.approach / STEP, abs=1)
    assert np.abs(np.diff(positions)).max() <= SETTINGS.approach * STEP + 1e-12
    np.testing.assert_array_equal(np.r_[guard.position, guard.velocity], at(0.06, 0.1))


def test_a_late_thread_does_not_make_the_approach_jump() -> None:
    guard = SetpointGuard(SETTINGS)
    guard.start(HOME)
    guard.advance(at(0.06), 0.0, 10.0)
    assert guard.position[0] - HOME[0] <= SETTINGS.approach * 0.010 + 1e-12


def test_what_comes_in_goes_out(guard: SetpointGuard) -> None:
    for i in range(1000):
        commanded = at(0.01 + 0.02 * np.sin(i * 0.01), 0.2 * np.cos(i * 0.01))
        assert guard.advance(commanded, 0.0, STEP) is ArmFault.NONE
        np.testing.assert_array_equal(np.r_[guard.position, guard.velocity], commanded)


def test_without_setpoints_the_arm_holds_its_place_then_stops(guard: SetpointGuard) -> None:
    guard.advance(at(0.015, 0.3), 0.0, STEP)
    assert guard.advance(at(0.015, 0.3), SETTINGS.hold_after, STEP) is ArmFault.NONE and guard.following
    assert guard.advance(at(0.015, 0.3), SETTINGS.hold_after + 1e-6, STEP) is ArmFault.NONE and not guard.following
    np.testing.assert_array_equal(np.r_[guard.position, guard.velocity], at(0.015))
    assert guard.advance(at(0.015, 0.3), SETTINGS.stop_after, STEP) is ArmFault.NONE
    assert guard.advance(at(0.015, 0.3), SETTINGS.stop_after + 1e-6, STEP) is ArmFault.SETPOINTS_LOST


def test_after_a_short_silence_a_near_setpoint_is_followed_and_a_far_one_approached(guard: SetpointGuard) -> None:
    guard.advance(at(0.01), 0.1, STEP)
    assert guard.advance(at(0.02), 0.0, STEP) is ArmFault.NONE and guard.following
    guard.advance(at(0.02), 0.1, STEP)
    assert guard.advance(at(0.08), 0.0, STEP) is ArmFault.NONE and not guard.following
    assert guard.position[0] == pytest.approx(0.02 + SETTINGS.approach * STEP)


@pytest.mark.parametrize("age", [np.nan, np.inf])
def test_an_age_that_is_not_known_is_no_setpoint(guard: SetpointGuard, age: float) -> None:
    assert guard.advance(at(0.01), age, STEP) is ArmFault.SETPOINTS_LOST


@pytest.mark.parametrize("index", range(6))
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_a_number_stops_the_arm(guard: SetpointGuard, index: int, value: float) -> None:
    commanded = at(0.01)
    commanded[index] = value
    assert guard.advance(commanded, 0.0, STEP) is ArmFault.BAD_SETPOINT
    np.testing.assert_array_equal(guard.position, HOME)


@pytest.mark.parametrize(
    "commanded, fault",
    [
        (at(0.01 + SETTINGS.jump + 1e-9), ArmFault.JUMP),
        (at(0.01, SETTINGS.speed + 1e-9), ArmFault.FAST_SETPOINT),
        (at(SETTINGS.high[0] + 1e-9), ArmFault.WORKSPACE),
        (at(SETTINGS.low[0] - 1e-9), ArmFault.WORKSPACE),
    ],
)
def test_a_setpoint_beyond_a_limit_stops_the_arm_where_it_is(
    guard: SetpointGuard, commanded: np.ndarray, fault: ArmFault
) -> None:
    assert guard.advance(commanded, 0.0, STEP) is fault
    np.testing.assert_array_equal(guard.position, HOME)


def test_whatever_comes_the_arm_is_told_places_in_the_box_at_the_speed_and_jump_allowed() -> None:
    random = np.random.default_rng(5)
    for _ in range(50):
        guard = SetpointGuard(replace(SETTINGS, approach=0.25))
        guard.start(HOME)
        before = guard.position
        for _ in range(40):
            commanded = before[[0, 1, 2, 0, 1, 2]] + random.normal(0.0, random.choice([1e-3, 0.1, 3.0]), 6)
            commanded[random.integers(6)] *= random.choice([1.0, np.nan], p=[0.98, 0.02])
            if guard.advance(commanded, random.exponential(0.02), STEP):
                break
            told = guard.position
            assert np.isfinite(told).all() and np.linalg.norm(told - before) <= SETTINGS.jump + 1e-12
            assert (told >= SETTINGS.low).all() and (told <= SETTINGS.high).all()
            assert np.linalg.norm(guard.velocity) <= SETTINGS.speed + 1e-12
            before = told
