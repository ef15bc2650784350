"""What a model file gives is doubted where its error may stand for a name, and then believed again or not."""

from typing import Any

import pytest

from mmt_drake.diagnosis.doubt import is_better, is_doubtful
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.result import Diagnosis, Fit, HeldoutNrmse, NamedEffect
from mmt_drake.effects import LIBRARY

NOISE = 0.01
NOTHING: Any = None


def answer(left: float, *names: str) -> Outcome:
    """A diagnosis that names these effects, and leaves so much on held-out data."""
    laws = [LIBRARY[name] for name in names]
    effects = tuple(NamedEffect(law.name, law.family, law.block, "law", {}) for law in laws)
    fit = Fit((), (), NOISE, HeldoutNrmse(1.0, 0.5, left))
    return Outcome(
        Diagnosis("missing_physics" if names else "unexplained", "", effects=effects, fit=fit), NOTHING, NOTHING
    )


@pytest.mark.parametrize(
    ("names", "doubtful"),
    [
        ((), True),
        (("ground_spring", "coulomb_friction"), True),
        (("nonlinear_stiffness",), True),
        (("coulomb_friction",), False),
    ],
)
def test_gravity_is_doubted_where_nothing_is_named_or_a_force_of_the_position(names, doubtful) -> None:
    assert is_doubtful(answer(0.1, *names)) is doubtful


@pytest.mark.parametrize(
    ("before", "again", "better"),
    [
        ((0.1, "ground_spring", "coulomb_friction"), (0.11, "coulomb_friction"), True),  # as little with fewer
        ((0.1, "ground_spring", "coulomb_friction"), (0.12, "coulomb_friction"), False),
        ((0.1, "ground_spring"), (0.1, "coulomb_friction"), False),  # as little with others
        ((0.1, "ground_spring"), (0.07, "coulomb_friction"), True),  # half the variance
        ((0.5,), (0.1, "coulomb_friction"), True),
        ((0.5,), (0.1, "nonlinear_stiffness", "constant_force"), False),  # two forces of the position draw anything
        ((0.1, "ground_spring"), (0.01,), False),  # names nothing
    ],
)
def test_the_answer_with_gravity_free_must_leave_much_less_or_need_fewer_effects(before, again, better) -> None:
    assert is_better(answer(*again), answer(*before)) is better
