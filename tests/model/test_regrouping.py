"""Eq. 30 both ways: what it means for the force, what its closed forms solve, its twins, and what it refuses."""

import itertools

import numpy as np
import pytest
from numba import njit
from numba.core.runtime import _nrt_python, rtsys
from scipy.optimize import least_squares

from mmt_drake.errors import BadInput
from mmt_drake.model.regrouping import (
    EQUATIONS,
    MAX_ROOTS,
    NOT_ADMISSIBLE,
    NOT_FINITE,
    ROOT_SIZE,
    SCRATCH_SIZE,
    SOLVED,
    TWIN_MISFIT,
    NoPhysicalSolution,
    Root,
    back_solve,
    back_solve_core,
    regroup,
)
from mmt_drake.model.regrouping_equations import REFERENCE_OMEGA, band_weight, jacobian
from mmt_drake.model.regrouping_roots import closed_forms


def objects(count: int, seed: int = 0) -> list[tuple[float, float, float, float, float, float]]:
    """Random m, k1, k2, b1, b2, Fc of things a hand can push."""
    rng = np.random.default_rng(seed)
    low, high = (0.2, 20.0, 100.0, 5.0, 5.0, 0.02), (3.0, 400.0, 1500.0, 100.0, 100.0, 2.0)
    return [tuple(row) for row in rng.uniform(low, high, (count, 6)).tolist()]


def as_array(root: Root) -> np.ndarray:
    return np.array([root.m, root.k1, root.k2, root.b1, root.b2, root.Fc])


def force_per_motion(m: float, k1: float, k2: float, b1: float, b2: float, s: complex) -> complex:
    """F / x of figure 3, by solving for the body, with no rational function in between."""
    body = (k2 + b2 * s) / (m * s * s + b1 * s + k1 + k2 + b2 * s)
    return -(k2 + b2 * s) * (1.0 - body)


# ------------------------------------------------------------------------------------------------------------- forward
@pytest.mark.parametrize("p", objects(5))
def test_the_regrouped_parameters_give_the_box_s_force(p: tuple[float, ...]) -> None:
    a, b, c, d, e, f, _ = regroup(*p)
    for s in (0.3j, 5j, 40j, -2 + 3j):
        by_eq_7 = -(a * s**3 + b * s**2 + c * s + d) / (e * s**2 + f * s + 1)
        assert by_eq_7 == pytest.approx(force_per_motion(*p[:5], s), rel=1e-12)


@pytest.mark.parametrize("p", objects(3, seed=1))
def test_g_is_the_force_that_friction_alone_leaves_on_a_resting_probe(p: tuple[float, ...]) -> None:
    _, k1, k2, _, _, Fc = p
    body = -Fc / (k1 + k2)  # both springs hold the friction of a body that last moved along +x
    assert -regroup(*p)[6] == pytest.approx(k2 * body, rel=1e-14)


def test_the_derivatives_are_those_of_finite_differences() -> None:
    p = np.array(objects(1, seed=2)[0][:5])
    analytic = np.empty((6, 5))
    jacobian(p, analytic)
    for k in range(5):
        h = 1e-6 * p[k]
        up, down = p.copy(), p.copy()
        up[k] += h
        down[k] -= h
        difference = (np.array(regroup(*up, 0.0)) - np.array(regroup(*down, 0.0)))[:6] / (2 * h)
        np.testing.assert_allclose(analytic[:, k], difference, rtol=1e-6, atol=1e-8 * abs(analytic[:, k]).max())


# ------------------------------------------------------------------------------------------------------------ way back
@pytest.mark.parametrize("left_out", range(1, 7))
def test_the_closed_forms_solve_the_five_equations_before_any_refinement(left_out: int) -> None:
    found = 0
    for p in objects(40, seed=4):
        t = np.array(regroup(*p))
        rows, x = np.zeros((MAX_ROOTS, 5)), np.zeros(3)
        count = closed_forms(t, left_out, REFERENCE_OMEGA, rows, x)
        for row in rows[:count]:
            used = [i for i in range(6) if i != left_out - 1]
            again = np.array(regroup(*row, 0.0))
            np.testing.assert_allclose(again[used], t[used], rtol=1e-6)
        nearest = min(abs(rows[:count] / np.array(p[:5]) - 1.0).max(axis=1))
        assert nearest < 1e-6, "the object itself must be among the roots"
        found += count
    assert found > 40, "and there must be others"


@pytest.mark.parametrize("equations", EQUATIONS)
def test_every_choice_of_equations_gives_the_object_back(equations: str) -> None:
    for p in objects(60, seed=5):
        solution = back_solve(regroup(*p), equations=equations, normal_k=p[2])
        np.testing.assert_allclose(as_array(solution.chosen), p, rtol=1e-6)
        assert solution.chosen.admissible and solution.chosen.misfit < 1e-8


