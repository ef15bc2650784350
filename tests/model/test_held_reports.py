"""Which reports of where a body is held are believed, and where they lead it."""

import numpy as np
import pytest

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION
from mmt_drake.model.flexible_box import BODY, CONTACT, NORMAL, STATE_SIZE
from mmt_drake.model.held_body import HELD_SEEN, HELD_SIZE, NEAR, astray, count_from, counted_elsewhere, lead


@pytest.mark.parametrize("i", [0, 1])
@pytest.mark.parametrize(("off", "known"), [(NEAR, False), (-0.9 * NEAR, False), (1.1 * NEAR, True), (-0.1, True)])
def test_a_body_is_astray_where_the_sum_of_position_and_anchor_is_not_the_reported_one(i, off, known):
    state, held, since = np.zeros(STATE_SIZE), np.zeros(HELD_SIZE), np.ones(3)
    state[CONTACT] = 1.0
    bodies, entries = state[BODY:NORMAL].reshape(2, AXIS_SIZE), held[:HELD_SEEN].reshape(2, 3)
    at = 2.0**-14  # as a sum 0, and the report's is `off`, both to the last bit
    bodies[i, [POSITION, ANCHOR]], entries[i] = [at, -at], [0.5 * off, 0.5 * off, 2.0]
    assert astray(state, i, held, since) == known and not astray(state, 1 - i, held, since)
    assert not astray(state, i, held, 2.0 * since)
    lead(state, i, held, 0.25)
    assert bodies[i, [POSITION, ANCHOR]] == pytest.approx([0.75 * at + 0.125 * off, -0.75 * at + 0.125 * off])
    lead(state, i, held, 1.0)
    assert bodies[i, [POSITION, ANCHOR]].tolist() == [0.5 * off, 0.5 * off] and not bodies[1 - i].any()


@pytest.mark.parametrize("i", [0, 1])
def test_a_copy_counts_from_where_the_report_does_while_the_same_contact_lasts(i):
    state, held = np.zeros(STATE_SIZE), np.zeros(HELD_SIZE)
    state[CONTACT], held[HELD_SEEN] = 1.0, 2.0
    body = state[BODY:NORMAL].reshape(2, AXIS_SIZE)[i]
    body[[POSITION, ANCHOR]], held[3 * i + 1] = [0.5, 0.25], -0.25
    assert counted_elsewhere(state, i, held, np.array([9.0, 9.0, 1.0])) == 0.5  # though it slides
    assert counted_elsewhere(state, i, held, np.array([1.0, 1.0, 2.0])) == 0.0  # touched since
    count_from(state, i, 0.5)
    assert body[[POSITION, ANCHOR]].tolist() == [1.0, -0.25]
    assert counted_elsewhere(state, i, held, np.ones(3)) == 0.0
    held[3 * i + 1] = np.nan
    assert counted_elsewhere(state, i, held, np.ones(3)) == 0.0
