"""The search names what another engine concealed, one effect or two, and no candidate fits worse without being told."""

import math
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from unittest import mock

import numpy as np
import pytest
from search_samples import BIAS, CUBIC, ENOUGH, LAG, NOMINAL, SLIGHT, SOME, fitted_base
from trial_samples import BASE, COULOMB, FORCE_NOISE, model, problem_of, recorded

from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.search.name import LEVELS, _one_more, _origins, _seeds, search
from mmt_drake.diagnosis.search.starts import Seed, Start, added, all_starts
from mmt_drake.diagnosis.search.watch import SearchSetup, Stage, Watch
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import MmtError


@dataclass(frozen=True)
class Searched:
    """A recording, the fit of the model without effects, and what the search found."""

    problem: Problem
    base: Fitted
    levels: list[list[Fitted]]
    told: list[Stage]

    def ratio(self, fitted: Fitted) -> float:
        return math.sqrt(fitted.cost / self.problem.samples())


def searched(*effects, nominal=NOMINAL, library=SOME, threads=1, seed=4, watch=None) -> Searched:
    problem, base, scales = fitted_base(*effects, nominal=nominal, seed=seed)
    told: list[Stage] = []
    with ThreadPoolExecutor(threads) as executor:
        setup = SearchSetup(problem, library, scales, executor, watch or Watch(on_stage=told.append))
        levels = search(setup, base, enough=lambda f: f.cost <= ENOUGH**2 * problem.samples())
    return Searched(problem, base, levels, told)


@pytest.fixture(scope="module")
def pair() -> Searched:
    """Two effects, either plain."""
    return searched(BIAS, CUBIC)


@pytest.fixture(scope="module")
def unequal() -> Searched:
    """Two effects of which one shows twenty-five times as much as the other."""
    return searched(BIAS, SLIGHT, seed=0)


def test_a_range_that_one_sample_in_two_hundred_exceeds_is_found():
    force = np.abs(np.concatenate([recorded(seed=4)[f"force_{axis}"] for axis in "xy"]))
    limit = float(np.quantile(force, 0.995))
    found = searched(("force_saturation", (("limit", limit),)), library=[*SOME, LIBRARY["force_saturation"]])
    best = found.levels[0][0]
    assert best.hypothesis.names == ("force_saturation",)
    assert best.hypothesis.effect_values(best.x)["force_saturation"]["limit"] == pytest.approx(limit, rel=0.01)


def test_what_there_was_no_time_for_is_told_and_not_begun_and_what_promises_most_comes_first():
    watch = Watch(seconds=0.0)
    found = searched(CUBIC, LAG, watch=watch)
    assert [[f.hypothesis.names for f in level] for level in found.levels] == [[("nonlinear_stiffness",)]]
    assert set(watch.missed) == {"force_bias", "coulomb_friction", "force_lag", "sets of 2 effects"}


class HastyAtFirst(Watch):
    """Its time is over within every share of it, until what was missed is taken up."""

    shares, waits = 0, True

    @contextmanager
    def within(self, share: float) -> Iterator[None]:
        self.shares += 1
        yield
        self.shares -= 1

    def is_late(self) -> bool:
        return self.waits and self.shares > 0

    def took_up(self) -> tuple[str, ...]:
        self.waits = False
        return super().took_up()


def test_where_one_effect_explains_enough_the_time_of_pairs_is_that_of_single_ones_that_were_missed():
    watch = HastyAtFirst()
    found = searched(CUBIC, watch=watch)
    (singles,) = found.levels
    assert {f.hypothesis.names for f in singles} == {(effect.name,) for effect in SOME} and not watch.missed


def test_a_first_answer_with_the_effect_in_it_is_told_once_before_the_search_ends():
    answers: list[str] = []
    searched(BIAS, CUBIC, watch=Watch(on_answer=answers.append))
    (answer,) = answers
    assert answer.startswith("so far ") and "force_bias" in answer


