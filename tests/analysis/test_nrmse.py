"""The error of a simulated force, as the contract defines it."""

import numpy as np
import pytest

from mmt_drake.analysis.nrmse import force_nrmse, nrmse
from mmt_drake.recording import Recording

TIME = np.arange(1000) * 1e-3
WAVE = np.sin(2 * np.pi * TIME)  # standard deviation sqrt(1/2)


def test_it_is_the_rms_error_over_the_standard_deviation_with_the_error_s_mean_left_in() -> None:
    assert nrmse(3.0 + 2.0 * WAVE, 2.0 * WAVE) == pytest.approx(3.0 / np.sqrt(2.0))
    assert nrmse(WAVE, 0.9 * WAVE) == pytest.approx(0.1)


def test_there_is_none_of_a_force_that_does_not_vary_or_has_no_sample() -> None:
    assert nrmse(np.zeros(5), np.ones(5)) is None
    assert nrmse(np.empty(0), np.empty(0)) is None


def test_forces_are_compared_in_contact_alone() -> None:
    contact = (TIME < 0.5).astype(float)
    zero = np.zeros_like(TIME)
    motion = {f"position_{axis}": zero for axis in "xyz"} | {"in_contact": contact}
    measured = Recording(TIME, motion | {"force_x": WAVE, "force_y": 0.0 * WAVE, "force_z": WAVE})
    wrong_off_contact = WAVE + 100.0 * (1.0 - contact)
    simulated = Recording(TIME, motion | {"force_x": wrong_off_contact, "force_y": WAVE, "force_z": WAVE + 0.1})
    half = np.std(WAVE[:500])
    assert force_nrmse(measured, simulated) == {"force_x": 0.0, "force_z": pytest.approx(0.1 / half)}


def test_a_hand_without_forces_has_no_error() -> None:
    hand = Recording(TIME, {f"position_{axis}": WAVE for axis in "xyz"})
    forces = {f"force_{axis}": WAVE for axis in "xyz"}
    assert force_nrmse(hand, Recording(TIME, hand.columns | forces)) == {}
