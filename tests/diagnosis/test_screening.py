"""What a search looks at first: the starts that promise most, and the axes that leave something to explain."""

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
from trial_samples import beside, model, problem_of, recorded

from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.search import minima, screening
from mmt_drake.diagnosis.search.starts import Seed, Start
from mmt_drake.diagnosis.search.watch import Watch
from mmt_drake.effects import LIBRARY

NAMES = list(LIBRARY)


def chosen(sets: int, monkeypatch: pytest.MonkeyPatch) -> list[Start]:
    """Of so many effects, each promising less than the one before, with five starts each, what is screened."""
    monkeypatch.setattr(Start, "promise", lambda start: start.values["promise"])
    seed = cast(Seed, SimpleNamespace(fitted=SimpleNamespace(hypothesis=SimpleNamespace(names=()))))
    tries = [
        Start(seed, LIBRARY[name], {"promise": 1.0 / (1 + rank) - 1e-4 * number})
        for rank, name in enumerate(NAMES[:sets])
        for number in range(5)
    ]
    watch = cast(Watch, SimpleNamespace(did=lambda *_: None, is_late=lambda: False))
    with ThreadPoolExecutor(1) as threads:
        return screening._promising(tries[::-1], threads, watch, 14)


def test_what_promises_little_has_one_start_and_what_promises_least_none(monkeypatch: pytest.MonkeyPatch) -> None:
    starts = chosen(16, monkeypatch)
    assert Counter(s.effect.name for s in starts) == dict.fromkeys(NAMES[:12], 4) | dict.fromkeys(NAMES[12:14], 1)


def test_of_every_effect_the_start_that_promises_most_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    first: Any = {}
    for start in chosen(14, monkeypatch):
        first.setdefault(start.effect.name, start.values["promise"])
    assert first == {name: 1.0 / (1 + rank) for rank, name in enumerate(NAMES[:14])}


def looked(name: str, cost: float, seed_cost: float, part: object) -> screening.Screened:
    """What a first look at an effect leaves beside a seed that leaves so much of a part of the problem."""
    seed = SimpleNamespace(near=SimpleNamespace(cost=seed_cost), part=part)
    start = cast(Start, SimpleNamespace(seed=seed))
    fitted = SimpleNamespace(hypothesis=SimpleNamespace(key=frozenset({name})), cost=cost)
    return screening.Screened(start, cast(Fitted, fitted))


def test_what_puts_far_numbers_right_is_not_before_what_betters_the_fit_of_all_numbers() -> None:
    whole = object()
    far = [looked(name, 105.0, 2500.0, whole) for name in NAMES[1:20]]
    hidden = looked(NAMES[0], 40.0, 100.0, whole)
    left = screening._left([s.start for s in (*far, hidden)])
    going_on, behind = screening._going_on([*far, hidden], left)
    assert left(hidden) == 0.4 and left(far[0]) == 1.05
    assert hidden in going_on and len(behind) == 20 - screening._GOING_ON


@pytest.mark.parametrize(("part", "count"), [(0.04, 1), (0.06, 2)])
def test_a_track_of_which_next_to_nothing_is_left_is_no_part_of_its_own(part: float, count: int) -> None:
    off = model(k2=600.0)
    problem = problem_of(recorded(), off)
    y = next(track for track in problem.tracks if track.axis == "y")
    quiet = replace(y, counts=part**0.5 * y.counts)
    both = replace(problem, tracks=(quiet, y))
    eased = both.eased(both.unchanged(beside(nominal=off), beside(nominal=off).base()))
    assert [one.tracks for one in eased] == [(y,), (quiet,)][:count]


def test_what_only_relaxes_has_no_minima_to_be_moved_between() -> None:
    without = [name for name, effect in LIBRARY.items() if any(p.shape for p in effect.parameters)]
    without = [name for name in without if not minima._has_events(LIBRARY[name])]
    assert sorted(without) == [
        "hardening_relaxation",
        "normal_hardening_relaxation",
        "normal_viscoelastic_relaxation",
        "viscoelastic_relaxation",
    ]