@pytest.mark.parametrize("concealed", [BIAS, CUBIC, COULOMB, LAG], ids=lambda effect: effect[0])
def test_a_concealed_effect_is_found_with_its_size_and_leaves_the_noise(concealed):
    name, values = concealed
    found = searched(concealed)
    assert len(found.levels) == 1  # one is enough
    best, *others = found.levels[0]
    assert best.hypothesis.names == (name,) and found.ratio(best) < ENOUGH < 2.0 < found.ratio(found.base)
    assert found.problem.ratio(best.model, best.skew, heldout=True) < ENOUGH
    truth = best.hypothesis.vector({s: model().parameter(s) for s in best.hypothesis.free}, {name: dict(values)})
    standard_error = np.sqrt(np.diag(np.linalg.inv(best.minimum.jacobian.T @ best.minimum.jacobian)))
    # The input's noise is not white, which these errors do not know: they are too small by about two.
    assert np.all(np.abs(best.x - truth) < 8.0 * standard_error)
    j = next(i for i, place in enumerate(best.hypothesis.free_parameters()) if place.effect == name)
    assert standard_error[j] < 0.1 * truth[j]
    assert all(found.ratio(other) > 1.2 * found.ratio(best) for other in others)
    assert {other.hypothesis.names for other in others} | {(name,)} == {(effect.name,) for effect in SOME}
    assert [f.cost for f in found.levels[0]] == sorted(f.cost for f in found.levels[0])


def test_two_effects_are_found_together(pair):
    assert len(pair.levels) == 2
    best = pair.levels[1][0]
    assert best.hypothesis.key == {"force_bias", "nonlinear_stiffness"} and pair.ratio(best) < ENOUGH
    values = best.hypothesis.effect_values(best.x)
    assert values["force_bias"]["bias"] == pytest.approx(0.3, rel=0.02)
    symbols = [place.symbol for place in best.hypothesis.free_parameters()]
    low, high = intervals(pair.problem, best)[symbols.index("k3")]
    assert low < 4e6 < high and high - low < 0.4 * 4e6
    assert pair.ratio(pair.levels[0][0]) > 2.0


@pytest.fixture(scope="module")
def triple() -> Searched:
    """Three effects, each plain."""
    return searched(BIAS, CUBIC, LAG)


def test_three_effects_are_found_together_and_each_of_them_is_needed(triple):
    assert len(triple.levels) == 3
    best = triple.levels[2][0]
    assert best.hypothesis.key == {"force_bias", "nonlinear_stiffness", "force_lag"} and triple.ratio(best) < ENOUGH
    values = best.effect_values
    assert values["force_bias"]["bias"] == pytest.approx(0.3, rel=0.02)
    assert values["force_lag"]["tau"] == pytest.approx(0.01, rel=0.05)
    fewer = {f.hypothesis.key: triple.ratio(f) for f in triple.levels[1]}
    assert all(fewer[best.hypothesis.key - {name}] > 2.0 * triple.ratio(best) for name in best.hypothesis.names)


@pytest.mark.parametrize(("part", "count"), [(0.25, 3), (0.05, 2)])
def test_a_third_effect_is_kept_only_where_it_takes_nearly_all_of_the_rest(part, count, monkeypatch):
    monkeypatch.setattr("mmt_drake.diagnosis.search.name._TAKES_NEARLY_ALL", part)
    effects = (BIAS, CUBIC, ("force_lag", (("tau", 0.006),)))
    # A delay stands for the lag, of which it takes nine tenths.
    library = [*(effect for effect in SOME if effect.name != "force_lag"), LIBRARY["time_delay"]]
    found = searched(*effects, library=library)
    assert len(found.levels) == count and LEVELS[2] in {stage.name for stage in found.told}


def test_beside_sets_that_gained_nothing_no_further_effect_is_sought(pair):
    (fewer, *_), (best, *_) = pair.levels
    lost = replace(best, minimum=replace(best.minimum, residual=2.0 * fewer.minimum.residual))
    assert not _seeds(pair.problem, [lost], fewer.cost)
    worse = replace(fewer, minimum=replace(fewer.minimum, residual=4.0 * fewer.minimum.residual))
    setup = SearchSetup(pair.problem, SOME, None, None, Watch())
    with mock.patch("mmt_drake.diagnosis.search.name._seeds", return_value=[]):
        assert _one_more(setup, [], [[worse], [lost]], lambda fitted: False) == []


