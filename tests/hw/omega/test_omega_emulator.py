"""The emulated handle: the real bindings run against it, and its position answers force as physics says."""

from pathlib import Path

import numpy as np
import pytest

from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.omega.emulator.build import referred_names
from mmt_drake.hw.omega.sdk import Sdk, load_sdk


@pytest.fixture
def sdk(omega: EmulatedOmega) -> Sdk:
    sdk = load_sdk()
    assert sdk.drd.openID(0) == 0
    sdk.dhd.enableForce(True, 0)
    sdk.dhd.setGravityCompensation(True, 0)
    return sdk


def test_every_function_that_the_bindings_refer_to_is_there(library: Path) -> None:
    import ctypes

    loaded = ctypes.CDLL(str(library))
    names = referred_names()
    assert len(names) > 200 and names["dhdGetComFreq"] == "double" and names["dhdSetForce"] == "int"
    for name in names:
        assert hasattr(loaded, name), name


def test_what_it_does_not_emulate_fails_as_the_vendors_does(sdk: Sdk) -> None:
    assert sdk.drd.start(0) == -1


def test_a_constant_force_moves_the_hand_by_force_over_stiffness(sdk: Sdk, omega: EmulatedOmega) -> None:
    omega.set(hand_stiffness=200.0, resolution=0.0)
    position = np.zeros(3)
    for _ in range(3000):
        sdk.dhd.setForce((2.0, 0.0, -1.0), 0)
        omega.advance(1e-3)
    sdk.dhd.getPosition(position, 0)
    np.testing.assert_allclose(position, [0.01, 0.0, -0.005], atol=1e-7)


def test_a_free_handle_oscillates_at_the_frequency_of_its_mass_and_the_hands_spring(
    sdk: Sdk, omega: EmulatedOmega
) -> None:
    omega.set(mass=0.3, hand_mass=0.2, hand_stiffness=450.0, hand_damping=0.0, damping=0.0, x=0.01)
    positions = []
    for _ in range(2000):
        omega.advance(1e-3)
        positions.append(omega.get("x"))
    crossings = np.flatnonzero(np.diff(np.sign(positions)))
    period = 2 * np.mean(np.diff(crossings)) * 1e-3
    assert period == pytest.approx(2 * np.pi / np.sqrt(450.0 / 0.5), rel=2e-3)


def test_velocity_is_the_slope_of_the_position_half_a_window_ago(sdk: Sdk, omega: EmulatedOmega) -> None:
    sdk.dhd.configLinearVelocity(10, ID=0)
    omega.set(hand_stiffness=5000.0, hand_damping=60.0, swing_x=0.02, swing_hz=1.0, resolution=0.0)
    omega.advance(0.5)
    trace = []
    for _ in range(200):
        omega.advance(1e-3)
        trace.append(omega.get("vx"))
    velocity = np.zeros(3)
    sdk.dhd.getLinearVelocity(velocity, 0)
    assert velocity[0] == pytest.approx(trace[-6], rel=3e-3)  # a lag of 0 would be 15 times that off


def test_forces_stop_when_the_firmwares_watchdog_hears_nothing(sdk: Sdk, omega: EmulatedOmega) -> None:
    sdk.expert.enableExpertMode()
    assert sdk.expert.setWatchdog(80, 0) == 0  # 10 ms
    for _ in range(50):
        sdk.dhd.setForce((3.0, 0.0, 0.0), 0)
        omega.advance(1e-3)
    assert omega.get("applied_x") == 3.0
    omega.advance(0.012)
    assert omega.get("applied_x") == 0.0


def test_without_gravity_compensation_the_handle_sinks(sdk: Sdk, omega: EmulatedOmega) -> None:
    sdk.dhd.setGravityCompensation(False, 0)
    omega.set(hand_stiffness=300.0, mass=0.3, resolution=0.0)
    for _ in range(3000):
        sdk.dhd.setForce((0.0, 0.0, 0.0), 0)
        omega.advance(1e-3)
    assert omega.get("z") == pytest.approx(-0.3 * 9.81 / 300.0, rel=1e-4)


def test_a_force_beyond_the_motors_is_scaled_and_said(sdk: Sdk, omega: EmulatedOmega) -> None:
    assert sdk.dhd.setForce((0.0, 30.0, 0.0), 0) == 2
    omega.advance(1e-3)
    assert omega.get("applied_y") == pytest.approx(12.0)
