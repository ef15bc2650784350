"""Effects above a remainder that nobody names: how large it is, and that every effect and law has its turn."""

import numpy as np
import pytest

from mmt_drake.diagrams.proof.trial.laws import INSIDE
from mmt_drake.diagrams.proof.trial.remainder import REMAINDERS, _directions, _left, draw_beneath
from mmt_drake.diagrams.proof.trial.run import draw_trial
from mmt_drake.effects import LIBRARY


@pytest.mark.parametrize("remainder", REMAINDERS)
def test_the_remainder_is_the_share_of_what_a_refit_leaves_of_the_effect(remainder: str) -> None:
    case = draw_beneath(np.random.default_rng(3), "x", "static_friction", 0.9, remainder, 0.2)
    fitted = _directions(case.base, case.session)
    sets = ((), case.effects, (*case.effects, *case.remainder))
    plain, above, both = (case.session.true_reading(case.base, effects) for effects in sets)
    assert _left(both - above, fitted) == pytest.approx(0.2 * _left(above - plain, fitted), rel=0.1)
    assert case.truth()["remainder"] == [remainder]


def test_a_trial_above_remainders_has_every_effect_and_all_laws_in_turn() -> None:
    cases = draw_trial(seed=1, per_effect=1, remainder=0.1)
    assert sorted(case.effects[0].name for case in cases) == sorted(INSIDE)
    assert {case.remainder[0].name for case in cases} == set(REMAINDERS)


def test_no_remainder_has_a_name_in_the_library_and_what_is_not_false_of_it_has() -> None:
    assert not set(REMAINDERS) & set(LIBRARY)
    assert all(set(law.not_false) <= set(LIBRARY) for law in REMAINDERS.values())
