"""Why an explanation lost is said of that explanation, and not the same of all."""

from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.tell import reasons
from mmt_drake.diagnosis.tell.reasons import Reasons


@dataclass(frozen=True)
class NamedSet:
    """Of a fit, what a reason asks for: its effects and what it leaves."""

    names: tuple[str, ...]
    cost: float = 1.0
    bounds: frozenset[str] = frozenset()
    hypothesis: Any = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "hypothesis", self)

    @property
    def key(self) -> frozenset[str]:
        return frozenset(self.names)


@pytest.fixture(autouse=True)
def _bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reasons, "at_bounds", lambda fitted: fitted.bounds)


BEST = NamedSet(("coulomb_friction",))
STRIBECK, BESIDE = NamedSet(("stribeck_friction",)), NamedSet(("coulomb_friction", "force_bias"), 0.99)
DRIFT, FAR = NamedSet(("force_drift",), 50.0), NamedSet(("force_drift", "time_delay"), 49.9)
BOUND, ASYMMETRIC = NamedSet(("hysteresis",), 2.0, frozenset({"k2"})), NamedSet(("asymmetric_friction",), 0.99)
LAG = NamedSet(("force_lag",), 7.0)
ALL = (BEST, STRIBECK, BESIDE, DRIFT, FAR, BOUND, ASYMMETRIC, LAG)


def told(fitted: Any, named: Any = BEST) -> str:
    chances = {BEST.key: 1.0, STRIBECK.key: 0.4, BESIDE.key: 0.6, ASYMMETRIC.key: 0.7, DRIFT.key: 1e-9}
    stood: Any = (BEST, STRIBECK, BESIDE, ASYMMETRIC)
    unsaid = {ASYMMETRIC.key: frozenset({"asymmetric_friction"})}
    members: Any = (BEST, STRIBECK)
    believed = ConfidenceSet(members, chances, stood, unsaid)
    errors = {f.key: 0.02 * f.cost for f in (*ALL, fitted)} | {BEST.key: 0.02, LAG.key: 0.01}
    return Reasons(named, 0.1, errors, believed, ALL).of(fitted)


def test_what_is_delivered_is_the_simplest_that_is_not_ruled_out() -> None:
    assert told(BEST) == "Delivered: the simplest of the 2 that are not ruled out and may be named."


def test_what_stands_beside_it_is_said_to_say_no_more_or_something_else() -> None:
    assert told(STRIBECK) == "Not ruled out. Stribeck friction does as well here as Coulomb friction."
    assert told(BESIDE) == "Not ruled out. But force bias is not needed beside Coulomb friction: simpler does as well."
    assert "asymmetric friction must not be named: it may do nothing of its own" in told(ASYMMETRIC)


def test_what_is_ruled_out_is_told_with_its_chance() -> None:
    assert told(DRIFT) == (
        "Ruled out: it predicts blocks left out worse, with force drift in the place of Coulomb friction. "
        "Chance alone would do that less than once in a million times."
    )


def test_a_part_that_takes_nothing_off_is_named() -> None:
    assert told(FAR) == "Time delay takes next to nothing off beside force drift."


def test_a_bound_that_made_a_fit_is_named() -> None:
    assert told(BOUND) == "k2 ended at the edge of the range sought: a bound made this fit, it proves nothing."


def test_one_of_lower_held_out_error_that_is_not_taken_says_why_not() -> None:
    assert told(LAG) == (
        "Left behind by the search: 7 times the squared error of the fit, with force lag in the place of Coulomb "
        "friction. Its held-out error is the lower one, but held-out blocks choose no name: they only confirm."
    )


def test_reasons_differ_from_one_explanation_to_the_next() -> None:
    assert len({told(fitted) for fitted in ALL}) == len(ALL)


def test_where_no_name_is_given_each_says_how_little_it_takes_off() -> None:
    assert told(LAG, None).startswith("It leaves 0.1 times the held-out error of the parameters alone")
    assert told(DRIFT, None) == "It predicts held-out data no better than the parameters alone."
    assert told(STRIBECK, None).endswith("too much to be named. Chance alone would do that once in 2.5 times.")


def test_where_no_name_is_given_it_says_what_stood_in_the_way_of_one() -> None:
    assert "But asymmetric friction must not be named: it may do nothing of its own" in told(ASYMMETRIC, None)
    behind = replace(DRIFT, cost=2.0)
    assert "Ruled out: another one, which has no name either, predicts blocks left out better." in told(behind, None)