@pytest.mark.parametrize("which", ["pair", "unequal", "triple"])
def test_nothing_fits_worse_than_what_it_adds_to(which, request):
    # Nested models: the larger one can do whatever the smaller one can.
    found = request.getfixturevalue(which)
    before = [found.base]
    for level in found.levels:
        for fitted in level:
            within = [f.cost for f in before if f.hypothesis.key < fitted.hypothesis.key]
            told = f"{' + '.join(fitted.hypothesis.names)}: {found.ratio(fitted):.3f}"
            assert fitted.cost <= 1.001 * min(within), told
        before = level


def test_a_slight_effect_is_found_beside_a_plain_one(unequal):
    best = unequal.levels[1][0]
    assert best.hypothesis.key == {"force_bias", "nonlinear_stiffness"} and unequal.ratio(best) < ENOUGH


def test_what_leaves_much_more_than_enough_goes_no_further_unless_it_lost_what_it_was_added_to():
    problem, base, scales = fitted_base(CUBIC)
    (seed,) = Seed.on_parts(base, [problem])
    start = all_starts([seed], [LIBRARY["force_bias"]], scales)[0]
    looked = start.screened()
    assert looked is not None and looked.cost <= base.cost
    assert start.widened(problem, looked, most=0.5 * looked.cost) is looked
    far = looked.hypothesis.vector({}, {"force_bias": {"bias": 5.0}})
    lost = problem.unchanged(looked.hypothesis, far)
    assert lost.cost > base.cost
    found = start.widened(problem, lost, most=0.5 * looked.cost)
    assert found is not None and found.cost <= base.cost


def test_every_number_of_effects_is_a_set_once(pair):
    for count, level in enumerate(pair.levels, start=1):
        keys = [fitted.hypothesis.key for fitted in level]
        assert len(set(keys)) == len(keys) and {len(key) for key in keys} == {count}
    alone = [stage for stage in pair.told if stage.name == LEVELS[0] and stage.now.startswith("a first look")]
    assert {"force_bias", "force_lag", "coulomb_friction", "nonlinear_stiffness"} <= {s.now.split()[-1] for s in alone}
    assert alone[-1].done == alone[-1].total > 4, "it says how far it is"


def test_where_only_noise_is_left_nothing_is_gained():
    found = searched(nominal=model(), library=SOME[:3])
    assert found.ratio(found.base) < ENOUGH and len(found.levels) == 1
    assert found.levels[0][0].cost > 0.95 * found.base.cost


def test_no_pair_is_sought_where_chance_does_as_much_as_any_single_effect():
    problem, base, scales = fitted_base()
    with ThreadPoolExecutor(1) as executor:
        setup = SearchSetup(problem, SOME, scales, executor, Watch())
        levels = search(setup, base, enough=lambda _: False)
    assert len(levels) == 1 and not setup.watch.missed


def test_threads_change_nothing():
    one, two = (searched(BIAS, library=SOME[:2], threads=threads) for threads in (1, 2))
    for a, b in zip(one.levels[0], two.levels[0], strict=True):
        assert a.hypothesis.names == b.hypothesis.names
        np.testing.assert_array_equal(a.x, b.x)


def test_attempts_are_every_start_of_all_that_can_be_added_from_every_fit():
    problem, base, scales = fitted_base(BIAS)
    nominal = problem.at(base.hypothesis, base.hypothesis.base())
    library = [LIBRARY[name] for name in ("force_bias", "viscous_friction", "contact_gap")]
    tries = all_starts([Seed(fitted, problem, fitted) for fitted in (base, nominal)], library, scales)
    starts = len(library[0].starts(scales)) + len(library[2].starts(scales))  # viscous: b1 is not 0, so no second name
    assert len(tries) == 2 * starts and {t.effect.name for t in tries} == {"force_bias", "contact_gap"}
    assert {id(t.seed.fitted) for t in tries} == {id(base), id(nominal)}
    screened = tries[0].screened()
    assert screened is not None and screened.cost < 0.2 * base.cost