@pytest.mark.parametrize("equations", EQUATIONS)
@pytest.mark.parametrize("p", [(1.0, 0.0, 500.0, 60.0, 60.0, 0.05), (0.5, 0.0, 20.0, 0.5, 0.1, 0.1)])
def test_a_body_without_ground_spring_is_found_by_every_choice(p: tuple[float, ...], equations: str) -> None:
    found = as_array(back_solve(regroup(*p), equations=equations, normal_k=p[2]).chosen)
    np.testing.assert_allclose(found, p, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("equations", [e for e in EQUATIONS if e != "without_e"])
def test_equal_springs_and_dampers_are_found_although_there_the_twins_meet(equations: str) -> None:
    p = (1.0, 10.0, 10.0, 1.0, 1.0, 0.1)  # the thesis's engine table A
    found = as_array(back_solve(regroup(*p), equations=equations, normal_k=10.0).chosen)
    np.testing.assert_allclose(found, p, rtol=1e-4)


def test_roots_with_the_same_springs_are_all_kept_and_told_apart_by_their_misfit() -> None:
    p = (2.5, 40.0, 40.0, 75.0, 20.0, 0.1)  # without e, three objects have these springs
    found = back_solve(regroup(*p), equations="without_e", normal_k=40.0)
    np.testing.assert_allclose(as_array(found.chosen), p, rtol=1e-9)
    assert [root.k2 for root in found.others] == pytest.approx([40.0, 40.0])


@pytest.mark.parametrize("equations", [e for e in EQUATIONS if e != "without_e"])
def test_a_body_that_the_probe_alone_holds_is_found(equations: str) -> None:
    # F = -(k2 + b2 s) m s^2 / (m s^2 + b2 s + k2), in numbers that binary fractions hold exactly
    p = (1.0, 0.0, 512.0, 0.0, 64.0, 0.0)
    assert regroup(*p) == (0.125, 1.0, 0.0, 0.0, 1.0 / 512.0, 0.125, 0.0)
    np.testing.assert_allclose(
        as_array(back_solve(regroup(*p), equations=equations, normal_k=512.0).chosen), p, atol=1e-9
    )


# --------------------------------------------------------------------------------------------------------------- twins
THESIS = (1.0, 0.0, 500.0, 60.0, 60.0)


@pytest.mark.parametrize("equations", ["all", "without_a", "without_c", "without_d", "without_e"])
def test_the_thesis_s_object_has_a_twin_that_satisfies_all_six_equations(equations: str) -> None:
    solution = back_solve(regroup(*THESIS, 0.05), equations=equations, normal_k=500.0)
    np.testing.assert_allclose(as_array(solution.chosen)[:5], THESIS, atol=1e-6)
    (twin,) = (root for root in solution.others if root.misfit < 1e-9)
    # k2 = 0 leaves c = b2 = 60, a = m b2/k1, b = b1 b2/k1 with e = m/k1 = 1/500 and f = (b1 + b2)/k1 = 120/500
    k1 = 3600.0 / (0.24 * 60.0 - 8.2)
    expected = (k1 / 500.0, k1, 0.0, 0.24 * k1 - 60.0, 60.0)
    np.testing.assert_allclose(as_array(twin)[:5], expected, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(expected, (1.1613, 580.6, 0.0, 79.35, 60.0), rtol=1e-4)
    assert (
        np.isnan(twin.Fc) and not twin.admissible
    )  # there is no contact spring that could carry friction to the probe
    for s in (0.5j, 9j, 70j):
        assert force_per_motion(*expected, s) == pytest.approx(force_per_motion(*THESIS, s), rel=1e-12)


def test_between_twins_the_stiffness_along_the_normal_decides() -> None:
    # b1 = b2 and a weak ground spring: swapping k1 and k2 leaves k1 k2/S, c = b and S as they are
    t = np.array(regroup(1.0, 30.0, 500.0, 60.0, 60.0, 0.05))
    stiff = back_solve(t, normal_k=400.0)
    soft = back_solve(t, normal_k=60.0)
    assert stiff.chosen.k2 == pytest.approx(500.0, rel=1e-6)
    assert soft.chosen.k2 < 60.0
    assert soft.chosen in stiff.others and stiff.chosen in soft.others
    assert soft.chosen.misfit < TWIN_MISFIT


def test_d_alone_rejects_the_second_root_with_a_contact_spring_of_268() -> None:
    p = (0.7, 0.0, 400.0, 40.0, 15.0, 0.1)
    without_d = back_solve(regroup(*p), equations="without_d", normal_k=250.0)
    # (c): kappa f - 2 kappa beta u + beta = c with f = 0.1375, beta = 15, c = 40, and (b): kappa = p + q u
    pp, q = (0.7 + 1.5 - 15 * 0.1375) / 0.00175, 225 / 0.00175
    u = max(np.roots([-30 * q, 0.1375 * q - 30 * pp, 0.1375 * pp - 25]), key=lambda u: abs(u - 1 / 400))
    assert without_d.chosen.k2 == pytest.approx(pp + q * u, rel=1e-9) and 267 < without_d.chosen.k2 < 269
    assert without_d.chosen.admissible and without_d.chosen.misfit > 10 * TWIN_MISFIT
    (other,) = without_d.others
    np.testing.assert_allclose(as_array(other), p, atol=1e-6)
    with_d = back_solve(regroup(*p), normal_k=250.0)
    np.testing.assert_allclose(as_array(with_d.chosen), p, atol=1e-6)


def test_without_the_normal_axis_the_root_with_the_least_misfit_is_taken() -> None:
    p = (0.7, 0.0, 400.0, 40.0, 15.0, 0.1)
    for equations in EQUATIONS:
        np.testing.assert_allclose(as_array(back_solve(regroup(*p), equations=equations).chosen), p, atol=1e-6)


# --------------------------------------------------------------------------------------------------- inconsistent data
def perturbed(p: tuple[float, ...], percent: float, rng: np.random.Generator) -> np.ndarray:
    return np.array(regroup(*p)) * (1.0 + 0.01 * percent * rng.standard_normal(7))


@pytest.mark.parametrize("information", [False, True])
def test_all_six_equations_are_solved_at_the_least_squares_optimum(information: bool) -> None:
    rng = np.random.default_rng(6)
    scale = np.array([1.0, 500.0, 500.0, 60.0, 60.0])
    roots, scratch = np.zeros((MAX_ROOTS, ROOT_SIZE)), np.zeros(SCRATCH_SIZE)
    for p in objects(12, seed=7):
        t = perturbed(p, 1.0, rng)
        weight = np.zeros((6, 6))
        band_weight(t, 0, weight)
        if information:
            mix = np.sqrt(weight) @ (np.eye(6) + 0.3 * rng.standard_normal((6, 6)))
            weight = mix @ mix.T
        _, chosen, _ = back_solve_core(t, 0, weight, p[2], roots, scratch)
        root = np.linalg.cholesky(weight).T

        def misfit(q: np.ndarray, t: np.ndarray = t, root: np.ndarray = root) -> np.ndarray:
            return root @ (np.array(regroup(*(q * scale), 0.0)) - t)[:6]

        start = roots[chosen, :5] / scale
        best = least_squares(misfit, start * 1.02, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        assert (misfit(start) ** 2).sum() <= 2.0 * best.cost * (1 + 1e-6) + 1e-20
        np.testing.assert_allclose(start, best.x, rtol=2e-4)


def test_a_root_that_two_starts_lead_to_is_told_once() -> None:
    rng, seen = np.random.default_rng(12), 0
    weight, roots, scratch = np.zeros((6, 6)), np.zeros((MAX_ROOTS, ROOT_SIZE)), np.zeros(SCRATCH_SIZE)
    for m, _, k, b1, b2, Fc in objects(60, seed=13):
        t = perturbed((m, k, k, b1, b2, Fc), 0.1, rng)
        band_weight(t, 0, weight)
        count = back_solve_core(t, 0, weight, k, roots, scratch)[2]
        for one, other in itertools.combinations(roots[:count, 1:3], 2):
            assert abs(one - other).max() > 1e-5 * one.sum()
        seen += count
    assert seen > 50


def test_using_all_six_tames_what_leaving_d_out_amplifies() -> None:
    rng = np.random.default_rng(8)
    wrong: dict[str, list[float]] = {"all": [], "without_d": []}
    for _ in range(100):
        t = perturbed((*THESIS, 0.05), 0.3, rng)
        for equations, errors in wrong.items():
            try:
                errors.append(abs(back_solve(t, equations=equations, normal_k=500.0).chosen.k2 - 500.0))
            except NoPhysicalSolution:
                errors.append(500.0)
    assert np.median(wrong["all"]) < 5.0
    assert np.median(wrong["without_d"]) > 5 * np.median(wrong["all"])


# ------------------------------------------------------------------------------------------------------------- refusal
def test_what_no_physical_object_has_is_refused_with_the_reason() -> None:
    t = np.array(regroup(*THESIS, 0.05))
    massless = t.copy()
    massless[4] = -massless[4]
    with pytest.raises(NoPhysicalSolution, match="m/S = e"):
        back_solve(massless)
    complex_pair = t.copy()
    complex_pair[2] *= 1.08  # the two roots of 'without d' lie so close that 8 % make them complex
    with pytest.raises(NoPhysicalSolution, match="no real root"):
        back_solve(complex_pair, equations="without_d", normal_k=500.0)
    active = np.array(regroup(1.0, -200.0, 500.0, 60.0, 60.0, 0.05))
    with pytest.raises(NoPhysicalSolution, match="negative"):
        back_solve(active, normal_k=500.0)
    driven = np.array(regroup(*THESIS, -1.0))
    with pytest.raises(NoPhysicalSolution, match="friction"):
        back_solve(driven, normal_k=500.0)


def test_what_is_truly_zero_may_be_estimated_slightly_negative() -> None:
    p = (1.0, -10.0, 500.0, -2.0, 60.0, -0.05)
    np.testing.assert_allclose(as_array(back_solve(regroup(*p), normal_k=500.0).chosen), p, rtol=1e-6)


def test_the_compiled_core_says_so_too() -> None:
    weight, roots, scratch = np.zeros((6, 6)), np.zeros((MAX_ROOTS, ROOT_SIZE)), np.zeros(SCRATCH_SIZE)
    t = np.array(regroup(*THESIS, 0.05))
    band_weight(t, 0, weight)
    assert back_solve_core(t, 0, weight, 500.0, roots, scratch)[0] == SOLVED
    active = np.array(regroup(1.0, -200.0, 500.0, 60.0, 60.0, 0.05))
    assert back_solve_core(active, 0, weight, 500.0, roots, scratch)[:2] == (NOT_ADMISSIBLE, -1)
    assert back_solve_core(np.full(7, np.nan), 0, weight, 500.0, roots, scratch) == (NOT_FINITE, -1, 0)
    for left_out in range(7):  # zeros everywhere: a body at rest has taught nothing yet
        assert back_solve_core(np.zeros(7), left_out, weight, 500.0, roots, scratch)[0] != SOLVED


def test_random_coefficients_never_upset_the_core() -> None:
    rng = np.random.default_rng(9)
    weight, roots, scratch = np.zeros((6, 6)), np.zeros((MAX_ROOTS, ROOT_SIZE)), np.zeros(SCRATCH_SIZE)
    for _ in range(2000):
        t = rng.standard_normal(7) * 10.0 ** rng.uniform(-8, 4, 7)
        for left_out in range(7):
            band_weight(t, left_out, weight)
            status, chosen, count = back_solve_core(t, left_out, weight, 500.0, roots, scratch)
            assert (chosen >= 0) == (status == SOLVED) and count <= MAX_ROOTS
            if status == SOLVED:
                m, k1, k2, b1, b2 = roots[chosen, :5]
                assert np.all(np.real(np.roots([m, b1 + b2, k1 + k2])) < 0) and min(m, k2, b2) > 0


@njit
def repeat(times: int, t: np.ndarray, left_out: int, *arrays: np.ndarray) -> None:
    weight, roots, scratch = arrays
    for _ in range(times):
        back_solve_core(t, left_out, weight, 500.0, roots, scratch)


def test_a_solve_allocates_nothing() -> None:
    weight, roots, scratch = np.zeros((6, 6)), np.zeros((MAX_ROOTS, ROOT_SIZE)), np.zeros(SCRATCH_SIZE)
    t = np.array(regroup(*THESIS, 0.05)) * np.linspace(0.99, 1.01, 7)
    repeat(1, t, 0, weight, roots, scratch)
    _nrt_python.memsys_enable_stats()
    try:
        for left_out in range(7):
            band_weight(t, left_out, weight)
            counts = [rtsys.get_allocation_stats().alloc]
            for times in (1, 100):  # handing arrays to compiled code allocates too, the same for either
                repeat(times, t, left_out, weight, roots, scratch)
                counts.append(rtsys.get_allocation_stats().alloc)
            assert counts[2] - counts[1] == counts[1] - counts[0]
    finally:
        _nrt_python.memsys_disable_stats()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"regrouped": [1.0] * 6}, "7 finite numbers"),
        ({"regrouped": [1.0] * 6 + [np.inf]}, "7 finite numbers"),
        ({"equations": "without_g"}, "one of all, without_a"),
        ({"normal_k": np.nan}, "stiffness in N/m"),
    ],
)
def test_bad_input_is_told_in_one_line(arguments: dict[str, object], message: str) -> None:
    call = {"regrouped": regroup(*THESIS, 0.05), **arguments}
    with pytest.raises(BadInput, match=message) as raised:
        back_solve(**call)  # type: ignore[arg-type]
    assert "\n" not in str(raised.value)
