"""What is not ruled out, and what that rests on."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from trial_samples import COULOMB, beside, model, named, problem_of, recorded

from mmt_drake.diagnosis.decide import confidence, exchange
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet, contradicted
from mmt_drake.diagnosis.fit.floors import noise_kept_out, noise_through
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.tell.outcome import _untried_for
from mmt_drake.effects import LIBRARY

RUBBING = recorded(COULOMB, seed=3, seconds=10.0)
START = {"coulomb_friction": {"Fc": 0.3}, "stribeck_friction": {"Fs": 0.4, "v_s": 0.01}, "force_bias": {"bias": 0.01}}
START["hysteresis"] = {"alpha": 100.0, "beta": 500.0}


@pytest.fixture(scope="module")
def problem() -> Problem:
    return problem_of(RUBBING, model())


@pytest.fixture(scope="module")
def fits(problem: Problem) -> dict[str, Fitted]:
    sets = ("", "coulomb_friction", "force_bias", "hysteresis", "coulomb_friction force_bias")
    hypotheses = {names: beside(*names.split()) for names in sets}
    return {names: problem.fit(hypothesis, hypothesis.vector({}, START)) for names, hypothesis in hypotheses.items()}


def leaving(monkeypatch: pytest.MonkeyPatch, left: Callable[[Problem, Fitted], np.ndarray]) -> None:
    """With this in the place of what fits leave, the input without noise."""
    monkeypatch.setattr(confidence, "left_out", left)
    monkeypatch.setattr(confidence, "noise_kept_out", lambda problem, fits: [0.0] * len(fits))


def test_no_effect_is_ruled_out_and_a_second_one_is_not_needed(problem: Problem, fits: dict[str, Fitted]) -> None:
    found = ConfidenceSet.of(problem, list(fits.values()), {})
    keys = [set(f.hypothesis.key) for f in found.members]
    assert keys[0] == {"coulomb_friction"} and set() not in keys and {"force_bias"} not in keys
    assert found.chances[frozenset()] < 1e-6


def test_what_takes_less_than_half_off_rules_out_no_effect_but_no_other_name(problem, fits, monkeypatch) -> None:
    wave = 3.0 * np.sin(np.arange(len(problem.blocks())))
    left = {frozenset(): 1.3 * wave, frozenset(("hysteresis",)): 1.3 * wave, frozenset(("coulomb_friction",)): wave}
    leaving(monkeypatch, lambda _, fitted: left[fitted.hypothesis.key])
    found = ConfidenceSet.of(problem, [fits[name] for name in ("", "hysteresis", "coulomb_friction")], {})
    assert max(found.chances[frozenset()], found.chances[frozenset(("hysteresis",))]) < confidence.RULED_OUT
    assert {f.hypothesis.key for f in found.members} == {frozenset(("hysteresis",)), frozenset(("coulomb_friction",))}


@pytest.mark.parametrize(("more", "stands"), [(0.0019, True), (0.0021, False)])
def test_a_thousandth_of_what_is_to_be_explained_rules_no_name_out(problem, fits, monkeypatch, more, stands) -> None:
    noise = np.random.default_rng(0).standard_normal(len(problem.blocks()))
    best = noise * np.sqrt(2.0 * problem.samples() / (noise @ noise))  # as much as noise, and that once more
    refit = 30.0 * best
    other = best * np.sqrt(1.0 + more * (refit @ refit - best @ best) / (best @ best))
    left = {frozenset(): refit, frozenset(("hysteresis",)): other, frozenset(("coulomb_friction",)): best}
    leaving(monkeypatch, lambda _, fitted: left[fitted.hypothesis.key])
    found = ConfidenceSet.of(problem, [fits[name] for name in ("", "hysteresis", "coulomb_friction")], {})
    assert found.chances[frozenset(("hysteresis",))] < confidence.RULED_OUT
    assert (frozenset(("hysteresis",)) in found.standing) is stands and frozenset() not in found.standing


def telling(*sets: str) -> ConfidenceSet:
    """A confidence set of these sets of effects."""
    members = tuple(named(*names.split()) for names in sets)
    return ConfidenceSet(members, {f.hypothesis.key: 1.0 for f in members}, members, {})


@pytest.mark.parametrize(
    ("beside", "chance", "depth"),
    [
        *(("stiffness_drift", 0.04, "family"), ("stiffness_drift", 0.06, "law")),
        ("coulomb_friction", 0.04, "law"),  # no kin
    ],
)
def test_a_law_is_no_surer_than_its_family_where_beside_kin_it_does_better_than_chance(beside, chance, depth) -> None:
    held = telling("stiffness_step", f"stiffness_step {beside}")
    held = replace(held, chances={**held.chances, frozenset(["stiffness_step"]): chance})
    assert held.depth(LIBRARY["stiffness_step"]) == depth


def test_kin_that_may_not_be_named_count_as_well() -> None:
    step, both = frozenset(["stiffness_step"]), frozenset(["stiffness_step", "stiffness_drift"])
    held = telling("stiffness_step", "stiffness_step stiffness_drift")
    held = replace(held, chances={step: 0.001, both: 1.0}, members=held.members[:1], unsaid={both: both})
    assert held.depth(LIBRARY["stiffness_step"]) == "family"
    assert replace(held, stood=held.members).depth(LIBRARY["stiffness_step"]) == "law"


@pytest.mark.parametrize(("taken", "depth"), [(2.9, "law"), (3.1, "family")])
def test_kin_that_take_next_to_nothing_of_what_a_law_does_are_no_third_law(taken, depth) -> None:
    step, both = frozenset(["stiffness_step"]), frozenset(["stiffness_step", "stiffness_drift"])
    held = telling("stiffness_step", "stiffness_step stiffness_drift")
    held = replace(held, chances={step: 0.01, both: 1.0}, left={frozenset(): 110.0, step: 10.0, both: 10.0 - taken})
    assert held.depth(LIBRARY["stiffness_step"]) == depth


@pytest.mark.parametrize(
    ("others", "depth"),
    [
        (["coulomb_friction force_bias", "coulomb_friction force_drift"], "law"),
        (["stribeck_friction", "coulomb_friction force_bias"], "family"),
        (["quadratic_drag"], "block"),
        (["hysteresis"], None),
    ],
)
def test_a_name_holds_as_deep_as_every_member_has_it(others: list[str], depth: str | None) -> None:
    assert telling("coulomb_friction", *others).depth(LIBRARY["coulomb_friction"]) == depth


@pytest.mark.parametrize(
    ("rival", "depth"), [("stribeck_friction", "family"), ("quadratic_drag", "block"), ("hysteresis", "block")]
)
def test_a_fit_at_a_bound_that_stands_leaves_no_more_than_the_block_sure(rival: str, depth: str) -> None:
    held = replace(telling("coulomb_friction"), rivals=telling(rival).members)
    assert held.depth(LIBRARY["coulomb_friction"]) == depth


@pytest.mark.parametrize(("drawn", "depth"), [(True, "family"), (False, "block")])
def test_a_law_that_leaves_next_to_nothing_less_than_its_special_case_does_not_speak_against_it(drawn, depth) -> None:
    held = telling("nonlinear_stiffness", "hardening_relaxation")
    draws = frozenset([frozenset(["hardening_relaxation"])]) if drawn else frozenset()
    held = replace(held, drawing=draws)
    assert held.depth(LIBRARY["nonlinear_stiffness"]) == depth
    assert held.depth(LIBRARY["hardening_relaxation"]) == "block"  # the special case does not relax


@pytest.fixture
def held_of(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> Callable[[float], ConfidenceSet]:
    """A confidence set of a cubic spring and a branch that holds it, by how much more the spring leaves.

    As a part of what is explained; chance rules none out.
    """
    noise = np.random.default_rng(0).standard_normal(len(problem.blocks()))
    best = noise * np.sqrt(problem.samples() / (noise @ noise))
    refit = 100.0 * best
    monkeypatch.setattr(confidence, "by_chance", lambda numbers, worse, better, noise: 0.02)
    monkeypatch.setattr(confidence, "chance", lambda problem, before, after, tries: 1.0)
    monkeypatch.setattr(confidence, "turns", lambda problem, fitted: True)
    monkeypatch.setattr(confidence, "off_in_free_space", lambda problem, fitted: 0.0)
    monkeypatch.setattr(confidence, "at_bounds", lambda fitted: frozenset())

    def of(more: float) -> ConfidenceSet:
        size = np.sqrt(1.0 + more * (refit @ refit - best @ best) / (best @ best))
        left = {(): refit, ("nonlinear_stiffness",): size * best, ("hardening_relaxation",): best}
        leaving(monkeypatch, lambda _, fitted: left[fitted.hypothesis.names])
        return ConfidenceSet.of(problem, telling("", "nonlinear_stiffness", "hardening_relaxation").members, {})

    return of


@pytest.mark.parametrize(("more", "draws"), [(0.0019, True), (0.0021, False)])
def test_what_is_next_to_nothing_is_a_five_hundredth_of_what_is_explained(held_of, more, draws) -> None:
    assert held_of(more).drawing == (frozenset([frozenset(["hardening_relaxation"])]) if draws else frozenset())


@pytest.mark.parametrize(
    ("more", "chance", "speaks"),
    [
        *(
            (1e-3, 0.04, True),
            (1e-3, 0.06, False),
            (0.0021, 0.06, True),
        ),  # a little better, by more or less than chance
        *((0.0, 1.0, False), (-1e-6, 1.0, False)),  # no better at all
    ],
)
def test_a_law_that_predicts_no_better_than_its_special_case_but_by_chance_does_not_speak_against_it(
    held_of, monkeypatch, more, chance, speaks
) -> None:
    monkeypatch.setattr(confidence, "by_chance", lambda numbers, worse, better, noise: chance)
    names = {f.hypothesis.names for f in held_of(more).members}
    assert ("nonlinear_stiffness",) in names and (("hardening_relaxation",) in names) is speaks


@pytest.mark.parametrize(("beyond", "stands"), [(0.01, False), (1.0, True)])
def test_what_is_next_to_nothing_beside_the_whole_is_much_where_the_best_leaves_noise_alone(beyond, stands) -> None:
    fits = telling("", "force_drift second_mode", "force_drift viscoelastic_relaxation").members
    noise, best = 1000.0, 1000.0 * (1.0 + beyond)
    costs, chances = [5e6, best, best + 4000.0], [0.0, 1.0, 1e-9]
    found, alike = ConfidenceSet.sifted(fits, costs, chances, {}, noise)
    assert (fits[2].hypothesis.key in found.standing) is stands and fits[2].hypothesis.key in alike


@pytest.mark.parametrize(("unseen", "stands"), [(1e-9, False), (0.02, True)])
def test_what_few_fitted_blocks_speak_against_is_ruled_out_where_held_out_ones_do(
    problem, monkeypatch, unseen, stands
) -> None:
    best = np.random.default_rng(0).standard_normal(len(problem.blocks()))
    leaving(monkeypatch, lambda _, fitted: best if fitted.hypothesis.names else 9.0 * best)
    seen = {True: 1.0, False: 0.05}
    monkeypatch.setattr(confidence, "by_chance", lambda numbers, worse, better, noise: seen[worse is better])
    monkeypatch.setattr(confidence, "chance", lambda problem, before, after, tries: unseen)
    monkeypatch.setattr(confidence, "turns", lambda problem, fitted: True)
    monkeypatch.setattr(confidence, "off_in_free_space", lambda problem, fitted: 0.0)
    monkeypatch.setattr(confidence, "at_bounds", lambda fitted: frozenset())
    believed = ConfidenceSet.of(problem, telling("", "nonlinear_stiffness").members, {})
    assert (frozenset() in believed.standing) == stands


@pytest.mark.parametrize(
    ("off", "out"),
    [
        ({"constant_force": 100.0, "force_bias": 1.0}, {"constant_force"}),
        ({"constant_force": 14.0, "force_bias": 1.0}, set()),
        ({"constant_force": 100.0, "force_bias": 40.0}, set()),
        ({"constant_force": 100.0, "force_bias constant_force": 1.0}, set()),
        ({"": 100.0, "force_bias": 1.0}, set()),
    ],
)
def test_free_space_rules_out_what_misses_its_force_where_no_more_effects_hit_it(
    problem, monkeypatch, off, out
) -> None:
    monkeypatch.setattr(confidence, "off_in_free_space", lambda _, fitted: off[" ".join(fitted.hypothesis.names)])
    fits = [named(*names.split()) for names in off]
    assert {" ".join(fits[i].hypothesis.names) for i in contradicted(problem, fits, [1.0] * len(fits))} == out


def test_what_stands_at_a_bound_is_a_rival_unless_it_draws_a_member(problem, fits, monkeypatch) -> None:
    wave = 3.0 * np.sin(np.arange(len(problem.blocks())))
    single = fits["coulomb_friction"]
    leaving(monkeypatch, lambda _, fitted: wave if fitted.hypothesis.key else 9.0 * wave)
    monkeypatch.setattr(confidence, "at_bounds", lambda fitted: () if fitted is single else ("Fc",))
    some = [fits[""], single, fits["hysteresis"], fits["coulomb_friction force_bias"]]
    held = ConfidenceSet.of(problem, some, {f.hypothesis.key: f.hypothesis.key for f in some[2:]})
    assert held.members == (single,) and held.rivals == (fits["hysteresis"],)


def test_what_was_not_tried_beside_the_rest_of_a_set_counts_for_the_one_in_its_place(fits) -> None:
    pair = fits["coulomb_friction force_bias"]
    untried = (
        "coulomb_friction + force_lag",
        "force_bias + static_friction",
        "contact_gap + end_stop",
        "sets of 3 effects",
    )
    found = {e.name: [other.name for other in _untried_for(e, pair, untried)] for e in pair.hypothesis.effects}
    assert found == {"coulomb_friction": ["static_friction"], "force_bias": ["force_lag"]}
    alone = fits["coulomb_friction"]
    (effect,) = alone.hypothesis.effects
    assert [e.name for e in _untried_for(effect, alone, ("smooth_coulomb_friction",))] == ["smooth_coulomb_friction"]


def test_beside_much_that_has_no_name_a_pair_that_was_not_tried_counts_too(fits) -> None:
    alone = fits["coulomb_friction"]
    (effect,) = alone.hypothesis.effects
    untried = ("smooth_coulomb_friction + force_bias", "coulomb_friction + force_lag")
    found = [[e.name for e in _untried_for(effect, alone, untried, more)] for more in (False, True)]
    assert found == [[], ["force_bias", "smooth_coulomb_friction"]]


def test_a_fit_that_must_not_be_named_rules_out_but_does_not_speak_against(problem, fits) -> None:
    pair = frozenset(("coulomb_friction", "force_bias"))
    some = [fits[""], fits["coulomb_friction"], fits["coulomb_friction force_bias"]]
    held = ConfidenceSet.of(problem, some, {pair: frozenset(("force_bias",))})
    assert [f.hypothesis.key for f in held.members] == [{"coulomb_friction"}]
    alone = ConfidenceSet.of(problem, [fits[""], fits["coulomb_friction force_bias"]], {pair: frozenset(pair)})
    assert [f.hypothesis.key for f in alone.members] == [pair]


@pytest.mark.parametrize(("chance", "depth"), [(1e-3, "family"), (0.05, "law")])
def test_friction_that_sets_in_as_fast_as_any_recording_shows_does_not_rule_out_coulomb_s_law(
    problem, monkeypatch, chance, depth
) -> None:
    """It leaves half as much, so it is the best; it is Coulomb friction by its own number, and that keeps its name."""
    noise = np.random.default_rng(0).standard_normal(len(problem.blocks()))
    best = noise * np.sqrt(problem.samples() / (noise @ noise))
    size = {"": 100.0, "coulomb_friction": 2.0, "smooth_coulomb_friction": 1.0}
    leaving(monkeypatch, lambda _, fitted: size[" ".join(fitted.hypothesis.names)] * best)
    monkeypatch.setattr(confidence, "turns", lambda problem, fitted: True)
    monkeypatch.setattr(confidence, "off_in_free_space", lambda problem, fitted: 0.0)
    for module in (confidence, exchange):
        monkeypatch.setattr(module, "at_bounds", lambda fitted: frozenset())
    monkeypatch.setattr(confidence, "in_most_blocks", lambda numbers, worse, better, noise: 1.0)
    monkeypatch.setattr(confidence, "_with_unseen", lambda problem, fitted, best, seen: seen)
    monkeypatch.setattr(
        confidence, "by_chance", lambda _, one, other, noise: chance if one @ one > other @ other else 1
    )
    smooth = frozenset(["smooth_coulomb_friction"])
    monkeypatch.setattr(exchange, "absent", lambda problem, fitted: smooth)
    held = ConfidenceSet.of(problem, telling(*size).members, {smooth: smooth})
    assert {"coulomb_friction"} in [f.hypothesis.key for f in held.members]
    assert replace(held, members=held.members[-1:]).depth(LIBRARY["coulomb_friction"]) == depth


def test_a_lag_that_filters_the_noise_of_the_input_does_not_rule_the_delay_out_for_that() -> None:
    delayed = problem_of(recorded(("time_delay", (("delay", 0.004),)), seconds=12.0), model())
    start = {"time_delay": {"delay": 0.004}, "force_lag": {"tau": 0.005}}
    hypotheses = [beside(*names) for names in ((), ("time_delay",), ("force_lag",))]
    base, delay, lag = fits = [delayed.fit(hypothesis, hypothesis.vector({}, start)) for hypothesis in hypotheses]
    tracks = delayed.tracks
    through = ([noise_through(track, f.model, np.random.default_rng(5)) for track in tracks] for f in (delay, lag))
    gap = sum(
        replace(delayed, tracks=(track,)).samples() * (a**2 - b**2) / track.floor**2
        for track, a, b in zip(tracks, *through, strict=True)
    )
    kept_out = noise_kept_out(delayed, fits)
    assert kept_out[1] == 0.0 and kept_out[2] == pytest.approx(gap, rel=0.3) and gap > 5.0
    found = ConfidenceSet.of(delayed, fits, {})
    assert found.members[0] is delay and found.chances[base.hypothesis.key] < 1e-3


def test_a_friction_is_not_held_to_the_noise_that_another_one_lets_through() -> None:
    delayed = problem_of(recorded(("time_delay", (("delay", 0.004),)), seconds=12.0), model())
    friction = {"coulomb_friction": {"Fc": 0.3}, "static_friction": {"Fs": 0.3, "Fd": 0.3, "v_d": 1e-4}}
    values = {"time_delay": {"delay": 0.004}, "force_lag": {"tau": 0.02}, **friction}
    sets = ("time_delay", "coulomb_friction"), ("force_lag", "coulomb_friction"), ("force_lag", "static_friction")
    hypotheses = [beside(*names) for names in sets]
    fits = [delayed.at(hypothesis, hypothesis.vector({}, values)) for hypothesis in hypotheses]
    delay, lag, other = noise_kept_out(delayed, fits)
    assert delay == 0.0 and lag > 5.0 and other == 0.0


@pytest.mark.parametrize(("won", "lost", "stands"), [(14, 1, True), (11, 0, True), (8, 0, False), (10, 3, False)])
def test_what_is_the_better_one_in_most_blocks_is_not_ruled_out_by_a_few(problem, fits, monkeypatch, won, lost, stands):
    numbers = problem.blocks()
    rng, size = np.random.default_rng(6), np.full(numbers.max() + 1, 3.0)
    best = 3.0 * rng.standard_normal(len(numbers))
    size[:won], size[won : won + lost], size[-1] = 0.3, 10.0, 300.0
    other = size[numbers] * rng.standard_normal(len(numbers))
    left = {frozenset(): 400.0 * best, frozenset(("hysteresis",)): other, frozenset(("coulomb_friction",)): best}
    leaving(monkeypatch, lambda _, fitted: left[fitted.hypothesis.key])
    found = ConfidenceSet.of(problem, [fits[name] for name in ("", "hysteresis", "coulomb_friction")], {})
    assert ({"hysteresis"} in [set(f.hypothesis.key) for f in found.stood]) is stands
