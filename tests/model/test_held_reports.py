"""Which reports of where a body is held are believed, and where they lead it."""

import numpy as np
import pytest

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION
from mmt_drake.model.flexible_box import BODY, CONTACT, NORMAL, STATE_SIZE
from mmt_drake.model.held_body import HELD_SIZE, NEAR, astray, lead


@pytest.mark.parametrize("i", [0, 1])
@pytest.mark.parametrize(("off", "known"), [(NEAR, False), (-0.9 * NEAR, False), (1.1 * NEAR, True), (-0.1, True)])
def test_a_body_is_astray_where_the_sum_of_position_and_anchor_is_not_the_reported_one(i, off, known):
    state, held, since = np.zeros(STATE_SIZE), np.zeros(HELD_SIZE), np.ones(2)
    state[CONTACT] = 1.0
    bodies, entries = state[BODY:NORMAL].reshape(2, AXIS_SIZE), held.reshape(2, 3)
    at = 2.0**-14  # as a sum 0, and the report's is `off`, both to the last bit
    bodies[i, [POSITION, ANCHOR]], entries[i] = [at, -at], [0.5 * off, 0.5 * off, 2.0]
    assert astray(state, i, held, since) == known and not astray(state, 1 - i, held, since)
    assert not astray(state, i, held, 2.0 * since)
    lead(state, i, held, 0.25)
    assert bodies[i, [POSITION, ANCHOR]] == pytest.approx([0.75 * at + 0.125 * off, -0.75 * at + 0.125 * off])
    lead(state, i, held, 1.0)
    assert bodies[i, [POSITION, ANCHOR]].tolist() == [0.5 * off, 0.5 * off] and not bodies[1 - i].any()
