"""The operator's side remembers each object."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from mmt_drake.cloud.seen import UNCOLOURED
from mmt_drake.model.parameters import THETA
from mmt_drake.model.scene_layout import MOST, ROW, SeenState
from mmt_drake.model.theta import NO_FLAW, flaw_of_theta
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.object_memory import ObjectMemory

SOFT = np.array([0.2, 0.0, 250.0, 2.0, 8.0, 0.4, 250.0, 8.0, 0.4, 0.0])
HARD = np.array([0.9, 0.0, 900.0, 5.0, 25.0, 2.0, 900.0, 25.0, 2.0, 0.0])
NOBODY = np.full(len(THETA), np.nan)


def scene() -> Array:
    rows = np.zeros((MOST, ROW))
    for i, height in enumerate((0.04, 0.06, 0.05)):
        rows[i] = i + 1, SeenState.SEEN, 0.1 * i, 0.0, height, height, 0.08, 0.08, *UNCOLOURED, 1.0
    return rows.ravel()


class Operator:
    """Whose hand goes from object to object while theta comes."""

    def __init__(self) -> None:
        self.system, self.t = ObjectMemory(), 0.0
        self.simulator = Simulator(self.system)

    def at(
        self, thing: float, told: float, theta: Array, status: float = 0.0, stable: float = 1.0
    ) -> tuple[Array, float]:
        """What is rendered, and where it comes from."""
        context = self.simulator.get_mutable_context()
        given = {"thing": thing, "scene": scene(), "told_thing": told, "theta": theta, "stable": stable}
        for name, value in {**given, "model_status": status}.items():
            self.system.GetInputPort(name).FixValue(context, np.atleast_1d(value))
        out = [np.array(self.system.GetOutputPort(name).Eval(context)) for name in ("theta", "remembered")]
        self.t += 1e-3
        self.simulator.AdvanceTo(self.t)
        return out[0], float(out[1][0])


def test_what_comes_of_the_object_under_the_hand_is_shown_in_the_same_tick() -> None:
    theta, source = Operator().at(1.0, 1.0, SOFT)
    np.testing.assert_array_equal(theta, SOFT)
    assert source == 2.0


def test_an_object_that_was_felt_before_is_shown_before_its_theta_comes_again() -> None:
    hand = Operator()
    hand.at(1.0, 1.0, SOFT)
    hand.at(2.0, 2.0, HARD)
    theta, source = hand.at(1.0, 2.0, HARD)  # the telerobot is still at the second
    np.testing.assert_array_equal(theta, SOFT)
    assert source == 2.0
    theta, _ = hand.at(0.0, 2.0, HARD)  # over none, the last one stays
    np.testing.assert_array_equal(theta, SOFT)


def test_an_object_that_nothing_has_come_of_is_guessed_and_told_to_be() -> None:
    hand = Operator()
    theta, source = hand.at(3.0, 0.0, NOBODY)
    assert source == 1.0 and flaw_of_theta(theta, 1e-5) == NO_FLAW
    assert theta[0] == pytest.approx(1000.0 * 0.08 * 0.08 * 0.05)
    hand.at(1.0, 1.0, SOFT)
    like, source = hand.at(3.0, 1.0, SOFT)  # 0.2 kg of 0.04 m height is lighter than water
    assert source == 1.0 and like[0] < theta[0]
    hand.at(3.0, 3.0, HARD)
    assert hand.at(3.0, 1.0, SOFT)[1] == 2.0


def test_what_is_not_stable_or_not_known_is_never_kept() -> None:
    hand = Operator()
    hand.at(1.0, 1.0, SOFT)
    hand.at(1.0, 1.0, HARD, stable=0.0)
    theta, _ = hand.at(1.0, 1.0, NOBODY)
    np.testing.assert_array_equal(theta, SOFT)


def test_numbers_that_the_motion_did_not_tell_are_no_example_for_others() -> None:
    alone, _ = Operator().at(3.0, 0.0, NOBODY)
    hand = Operator()
    hand.at(1.0, 1.0, SOFT, status=3.0)
    theta, _ = hand.at(3.0, 1.0, SOFT, status=3.0)
    np.testing.assert_array_equal(theta, alone)
