"""Which of the effects of a fit are delivered."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from trial_samples import model, named

from mmt_drake.diagnosis.decide import delivered
from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.decide.delivered import CLEARLY, agreed, beyond_doubt, outstanding, surely_there
from mmt_drake.diagnosis.fit.problem import Fitted

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


@pytest.mark.parametrize(
    ("bias", "left"),
    [
        ((0.1, 0.5), ("coulomb_friction", "force_bias")),
        ((-1.7, 2.1), ("coulomb_friction", "force_bias")),  # a tenth of it is 0.01 to 0.39
        ((-1.9, 2.3), ("coulomb_friction",)),
    ],
)
def test_an_effect_is_not_delivered_where_a_tenth_of_its_told_interval_holds_nothing(
    bias: tuple[float, float], left: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    both = named("coulomb_friction", "force_bias")
    told = {"Fc": (0.2, 0.4), "bias": bias}
    spans = [told.get(parameter.symbol, (1.0, 2.0)) for parameter in both.hypothesis.free_parameters()]
    both = replace(both, minimum=replace(both.minimum, x=np.mean(spans, axis=1)))
    monkeypatch.setattr(delivered, "intervals", lambda problem, fitted: spans)
    problem: Any = None
    assert surely_there(problem, both, [both, named("coulomb_friction")]).hypothesis.names == left
    whole = surely_there(problem, both, [both, named("coulomb_friction")], 1.0)  # where much is left without a name
    assert whole.hypothesis.names == (left if bias[0] > 0.0 else ("coulomb_friction",))


@pytest.mark.parametrize(("share", "left"), [(0.09, ("coulomb_friction",)), (0.11, ("coulomb_friction", "force_bias"))])
def test_a_much_slighter_effect_needs_an_interval_that_does_not_hold_nothing(
    share: float, left: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    both = named("coulomb_friction", "force_bias")
    spans = [{"bias": (-0.1, 0.9)}.get(p.symbol, (-0.1, 2.0)) for p in both.hypothesis.free_parameters()]
    both = replace(both, minimum=replace(both.minimum, x=np.mean(spans, axis=1)))
    monkeypatch.setattr(delivered, "intervals", lambda problem, fitted: spans)
    shares = [BudgetPart("coulomb_friction", 1.0), BudgetPart("force_bias", 0.5 * share, share)]
    problem: Any = None
    assert beyond_doubt(problem, both, shares, [both, named("coulomb_friction")]).hypothesis.names == left


def leaving(cost: float, *names: str) -> Fitted:
    """A fit with these effects, beside friction of the model's own, and what it leaves."""
    fitted = named(*names)
    hypothesis = replace(fitted.hypothesis, nominal=model(Fc=0.3))
    return replace(fitted, hypothesis=hypothesis, minimum=replace(fitted.minimum, residual=np.array([np.sqrt(cost)])))


@pytest.mark.parametrize(
    ("cost_of_the_spring", "names", "sure"),
    [
        (12.0, ("nonlinear_stiffness",), True),  # of 100, what is equal takes 2
        (60.0, ("constant_force", "nonlinear_stiffness"), False),  # it takes more than half of what there is
    ],
)
def test_equals_beside_a_law_leave_that_law_sure_where_they_take_next_to_nothing(
    cost_of_the_spring: float, names: tuple[str, ...], sure: bool
) -> None:
    spring = leaving(cost_of_the_spring, "nonlinear_stiffness")
    pushed = leaving(10.0, "nonlinear_stiffness", "constant_force")
    uneven = leaving(10.0, "nonlinear_stiffness", "asymmetric_friction")
    chances = {pushed.hypothesis.key: 1.0, uneven.hypothesis.key: 0.9}
    believed = ConfidenceSet((pushed, uneven), chances, (pushed, uneven), {})
    problem: Any = None
    found, is_sure = agreed(problem, believed, [leaving(100.0), spring, pushed, uneven])
    assert (tuple(sorted(found.hypothesis.names)), is_sure) == (names, sure)


@pytest.mark.parametrize(
    ("cost_of_the_spring", "names"), [(12.0, ("nonlinear_stiffness",)), (30.0, ("force_bias", "nonlinear_stiffness"))]
)
def test_what_another_explanation_does_without_is_delivered_only_where_it_takes_much(
    cost_of_the_spring: float, names: tuple[str, ...]
) -> None:
    spring = leaving(cost_of_the_spring, "nonlinear_stiffness")
    biased, dragged = (leaving(10.0, "nonlinear_stiffness", name) for name in ("force_bias", "quadratic_drag"))
    chances = {biased.hypothesis.key: 1.0, dragged.hypothesis.key: 0.9}
    believed = ConfidenceSet((biased, dragged), chances, (biased, dragged), {})
    problem: Any = None
    found, is_sure = agreed(problem, believed, [leaving(100.0), spring, biased, dragged])
    assert (tuple(sorted(found.hypothesis.names)), is_sure) == (names, True)
