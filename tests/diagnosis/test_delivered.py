"""Which of the effects of a fit are delivered."""

from typing import Any

import pytest
from trial_samples import named

from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.decide.delivered import CLEARLY, outstanding

NAMELESS = 0.01


@pytest.mark.parametrize(
    ("friction", "spring", "left"),
    [
        (0.9, 1.1 * CLEARLY * NAMELESS, ("coulomb_friction", "nonlinear_stiffness")),
        (0.9, 0.9 * CLEARLY * NAMELESS, ("coulomb_friction",)),
        (0.0, 0.5, ("nonlinear_stiffness",)),
        (0.0, 0.0, ("coulomb_friction", "nonlinear_stiffness")),  # none stands out, so none takes from another
    ],
)
def test_an_effect_is_delivered_only_where_it_stands_out_from_what_nobody_has_named(
    friction: float, spring: float, left: tuple[str, ...]
) -> None:
    both = named("coulomb_friction", "nonlinear_stiffness")
    fits = [both, named("coulomb_friction"), named("nonlinear_stiffness")]
    shares = [
        BudgetPart("coulomb_friction", friction),
        BudgetPart("nonlinear_stiffness", spring),
        BudgetPart("nameless", NAMELESS),
    ]
    problem: Any = None
    assert outstanding(problem, both, shares, fits).hypothesis.names == left
