"""Better minima: a set with one effect less, simpler and other laws in the place of one, and windows on the way."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from search_samples import BIAS, CUBIC, ENOUGH, fitted_base
from trial_samples import CARRIAGE, COULOMB, cut, problem_of

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare, scales_of
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.search.minima import kin, other_numbers, prune, random_restarts, simplify
from mmt_drake.diagnosis.search.screening import screen
from mmt_drake.diagnosis.search.starts import Seed, all_starts
from mmt_drake.diagnosis.search.watch import SearchSetup, Watch
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import MmtError
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact


def test_an_effect_that_only_made_up_for_a_poor_fit_of_another_one_is_pruned():
    problem, base, _ = fitted_base(CUBIC)
    both = base.hypothesis.adding(LIBRARY["force_bias"]).adding(LIBRARY["nonlinear_stiffness"])
    fitted = problem.fit(both, both.vector({}, {"force_bias": {"bias": 0.01}, "nonlinear_stiffness": {"k3": 3e6}}))
    with ThreadPoolExecutor(1) as executor:
        single, other = sorted(prune(problem, fitted, executor), key=lambda f: f.cost)
    assert single.hypothesis.names == ("nonlinear_stiffness",) and other.hypothesis.names == ("force_bias",)
    assert single.cost < 1.05 * fitted.cost < 0.5 * other.cost


@pytest.mark.parametrize(
    ("second", "taken_for", "values"),
    [
        (COULOMB, "asymmetric_friction", {"Fc_plus": 0.4, "Fc_minus": 0.4}),
        (("ground_spring", (("k", 30.0),)), "end_stop", {"position": -0.2, "stiffness": 30.0}),
    ],
    ids=["friction that is equal both ways", "a wall that is never left"],
)
def test_beside_a_second_effect_a_law_gives_way_to_the_special_case_that_it_is(second, taken_for, values):
    problem, base, scales = fitted_base(BIAS, second)
    hypothesis = base.hypothesis.adding(LIBRARY["force_bias"], {}).adding(LIBRARY[taken_for], {})
    start = hypothesis.vector(
        base.hypothesis.structure_values(base.x), {"force_bias": {"bias": 0.3}, taken_for: values}, base.skew
    )
    library = [LIBRARY[name] for name in ("coulomb_friction", "ground_spring", "force_lag", taken_for)]
    with ThreadPoolExecutor(1) as executor:
        found = simplify(SearchSetup(problem, library, scales, executor, Watch()), [problem.fit(hypothesis, start)])
    keys = {f.hypothesis.key: f for f in found}
    simple = keys[frozenset({"force_bias", second[0]})]
    assert simple.cost < ENOUGH**2 * problem.samples()
    assert not any("force_lag" in key for key in keys)


def test_other_numbers_of_the_object_that_explain_more_are_found():
    base = {"m": 0.84, "k1": 173.6, "k2": 395.4, "b1": 35.08, "b2": 44.01, "Fc": 0.0}
    session = ContactSession(seed=1892859455, noise=0.0172, velocity=False)
    recording = session.record({**base, "normal_k": 515.3, "normal_b": 10.6}, ())
    prepared = prepare([recording], FlexibleBoxModel(BoxParameters(**base), NormalContact(515.3, 10.6)))
    hypothesis = Hypothesis(FlexibleBoxModel(BoxParameters(**base), NormalContact(515.3, 10.6)), prepared.skew)
    others = {"m": 0.85, "k1": 149.2, "k2": 630.0, "b1": 29.8, "b2": 39.2}
    wrong = prepared.problem.fit(
        hypothesis, hypothesis.vector({**hypothesis.structure_values(hypothesis.base()), **others}, {})
    )
    assert wrong.structure_values["k2"] > 550.0 and wrong.minimum.converged  # no way down from there
    with ThreadPoolExecutor(1) as executor:
        found = other_numbers(prepared.problem, wrong, executor)
        assert other_numbers(prepared.problem, found, executor) is found
    assert found.structure_values["k2"] == pytest.approx(base["k2"], rel=0.05)


def test_a_law_of_friction_whose_own_starts_end_far_off_is_found_from_the_numbers_of_its_kin():
    problem, base, scales = fitted_base(("static_friction", (("Fd", 0.3), ("Fs", 2.0), ("v_d", 0.01))))
    hypothesis = base.hypothesis.adding(LIBRARY["stribeck_friction"], {})
    start = base.numbers_for(hypothesis, {"stribeck_friction": {"Fs": 1.9, "v_s": 0.005}})
    taken_for = problem.fit(hypothesis, start)
    library = [LIBRARY[name] for name in ("stribeck_friction", "static_friction", "force_lag")]
    with ThreadPoolExecutor(1) as executor:
        setup = SearchSetup(problem, library, scales, executor, Watch())
        own = screen(setup, all_starts([Seed(base, problem, base)], [LIBRARY["static_friction"]], scales))
        found = kin(setup, [taken_for])
    assert problem.left(taken_for) > 5.0 and problem.left(own[0].fitted) > 50.0
    assert [f.hypothesis.names for f in found] == [("static_friction",), ("stribeck_friction",)]
    assert problem.left(found[0]) < ENOUGH


def test_a_law_that_alone_keeps_an_object_stable_is_simplified_from_the_numbers_handed_in(monkeypatch):
    problem, base, scales = fitted_base(BIAS, COULOMB)
    hypothesis = base.hypothesis.adding(LIBRARY["force_bias"], {}).adding(LIBRARY["asymmetric_friction"], {})
    values = {"force_bias": {"bias": 0.3}, "asymmetric_friction": {"Fc_plus": 0.4, "Fc_minus": 0.4}}
    best = problem.fit(hypothesis, hypothesis.vector(base.structure_values, values, base.skew))
    diverging, at = best.structure_values, Problem.at

    def unstable(self: Problem, hypothesis: Hypothesis, x) -> Fitted:
        if hypothesis.structure_values(x) == diverging:
            raise MmtError("the simulation diverges at the start of a fit")
        return at(self, hypothesis, x)

    monkeypatch.setattr(Problem, "at", unstable)
    library = [LIBRARY[name] for name in ("coulomb_friction", "asymmetric_friction")]
    with ThreadPoolExecutor(1) as executor:
        found = simplify(SearchSetup(problem, library, scales, executor, Watch()), [best])
    assert frozenset({"force_bias", "coulomb_friction"}) in {f.hypothesis.key for f in found}


@pytest.mark.parametrize("seed", [18, 33])
def test_a_body_that_sticks_and_slips_is_fitted_by_way_of_windows(seed):
    true, law = {"m": 2.3, "b": 6.7, "k": 177.0, "Fc": 1.55}, {"Fs": 2.7, "v_s": 0.0215}
    whole = DrivenSession(seed, noise=2e-5).record({**CARRIAGE, **true}, (Concealed("stribeck_friction", law),))
    believed = DrivenBodyModel(**{**true, "Fc": 1.9})
    problem = problem_of(cut(whole, slice(0, None, 2)), believed)
    base = problem.fit(Hypothesis(believed, 0.0), Hypothesis(believed, 0.0).base())
    hypothesis = base.hypothesis.adding(LIBRARY["stribeck_friction"], {})
    start = base.numbers_for(hypothesis, {"stribeck_friction": {"Fs": 2.6, "v_s": 0.03}})
    caught = problem.fit(hypothesis, start)
    with ThreadPoolExecutor(1) as executor:
        setup = SearchSetup(problem, [], scales_of(problem, base.model), executor, Watch())
        found = random_restarts(setup, [caught])
    assert problem.left(caught) > 50.0 and problem.left(found[0]) < ENOUGH
    assert found[0].effect_values["stribeck_friction"] == pytest.approx(law, rel=0.01)
