"""What a scenario says of the foreign object arrives in its force, and only from its time on."""

import numpy as np
import pytest
from test_foreign_plant import LINEAR, run, sines, times

from mmt_drake.foreign.options import ForeignLaws

TIMES = times(1.0)
PLAIN, BODY = run(TIMES, sines(TIMES), LINEAR)


def test_the_defaults_leave_every_law_out() -> None:
    force, _ = run(TIMES, sines(TIMES), ForeignLaws().added_to(LINEAR))
    np.testing.assert_array_equal(force, PLAIN)


@pytest.mark.parametrize(
    ("laws", "begins"),
    [
        ({"k3": 2e7}, TIMES > 0.05),
        ({"hunt_crossley": 300.0}, TIMES > 0.05),
        ({"wall": 0.01}, np.maximum.accumulate(BODY[:, :2].max(axis=1)) > 0.01),
        ({"ground_time": 0.5}, TIMES >= 0.5),
        ({"mass_time": 0.5}, TIMES >= 0.5),
        ({"k2_time": 0.5}, TIMES >= 0.5),
    ],
)
def test_a_law_changes_the_force_from_where_it_begins(laws: dict[str, float], begins: np.ndarray) -> None:
    force, _ = run(TIMES, sines(TIMES), ForeignLaws(**laws).added_to(LINEAR))
    change = np.linalg.norm(force - PLAIN, axis=1)
    first = int(np.argmax(begins))
    assert 0 < first < len(TIMES) - 1000
    assert np.max(change[first:]) > 0.1
    if "time" in next(iter(laws)) or "wall" in laws:
        assert np.max(change[:first]) < 1e-9
