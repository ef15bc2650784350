"""Which object is touched, by what is seen of all of them."""

import math

import numpy as np
from pydrake.systems.analysis import Simulator

from mmt_drake.cloud.seen import UNCOLOURED
from mmt_drake.model.scene_layout import ALONG, MOST, ROW, SCENE_SIZE, STATE, TOP, SeenState
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.touched_object import TouchedObject


def scene(*places: tuple[float, float, float]) -> Array:
    """Squares of 8 cm with their tops at these places."""
    rows = np.zeros((MOST, ROW))
    for i, (x, y, top) in enumerate(places):
        rows[i] = i + 1, SeenState.SEEN, x, y, top, 0.05, 0.08, 0.08, *UNCOLOURED, 1.0
    return rows.ravel()


class Finger:
    """A tip that is put from place to place."""

    def __init__(self, seen: Array) -> None:
        self.system, self.scene, self.t = TouchedObject(), seen, 0.0
        self.simulator = Simulator(self.system)
        self.put(0.0, 0.4, 0.2)

    def put(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Whether it touches, and what."""
        context = self.simulator.get_mutable_context()
        self.system.GetInputPort("position").FixValue(context, [x, y, z])
        self.system.GetInputPort("scene").FixValue(context, self.scene)
        told = tuple(self.system.GetOutputPort(name).Eval(context)[0] for name in ("in_contact", "thing"))
        self.t += 1e-3
        self.simulator.AdvanceTo(self.t)
        return told

    def out(self, name: str) -> Array:
        return self.system.GetOutputPort(name).Eval(self.simulator.get_context())


TWO = scene((0.0, 0.0, -0.02), (0.13, 0.0, 0.0))


def test_it_touches_in_the_tick_in_which_the_tip_gets_below_a_top_and_lets_go_in_that_in_which_it_is_above() -> None:
    finger = Finger(TWO)
    assert finger.put(0.0, 0.0, -0.019) == (0.0, 1.0)
    assert finger.put(0.0, 0.0, -0.0201) == (1.0, 1.0)
    assert finger.put(0.3, 0.0, -0.025) == (1.0, 1.0)  # it goes along, and the camera is late
    np.testing.assert_array_equal(finger.out("facet"), [0.0, 0.0, 1.0, -0.02])
    assert finger.put(0.0, 0.0, -0.0199) == (0.0, 1.0)


def test_of_two_that_meet_it_is_over_that_within_whose_outline_it_is_however_near_the_other_s_middle() -> None:
    large_and_small = scene((0.0, 0.0, -0.02), (0.057, 0.0, -0.02))
    rows = large_and_small.reshape(MOST, ROW)
    rows[1, ALONG : ALONG + 2] = 0.03
    finger = Finger(large_and_small)
    finger.put(0.034, 0.0, 0.01)  # 6 mm within the large one, 23 mm from the small one's middle, 34 mm from its own
    assert finger.put(0.034, 0.0, -0.021) == (1.0, 1.0)


def test_each_object_has_its_own_height() -> None:
    finger = Finger(TWO)
    finger.put(0.13, 0.0, 0.01)
    assert finger.put(0.13, 0.0, -0.001) == (1.0, 2.0)
    assert finger.out("clearance")[0] == -0.001


def test_a_tip_that_is_below_a_top_before_it_is_over_it_touches_nothing() -> None:
    finger = Finger(TWO)
    finger.put(0.2, 0.0, -0.01)
    assert finger.put(0.13, 0.0, -0.01) == (0.0, 2.0)


def test_an_object_that_appears_under_a_tip_below_its_top_is_not_touched() -> None:
    finger = Finger(np.zeros(SCENE_SIZE))
    assert finger.put(0.0, 0.0, -0.03) == (0.0, 0.0)
    assert finger.out("clearance")[0] == -math.inf
    finger.scene = TWO
    assert finger.put(0.0, 0.0, -0.03) == (0.0, 1.0)


def test_one_that_is_taken_away_is_let_go_and_one_that_is_lost_is_still_held() -> None:
    for state, held in ((SeenState.LOST, 1.0), (SeenState.OCCLUDED, 1.0), (SeenState.TAKEN_AWAY, 0.0)):
        finger = Finger(TWO.copy())
        finger.put(0.0, 0.0, 0.0)
        assert finger.put(0.0, 0.0, -0.03)[0] == 1.0
        finger.scene[STATE] = state
        assert finger.put(0.0, 0.0, -0.03)[0] == held
    finger.scene = np.zeros(SCENE_SIZE)
    assert finger.put(0.0, 0.0, -0.03) == (0.0, 0.0)


def test_the_plane_stays_as_long_as_it_is_held() -> None:
    finger = Finger(TWO.copy())
    finger.put(0.0, 0.0, 0.0)
    finger.put(0.0, 0.0, -0.03)
    finger.scene[TOP] = -0.021
    finger.put(0.0, 0.0, -0.03)
    assert finger.out("facet")[3] == -0.02


def test_what_a_closed_grip_holds_stays_the_same_over_others_until_it_is_lost_or_let_go() -> None:
    system = TouchedObject(lost=2.0)
    simulator, told = Simulator(system), []
    context = simulator.get_mutable_context()
    system.GetInputPort("scene").FixValue(context, scene((0.0, 0.0, 0.0), (0.2, 0.0, 0.02)))
    for k, (x, z, grip, has) in enumerate(
        [
            *((0.0, 0.01, 0.0, 0.0), (0.0, -0.01, 0.0, 0.0), (0.0, -0.01, 8.0, 1.0), (0.0, 0.05, 8.0, 1.0)),
            *((0.2, 0.05, 8.0, 1.0), (0.2, 0.01, 8.0, 1.0), (0.3, -0.01, 8.0, 1.0)),  # over the other, beyond it, down
            *((0.3, -0.01, 0.0, 0.0), (0.3, 0.05, 0.0, 0.0), (0.2, 0.05, 0.0, 0.0), (0.2, 0.01, 0.0, 0.0)),  # let go
            *((0.2, 0.01, 8.0, 1.0), (0.2, 0.05, 8.0, 1.0), (0.0, 0.05, 8.0, 2.0), (0.0, -0.01, 8.0, 2.0)),  # lost
        ]
    ):
        for name, value in (("position", [x, 0.0, z]), ("grip", [grip]), ("has", [has])):
            system.GetInputPort(name).FixValue(context, value)
        told.append(tuple(system.GetOutputPort(name).Eval(context)[0] for name in ("in_contact", "thing")))
        simulator.AdvanceTo(1e-3 * (k + 1))
    assert told[:4] == [(0, 1), (1, 1), (1, 1), (0, 1)]
    assert told[4:7] == [(0, 1), (0, 1), (1, 1)]
    assert told[7:11] == [(1, 1), (0, 0), (0, 2), (1, 2)]
    assert told[11:] == [(1, 2), (0, 2), (0, 1), (1, 1)]


def test_a_tick_in_which_nobody_knows_where_the_tip_is_loses_no_touch() -> None:
    finger = Finger(scene((0.0, 0.0, 0.0)))
    heights = 0.001, math.nan, -0.001, math.nan, -0.002
    assert [finger.put(0.0, 0.0, z)[0] for z in heights] == [0.0, 0.0, 1.0, 1.0, 1.0]