def test_of_the_starts_of_a_moment_those_about_when_it_happened_promise_most():
    problem, base, scales = fitted_base(("mass_change", (("time", 8.0), ("dm", 0.3))))
    starts = all_starts([Seed(base, problem, base)], [LIBRARY["mass_change"]], scales)
    promised = {start.promise(): start.values for start in starts}
    best = promised[max(promised)]
    assert abs(best["time"] - 8.0) < scales.duration / 21.0 and best["dm"] > 0.0
    assert max(promised) > 0.5 > 10.0 * float(np.median(list(promised)))


def test_what_effects_did_alone_says_which_two_leave_least_and_how_much():
    delayed, drifting = ("time_delay", (("delay", 0.03),)), ("force_drift", (("rate", 0.03),))
    problem, base, scales = fitted_base(delayed, drifting)
    singles = {}
    for name in ("time_delay", "force_drift", "force_lag", "force_bias", "nonlinear_stiffness", "viscous_friction"):
        starts = all_starts([Seed(base, problem, base)], [LIBRARY[name]], scales)
        found = [fitted for start in starts if (fitted := start.widened(problem, None)) is not None]
        tried = [problem.fit(f.hypothesis, f.x, steps=20) for f in found]
        singles |= {name: min(tried, key=lambda f: f.cost)} if tried else {}
    (left, one, other), *others = added(base, singles.values())
    assert {*one.hypothesis.names, *other.hypothesis.names} == {"time_delay", "force_drift"}
    assert left < 0.1 * one.cost and left < 0.1 * other.cost and left < 0.2 * others[0][0]
    (late,) = all_starts(
        [Seed(singles["force_drift"], problem, singles["force_drift"])], [LIBRARY["time_delay"]], scales
    )[:1]
    assert late.promise() < 0.5, "first derivatives do not show it: the damper has made up for the delay"


@pytest.mark.parametrize("name", ["torque_ripple", "periodic_disturbance"])
def test_one_start_of_a_phase_wants_its_effect_with_the_sign_that_it_has(name):
    scales = fitted_base()[2]
    for phase in np.linspace(-3.0, 3.0, 13):
        apart = [math.cos(values["phase"] - phase) for values in LIBRARY[name].starts(scales)]
        assert max(apart) >= math.sqrt(0.5) - 1e-12


def test_a_start_that_no_model_can_have_is_left_out():
    problem, base, _ = fitted_base(BIAS)
    seed = Seed(base, problem, base)
    impossible = Start(seed, LIBRARY["mass_change"], {"time": 1.0, "dm": -500.0})
    assert impossible.screened() is None and impossible.promise() == 0.0
    assert Start(seed, LIBRARY["hysteresis"], {"alpha": 1e9, "beta": 1.0}).screened() is None


def test_beside_a_fit_that_bounds_hold_the_numbers_handed_in_are_an_origin_whatever_they_cost():
    true = {"m": 0.3, "k2": 886.0, "b1": 0.0, "b2": 34.0}
    missing = {"end_stop": {"position": 0.0113, "side": 1.0, "stiffness": 281.0}, "viscous_friction": {"b": 24.0}}
    session = ContactSession(seed=2, noise=FORCE_NOISE, duration=15.0)
    recording = session.record({**BASE, **true}, tuple(Concealed(name, values) for name, values in missing.items()))
    problem = problem_of(recording, model(**true))
    hypothesis = Hypothesis(model(**true), 0.0)
    base = problem.fit(hypothesis, hypothesis.base())
    nominal = problem.at(base.hypothesis, base.hypothesis.base())
    assert at_bounds(base) >= {"m", "k2"} and base.cost < nominal.cost < 1.1 * base.cost
    assert {origin.fitted.cost for origin in _origins(problem, base)} == {base.cost, nominal.cost}


def test_a_seed_is_screened_on_those_parts_alone_where_it_can_be_simulated():
    problem, base, _ = fitted_base(CUBIC)

    class Diverging(Problem):
        def objective(self, model, skew):
            raise MmtError("the simulation diverges")

    diverging = Diverging(problem.tracks, problem.coarse)
    assert [seed.part for seed in Seed.on_parts(base, [diverging, problem])] == [problem]
    assert Seed.on_parts(base, [diverging], steps=2) == []
    assert [seed.part for seed in Seed.on_parts(base, [diverging], steps=2, instead=problem)] == [problem]
