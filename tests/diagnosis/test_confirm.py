"""When blocks that chose no name bear one out."""

from typing import Any

import pytest
from trial_samples import named

from mmt_drake.diagnosis.decide import confirm
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.fit.problem import Fitted

BEST = "viscoelastic_relaxation nonlinear_stiffness"
CHANCES = {"": 1e-6, "viscoelastic_relaxation": 0.05, BEST: 1.0, "force_drift": 1e-4, "hysteresis": 1e-3}


def confirmed(monkeypatch: pytest.MonkeyPatch, heldout: dict[tuple[str, str], float], depth: str, best: str) -> bool:
    """Whether a relaxation is confirmed that stands beside a better set, given chances on held-out blocks."""
    fits = {names: named(*names.split()) for names in CHANCES}
    chances = {fits[names].hypothesis.key: chance for names, chance in CHANCES.items()}
    chances[fits[BEST].hypothesis.key], chances[fits[best].hypothesis.key] = 0.5, 1.0
    # Members that share the law, or no more than the family of what is delivered.
    shared = [fits["viscoelastic_relaxation"], fits[BEST], *([fits["hysteresis"]] if depth == "family" else [])]
    believed = ConfidenceSet(tuple(shared), chances, (), {})
    by_key = {f.hypothesis.key: names for names, f in fits.items()}

    def chance(problem: Any, before: Fitted, after: Fitted, tries: int) -> float:
        return heldout.get((by_key[before.hypothesis.key], by_key[after.hypothesis.key]), 1.0)

    monkeypatch.setattr(confirm, "chance", chance)
    problem: Any = None
    delivered = fits["viscoelastic_relaxation"]
    return confirm.is_confirmed(problem, fits[""], delivered, believed, list(fits.values()))


BEATEN = {("", BEST): 1e-4, ("force_drift", BEST): 1e-4, ("hysteresis", BEST): 1e-4}


@pytest.mark.parametrize(
    ("heldout", "depth", "best", "borne_out"),
    [
        ({("", "viscoelastic_relaxation"): 0.005}, "law", BEST, True),
        ({("", "viscoelastic_relaxation"): 0.05}, "law", BEST, False),
        ({("", "viscoelastic_relaxation"): 0.05, **BEATEN}, "law", BEST, True),
        # One without the name is not beaten; the best one does not have it.
        ({**BEATEN, ("force_drift", BEST): 0.05}, "law", BEST, False),
        ({**BEATEN, ("", "force_drift"): 1e-4}, "law", "force_drift", False),
        # Another law of the family need not be beaten where no more than the family is said.
        ({**BEATEN, ("hysteresis", BEST): 0.5}, "law", BEST, False),
        ({**BEATEN, ("hysteresis", BEST): 0.5}, "family", BEST, True),
    ],
)
def test_a_name_is_borne_out_by_what_it_gains_or_by_the_best_set_that_has_it(
    monkeypatch, heldout, depth, best, borne_out
) -> None:
    assert confirmed(monkeypatch, heldout, depth, best) is borne_out


@pytest.mark.parametrize(
    ("unseen", "seen", "tried", "borne_out"),
    [
        (0.05, 1e-4, 20, True),
        (0.05, 1e-2, 20, False),  # of twenty that were tried one is as good by chance
        (0.6, 1e-12, 20, False),  # held-out blocks speak against it
        (0.05, 1e-4, None, False),
    ],
)
def test_a_few_held_out_blocks_bear_a_name_out_together_with_all_others(
    monkeypatch: pytest.MonkeyPatch, unseen: float, seen: float, tried: int | None, borne_out: bool
) -> None:
    fits = {names: named(*names.split()) for names in CHANCES}
    believed = ConfidenceSet((fits[BEST],), {f.hypothesis.key: CHANCES[n] for n, f in fits.items()}, (), {})
    monkeypatch.setattr(confirm, "chance", lambda *_: unseen)
    monkeypatch.setattr(confirm, "gained_by_chance", lambda *_: seen)
    problem: Any = None  # nobody looks at it
    found = confirm.is_confirmed(problem, fits[""], fits[BEST], believed, list(fits.values()), tried)
    assert found is borne_out
