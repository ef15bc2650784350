"""Reports of where a body is held: when they are made, believed and followed."""

import numpy as np
import pytest

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MODE, POSITION, VELOCITY
from mmt_drake.model.flexible_box import BODY, CONTACT, STATE_SIZE, TIME
from mmt_drake.model.held_body import HELD_SIZE, NEAR, NO_REPORT, astray, lead, report, watch


def held_at(*axes):
    """A state in contact, (position, anchor) of the body along x and y."""
    state = np.zeros(STATE_SIZE)
    state[CONTACT] = 1.0
    for i, (position, anchor) in enumerate(axes):
        state[BODY + AXIS_SIZE * i + POSITION], state[BODY + AXIS_SIZE * i + ANCHOR] = position, anchor
    return state


def test_a_report_is_made_new_along_the_axes_on_which_the_body_is_held():
    bodies = held_at((0.1, 0.2), (0.3, 0.4))[BODY:].reshape(2, AXIS_SIZE)
    assert report(NO_REPORT, bodies, 5.0).tolist() == [0.1, 0.2, 5.0, 0.3, 0.4, 5.0]
    for at in (MODE, VELOCITY):
        moving = bodies.copy()
        moving[0, at] = 1.0
        assert report(np.arange(6.0), moving, 5.0).tolist() == [0.0, 1.0, 2.0, 0.3, 0.4, 5.0]


@pytest.mark.parametrize("i", [0, 1])
@pytest.mark.parametrize(("off", "known"), [(0.0, False), (0.9 * NEAR, False), (1.1 * NEAR, True), (-1.1 * NEAR, True)])
def test_a_body_is_astray_where_the_sum_of_position_and_anchor_is_not_the_reported_one(i, off, known):
    state, since = held_at((0.01, 0.02), (-0.03, 0.05)), np.array([1.0, 1.0])
    position, anchor = ((0.01, 0.02), (-0.03, 0.05))[i]
    held = np.zeros(HELD_SIZE)
    held[3 * i : 3 * i + 3] = position + 0.004, anchor - 0.004 + off, 2.0  # the same but for `off`
    assert astray(state, i, held, since) == known
    assert not astray(state, 1 - i, held, since)  # of that axis nothing is reported
    assert not astray(state, i, held, np.array([2.0, 2.0]))


def test_as_near_as_is_known_is_near_enough():
    assert not astray(held_at((0.0, 0.0)), 0, np.array([NEAR, 0.0, 2.0, 0.0, 0.0, 0.0]), np.zeros(2))


@pytest.mark.parametrize("i", [0, 1])
@pytest.mark.parametrize("share", [0.25, 1.0])
def test_a_body_is_led_a_share_of_the_way_and_the_other_axis_not_at_all(i, share):
    before, held = np.array([[0.01, 0.02], [-0.03, 0.05]]), np.array([[0.5, -0.7], [0.6, -0.8]])
    state = held_at(*before)
    lead(state, i, np.column_stack([held, [2.0, 2.0]]).ravel(), share)
    expected = held_at(*np.where(np.arange(2)[:, None] == i, before + share * (held - before), before))
    np.testing.assert_allclose(state, expected, rtol=1e-12)


def test_a_body_has_been_there_since_it_last_moved_slid_or_lost_its_contact():
    before, since = held_at((0.1, 0.2), (0.3, 0.4)), np.zeros(2)
    for at, expected in ((None, [0, 0]), (POSITION, [7, 0]), (MODE, [7, 0]), (AXIS_SIZE + POSITION, [0, 7])):
        after, since[:] = before.copy(), 0.0
        after[TIME] = 7.0
        if at is not None:
            after[BODY + at] = 0.5
        watch(before, after, since)
        assert since.tolist() == expected
    after = before.copy()
    after[TIME], after[CONTACT] = 8.0, 0.0
    watch(before, after, since)
    assert since.tolist() == [8, 8]
