"""The shape of a missing law is learned over the signal that it depends on, and kept only where that helps."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from residual_samples import PLAIN, leaving, strokes

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.search.learn import Learned, more_branches, other_curves, tables, worth_while
from mmt_drake.diagnosis.search.watch import Watch
from mmt_drake.diagnosis.tell import document
from mmt_drake.effects import LIBRARY
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.recording import Recording

DRAG, FC = 5.0, 0.2


@cache
def learned(effect: str = "", **values: float) -> tuple[Problem, Fitted, list[Learned]]:
    """Strokes on the box with an effect, the fit without it, and the tables learned of what that leaves."""
    hypothesis = PLAIN.adding(LIBRARY[effect]) if effect else PLAIN
    given: Mapping[str, Mapping[str, float]] = {effect: values} if effect else {}
    problem = leaving(strokes(), model=hypothesis.model(hypothesis.vector({}, given)))
    refit = problem.fit(PLAIN, PLAIN.base())
    with ThreadPoolExecutor(1) as executor:
        return problem, refit, tables(problem, refit, executor)


@pytest.mark.parametrize(
    ("effect", "values", "signals"),
    [
        ("quadratic_drag", {"c": DRAG}, {"sliding_velocity"}),
        ("coulomb_friction", {"Fc": FC}, {"friction_over_time", "friction_over_position", "load"}),  # a constant each
        ("stiffness_drift", {"rate": 0.02}, {"stiffness_over_time"}),
    ],
)
def test_the_table_that_fits_best_is_over_the_signal_that_the_law_depends_on(effect, values, signals):
    problem, refit, found = learned(effect, **values)
    assert found[0].values["of"] in signals
    assert found[0].fitted.cost == min(table.fitted.cost for table in found) < 0.15 * refit.cost
    kept = worth_while(problem, refit, found)
    assert kept is not None and kept.values == found[0].values


def test_a_table_over_velocity_with_the_damper_beside_it_is_the_law_within_its_interval():
    table = learned("quadratic_drag", c=DRAG)[2][0]
    v, value = (np.array(table.values[key]) for key in ("at", "value"))
    damper = table.fitted.hypothesis.structure_values(table.fitted.x)["b1"] - PLAIN.nominal.parameter("b1")
    error = value + damper * v - DRAG * v * np.abs(v)
    assert np.mean(np.abs(error) <= table.half_width) >= 0.9
    assert np.abs(error).max() < 0.1 * DRAG * np.abs(v).max() ** 2


@pytest.mark.parametrize(
    ("hidden", "values", "bent"),
    [
        ("quadratic_drag", {"c": DRAG}, set()),
        ("smooth_coulomb_friction", {"Fc": FC, "v_s": 0.05}, {"quadratic_drag"}),
        ("stiffness_drift", {"rate": 0.02}, set()),  # what is left depends on something else
    ],
)
def test_a_law_beside_which_a_curve_over_its_own_signal_says_more_may_be_another_one(hidden, values, bent):
    problem, _, _ = learned(hidden, **values)
    hypothesis = PLAIN.adding(LIBRARY["quadratic_drag"])
    best = problem.fit(hypothesis, hypothesis.vector({}, {"quadratic_drag": {"c": DRAG}}))
    with ThreadPoolExecutor(1) as executor:
        assert other_curves(problem, best, executor) == bent


@pytest.mark.parametrize(("further", "open_ones"), [((), set()), ((300.0, 0.06), {"viscoelastic_relaxation"})])
def test_a_relaxation_beside_which_a_faster_one_explains_more_may_be_another_law(further, open_ones):
    relaxation = LIBRARY["viscoelastic_relaxation"]
    truth = PLAIN.nominal
    for k, tau in filter(None, ((150.0, 0.3), further)):
        truth = relaxation.apply(truth, {"k_maxwell": k, "tau": tau})
    problem, hypothesis = leaving(strokes(), model=truth), PLAIN.adding(relaxation)
    best = problem.fit(hypothesis, hypothesis.vector({}, {relaxation.name: {"k_maxwell": 150.0, "tau": 0.3}}))
    with ThreadPoolExecutor(1) as executor:
        assert more_branches(problem, best, executor, Watch()) == open_ones
        late = Watch(seconds=0.0)
        assert more_branches(problem, best, executor, late) == {relaxation.name}
    assert late.missed == ("viscoelastic_relaxation + further_viscoelastic_relaxation",)


def test_a_table_with_a_value_that_nothing_tells_is_written_without_intervals():
    table = learned("coulomb_friction", Fc=FC)[2][0]
    unknown = replace(table, half_width=np.append(table.half_width[:-1], np.inf))
    (known,), (told,) = document.tabulated(table), document.tabulated(unknown)
    assert known.parameters["value"].ci95 is not None and told.parameters["value"].ci95 is None
    assert told.parameters["value"].value == known.parameters["value"].value


def test_the_interval_of_a_level_of_friction_covers_it_and_says_something():
    table = learned("coulomb_friction", Fc=FC)[2][0]
    value = np.array(table.values["value"])
    assert np.mean(np.abs(value - FC) <= table.half_width) >= 0.8
    assert (table.half_width < 0.05 * FC).all()


def test_residuals_that_are_alike_for_a_while_widen_the_intervals():
    white, slow = (_half_widths(period) for period in (None, 2.5))
    assert np.median(slow / white) > 1.5


def _half_widths(period: float | None) -> np.ndarray:
    """Of a table over time, of noise and of a slow ripple as strong as the noise."""

    def ripple(track):
        rng = np.random.default_rng(3)
        if period is None:
            return track.floor * rng.standard_normal(len(track.time))
        return np.sqrt(2.0) * track.floor * np.sin(2.0 * np.pi * track.time / period)

    problem = leaving(strokes(), ripple)
    refit = problem.fit(PLAIN, PLAIN.base())
    with ThreadPoolExecutor(1) as executor:
        return next(t.half_width for t in tables(problem, refit, executor) if t.values["of"] == "time")


def test_what_is_left_beside_an_effect_is_learned_on_top_of_it():
    both = PLAIN.adding(LIBRARY["coulomb_friction"]).adding(LIBRARY["quadratic_drag"])
    given = {"coulomb_friction": {"Fc": FC}, "quadratic_drag": {"c": DRAG}}
    problem = leaving(strokes(), model=both.model(both.vector({}, given)))
    known = PLAIN.adding(LIBRARY["coulomb_friction"])
    fitted = problem.fit(known, known.vector({}, {"coulomb_friction": {"Fc": FC}}))
    with ThreadPoolExecutor(1) as executor:
        kept = worth_while(problem, fitted, tables(problem, fitted, executor))
    assert kept is not None and kept.values["of"] == "sliding_velocity"
    assert kept.fitted.hypothesis.names == ("coulomb_friction", "tabulated_force")
    assert kept.fitted.cost < 0.4 * fitted.cost


def test_no_table_is_kept_where_only_noise_is_left():
    problem, refit, found = learned()
    assert found and worth_while(problem, refit, found) is None
    assert worth_while(problem, refit, []) is None


def carriage(power: float) -> Recording:
    """m x'' + b x' + c |x'|^power sgn x' = u with m = 3, b = 4, c = 20, by Runge and Kutta's rule."""
    t = np.arange(12000) / 1000.0
    w, size = 2.0 * np.pi * np.array([0.31, 0.83, 1.7]), np.array([10.0, 8.0, 6.0])

    def rate(at: float, state: np.ndarray) -> np.ndarray:
        v = state[1]
        force = float(np.sin(w * at) @ size) - 4.0 * v - 20.0 * abs(v) ** power * np.sign(v)
        return np.array([v, force / 3.0])

    states, h = np.zeros((len(t), 2)), 1e-3
    for i, at in enumerate(t[:-1]):
        k1 = rate(at, states[i])
        k2 = rate(at + 0.5 * h, states[i] + 0.5 * h * k1)
        k3 = rate(at + 0.5 * h, states[i] + 0.5 * h * k2)
        k4 = rate(at + h, states[i] + h * k3)
        states[i + 1] = states[i] + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    noise = 5e-5 * np.random.default_rng(1).standard_normal(len(t))
    return Recording(t, {"input": np.sin(t[:, None] * w) @ size, "output": states[:, 0] + noise}, "carriage")


def on_carriage(power: float, effect: str, **values: float) -> tuple[Problem, Fitted]:
    """The recording, and the right numbers with this effect."""
    problem = prepare([carriage(power)], DrivenBodyModel(m=3.0, b=4.0)).problem
    assert problem is not None
    hypothesis = Hypothesis(DrivenBodyModel(m=3.0, b=4.0)).adding(LIBRARY[effect])
    return problem, problem.at(hypothesis, hypothesis.vector({}, {effect: values}))


@pytest.mark.parametrize(("power", "bent"), [(1.6, {"quadratic_drag"}), (2.0, set())])
def test_of_a_driven_body_a_curve_in_newtons_tells_drag_of_another_power(power: float, bent: set[str]) -> None:
    problem, best = on_carriage(power, "quadratic_drag", c=20.0)
    best = problem.fit(best.hypothesis, best.x)
    with ThreadPoolExecutor(1) as executor:
        assert other_curves(problem, best, executor) == bent


def test_of_a_driven_body_a_delay_may_be_a_lag_where_it_leaves_more_than_noise() -> None:
    problem, best = on_carriage(2.0, "time_delay", delay=0.01)
    with ThreadPoolExecutor(1) as executor:
        assert other_curves(problem, best, executor) == {"time_delay"}
