"""Concealed friction is found as it is, a vector in the plane or one for each axis, where the model does not say."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from diagnosis_samples import MODEL, Strokes
from trial_samples import problem_of

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import scales_of
from mmt_drake.diagnosis.fit.problem import Problem
from mmt_drake.diagnosis.fit.validate import absent
from mmt_drake.diagnosis.search.base import fit_base
from mmt_drake.diagnosis.search.in_plane import fit_near, said
from mmt_drake.diagnosis.search.minima import at_the_limit, the_other_friction
from mmt_drake.diagnosis.search.screening import screen
from mmt_drake.diagnosis.search.starts import Seed, all_starts
from mmt_drake.diagnosis.search.watch import SearchSetup, Watch
from mmt_drake.diagnosis.tell.written import augmented_model
from mmt_drake.effects import LIBRARY
from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed
from mmt_drake.simulation import simulate

TIME, LEVEL, NOISE = np.arange(6000) * 0.002, 0.4, 0.01
UNSAID = replace(MODEL, in_plane=None)
LIBRARY_HERE = [LIBRARY[name] for name in ("coulomb_friction", "nonlinear_stiffness", "force_bias")]


def rubbed(friction: str) -> Recording:
    """Both axes stroked at once, friction of one kind or the other concealed."""
    along, across, still = Strokes(1), Strokes(2), np.zeros_like(TIME)
    motion = {"position_x": along.y(TIME), "position_y": across.y(TIME), "position_z": still - 0.006}
    rate = {"velocity_x": along.y(TIME, 1), "velocity_y": across.y(TIME, 1), "velocity_z": still}
    truth = replace(MODEL, parameters=replace(MODEL.parameters, Fc=LEVEL), in_plane=friction)
    forces = simulate(truth, completed(TIME, {**motion, **rate}, "hand", forces=False))
    rng = np.random.default_rng(3)
    measured = {f"force_{axis}": forces[f"force_{axis}"] + rng.normal(0.0, NOISE, len(TIME)) for axis in "xyz"}
    return completed(TIME, {**motion, **rate, **measured}, "contact")


@pytest.mark.parametrize("friction", ["vector", "per_axis"])
def test_friction_is_delivered_as_what_it_is(friction):
    outcome = diagnose([rubbed(friction)], UNSAID, library=LIBRARY_HERE)
    (found,) = outcome.diagnosis.effects
    assert (outcome.diagnosis.verdict, found.name) == ("missing_physics", "coulomb_friction")
    assert found.parameters["Fc"].value == pytest.approx(LEVEL, rel=0.02)
    assert outcome.best is not None
    assert augmented_model(outcome.best)["friction"] == friction


def test_friction_that_nobody_said_is_what_it_is_beside_numbers_ten_times_off():
    right = MODEL.parameters
    crude = replace(right, m=9.0 * right.m, k2=0.1 * right.k2, b1=0.1 * right.b1, b2=0.1 * right.b2, Fc=0.1 * LEVEL)
    believed = replace(UNSAID, parameters=crude)
    problem = problem_of(rubbed("vector"), believed)
    # A fit from the numbers handed in alone is caught on the way.
    assert said(problem, believed, partial(fit_near, problem, 0.0))[0].in_plane == "per_axis"
    with ThreadPoolExecutor(1) as executor:
        chosen, found = said(problem, believed, lambda friction: fit_base(problem, friction, 0.0, executor)[1])
    assert chosen.in_plane == "vector" and found.cost <= 1.2 * problem.samples()
    assert found.structure_values["k2"] == pytest.approx(right.k2, rel=0.02)


@pytest.fixture(scope="module")
def problem() -> Problem:
    return problem_of(rubbed("per_axis"), UNSAID)


def test_friction_is_screened_as_what_it_is_before_any_law_is_left_behind(problem):
    hypothesis = Hypothesis(UNSAID)
    base = problem.fit(hypothesis, hypothesis.base())
    laws = [LIBRARY[name] for name in ("coulomb_friction", "smooth_coulomb_friction", "dahl_friction")]
    with ThreadPoolExecutor(1) as executor:
        setup = SearchSetup(problem, laws, scales_of(problem, base.model), executor, Watch())
        found = screen(setup, all_starts(Seed.on_parts(base, problem.eased(base)), laws, setup.scales))
    left = {s.fitted.hypothesis.names[0]: problem.left(s.fitted) for s in reversed(found)}
    assert left["coulomb_friction"] < 1.1 * left["smooth_coulomb_friction"] < 0.2 * problem.left(base)


@pytest.mark.parametrize("special", ["smooth_coulomb_friction", "dahl_friction"])
def test_a_law_at_its_limit_is_the_simpler_law_and_not_named(problem, special):
    at_once = {"Fc": LEVEL, "v_s": 1e-9, "sigma": 1e6}
    hypothesis = Hypothesis(replace(UNSAID, in_plane="per_axis")).adding(LIBRARY[special])
    fitted = problem.unchanged(hypothesis, hypothesis.vector({}, {special: at_once}))
    assert absent(problem, fitted) == {special}
    best, *_ = at_the_limit(problem, LIBRARY_HERE, [fitted])
    assert best.hypothesis.names == ("coulomb_friction",) and problem.left(best) < 1.1


def test_a_break_away_at_the_level_of_sliding_is_tried_as_friction_of_that_level(problem):
    hypothesis = Hypothesis(replace(UNSAID, in_plane="per_axis")).adding(LIBRARY["static_friction"])
    level = {"Fs": 1.1 * LEVEL, "Fd": LEVEL, "v_d": 1e-4}
    fitted = problem.unchanged(hypothesis, hypothesis.vector({}, {"static_friction": level}))
    found = {f.hypothesis.names: f for f in at_the_limit(problem, [LIBRARY["coulomb_friction"]], [fitted])}
    assert found["coulomb_friction",].effect_values["coulomb_friction"]["Fc"] == pytest.approx(LEVEL, rel=0.02)
    assert problem.left(found["coulomb_friction",]) < 1.1


@pytest.mark.parametrize("unsaid", [True, False])
def test_friction_that_was_guessed_before_anything_was_found_is_guessed_again(problem, unsaid):
    hypothesis = Hypothesis(replace(UNSAID, in_plane="vector")).adding(LIBRARY["coulomb_friction"])
    guessed = problem.fit(hypothesis, hypothesis.vector({}, {"coulomb_friction": {"Fc": LEVEL}}))
    assert problem.left(guessed) > 2.0
    with ThreadPoolExecutor(1) as executor:
        scales = scales_of(problem, guessed.model)
        setup = SearchSetup(problem, LIBRARY_HERE, scales, executor, Watch(), friction_unsaid=unsaid)
        (found,) = the_other_friction(setup, [guessed])
    assert (problem.left(found) < 1.1) is unsaid and (found is guessed) is not unsaid
    assert found.hypothesis.nominal == replace(UNSAID, in_plane="per_axis" if unsaid else "vector")
