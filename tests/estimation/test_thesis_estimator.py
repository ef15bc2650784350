"""The thesis's estimator on its own experiment: what it computes, how well, and what each choice does."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import scipy.signal
from thesis_setup import Box, force_error, measurement, sliding_axis, strokes, without_friction

from mmt_drake.errors import BadInput
from mmt_drake.estimation import thesis
from mmt_drake.estimation.offline import RlsTrace, estimate
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error import layout as output_error
from mmt_drake.model.regrouping import EQUATIONS, MAX_ROOTS, ROOT_SIZE, SCRATCH_SIZE, back_solve, back_solve_core

STEP = 1e-3


@cache
def minute(noise: float) -> np.ndarray:
    return strokes(Box(), 60.0, noise=noise)[1]


def run(data: np.ndarray, **options: object) -> RlsTrace:
    return estimate(data, np.ones(len(data)), RlsOptions(**options))  # type: ignore[arg-type]


def regressors_by_scipy(data: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Appendix D.2 as one would write it offline, for a recording that starts at rest with zero force."""
    x, v, F = data[:, axis], data[:, 3 + axis], data[:, 6 + axis]
    sos = scipy.signal.butter(6, 10.0, fs=1 / STEP, output="sos")

    def difference(signal: np.ndarray) -> np.ndarray:
        return np.diff(signal, prepend=signal[0]) / STEP

    a = difference(v)
    raw = [difference(a), a, v, x, difference(difference(F)), difference(F), np.sign(v)]
    psi = -np.column_stack([scipy.signal.sosfilt(sos, signal - signal[0]) + signal[0] for signal in raw])
    return psi, scipy.signal.sosfilt(sos, F)


# ------------------------------------------------------------------------------------------------ what it computes
def test_it_is_batch_least_squares_on_eq_7_with_both_axes_in_one() -> None:
    data = minute(0.02)[:8000].copy()
    data[:, 6:8] -= data[0, 6:8]
    rows = [regressors_by_scipy(data, axis) for axis in (0, 1)]
    psi, y = np.vstack([r[0] for r in rows]), np.concatenate([r[1] for r in rows])
    scale = 1.0 / np.linalg.norm(psi, axis=0)
    expected = scale * np.linalg.lstsq(psi * scale, y, rcond=None)[0]
    trace = run(data, initial_covariance=1e8)
    np.testing.assert_allclose(trace.regrouped[-1], expected, rtol=2e-4, atol=1e-6)
    for axis in (0, 1):
        np.testing.assert_allclose(trace.filtered_force[:, axis], rows[axis][1], atol=1e-9)
        np.testing.assert_allclose(trace.estimated_force[-1, axis], rows[axis][0][-1] @ trace.regrouped[-1], rtol=1e-6)
    inverse = np.linalg.inv((psi * scale).T @ (psi * scale)) * np.outer(scale, scale)
    np.testing.assert_allclose(np.diag(trace.covariance), np.diag(inverse), rtol=1e-3)


def test_along_the_normal_it_finds_spring_and_damper_of_eq_8() -> None:
    box = Box(normal_k=350.0, normal_b=12.0)
    t = np.arange(4000) * STEP
    axis = sliding_axis(box, t)
    trace = run(measurement(box, axis, axis, t))
    np.testing.assert_allclose(trace.theta[-1, 6:8], (350.0, 12.0), rtol=2e-3)


def test_theta_is_the_back_solve_of_what_was_learned() -> None:
    for equations in ("all", "without_d", "without_a"):
        trace = run(minute(0.0)[:20000], equations=equations)
        root = back_solve(trace.regrouped[-1], equations=equations, normal_k=trace.theta[-1, 6]).chosen
        expected = (root.m, root.k1, root.k2, root.b1, root.b2, root.Fc)
        np.testing.assert_allclose(trace.theta[-1, :6], expected, rtol=1e-12)


def test_a_root_is_taken_along_from_tick_to_tick_and_left_for_a_better_twin_at_every_twentieth() -> None:
    trace = run(minute(0.02)[:8000], forgetting=0.999)

    def strays(tick: int) -> bool:
        best = back_solve(trace.regrouped[tick], normal_k=trace.theta[tick, 6]).chosen
        return abs(trace.theta[tick, 2] / best.k2 - 1.0) > 1e-3

    known = np.flatnonzero(trace.stable) + 1  # ticks are counted from 1
    assert not any(strays(tick - 1) for tick in known if tick % 20 == 0)
    after_a_change = [tick for tick in known if tick % 20 == 19 and strays(tick - 1)]
    assert 0 < len(after_a_change) < 0.1 * len(known) / 20


@pytest.mark.parametrize(("normal_k", "normal_b"), [(-20.0, 60.0), (350.0, -6.0), (0.0, 0.0)])
def test_a_normal_axis_that_pulls_chooses_no_root_and_one_that_does_not_push_alone_is_never_stable(
    normal_k: float, normal_b: float
) -> None:
    """One with a negative damper still tells which root is the stiffness of the object."""
    data = minute(0.02)[:8000].copy()
    data[:, 8] = -normal_k * data[:, 2] - normal_b * data[:, 5]
    trace = run(data)
    np.testing.assert_allclose(trace.theta[-1, 6:8], (normal_k, normal_b), rtol=1e-2)
    assert not trace.stable[4000:].any()
    for tick in range(4000, 8000, 100):
        root = back_solve(trace.regrouped[tick], normal_k=normal_k if normal_k > 0.0 else None).chosen
        np.testing.assert_allclose(trace.theta[tick, :5], (root.m, root.k1, root.k2, root.b1, root.b2), rtol=1e-9)


def test_weighting_by_information_is_the_constrained_maximum_of_the_likelihood() -> None:
    trace = run(minute(0.02)[:20000], weighting="information")
    weight = np.linalg.inv(trace.covariance[:6, :6])
    roots, scratch = np.zeros((MAX_ROOTS, ROOT_SIZE)), np.zeros(SCRATCH_SIZE)
    _, chosen, _ = back_solve_core(trace.regrouped[-1], 0, weight, 500.0, roots, scratch)
    np.testing.assert_allclose(trace.theta[-1, :5], roots[chosen, :5], rtol=1e-5, atol=1e-4)


# --------------------------------------------------------------------------------------------------------- how well
@pytest.mark.parametrize(
    ("differences", "steps", "found", "most_at_1_khz", "order", "rtol"),
    [
        ("backward", (1e-3, 5e-4, 2.5e-4), [0, 1, 2, 3, 4], (0.05, 0.1, 5.0, 0.1, 0.5), 1, 0.15),
        ("central", (2e-3, 1e-3, 5e-4), [0, 2, 3, 4], (0.001, 0.05, 0.002, 0.01), 2, 0.3),
    ],
)
def test_without_friction_the_only_error_is_that_of_the_differences(
    differences: str, steps: tuple[float, ...], found: list[int], most_at_1_khz: object, order: int, rtol: float
) -> None:
    """The force is a closed form; what is left of the error falls with the step as the order of a difference says."""
    errors = {}
    for step in steps:
        data = without_friction(Box(), 12.0, step)
        after_the_start = (np.arange(len(data)) * step > 1.0).astype(float)
        theta = estimate(data, after_the_start, RlsOptions(step=step, differences=differences)).theta[-1]
        errors[step] = (theta[:5] - (1.0, 0.0, 500.0, 60.0, 60.0))[found]
    assert (abs(errors[1e-3]) < most_at_1_khz).all()
    for coarse, fine in pairwise(errors.values()):
        np.testing.assert_allclose(fine, 0.5**order * coarse, rtol=rtol)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_with_all_of_eq_30_the_thesis_s_object_is_found_within_a_few_percent_of_its_force(noise: float) -> None:
    trace = run(minute(noise))
    error = force_error(trace.theta[-1], Box(), np.array([0.1, 0.3, 1.0, 3.0, 6.0]))
    assert (error < (0.02, 0.01, 0.01, 0.015, 0.02)).all()
    assert abs(trace.theta[-1, 1]) < 2.0  # no false ground spring
    residual = (trace.estimated_force - trace.filtered_force)[5000:, :2]
    assert residual.std() < 0.03 * trace.filtered_force[5000:, :2].std()
    assert trace.stable[3000:].all()


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_without_d_a_false_ground_spring_spoils_low_frequencies_and_any_other_equation_can_be_spared(
    noise: float,
) -> None:
    low, high = np.array([0.1, 0.3]), np.array([3.0, 6.0])
    for equations in EQUATIONS[1:]:
        theta = run(minute(noise), equations=equations).theta[-1]
        if equations == "without_d":
            assert theta[1] > 30.0
            assert (force_error(theta, Box(), low) > 0.3).all() and (force_error(theta, Box(), high) < 0.03).all()
        else:
            assert (force_error(theta, Box(), np.concatenate([low, high])) < 0.06).all(), equations


def test_weighting_by_information_finds_the_mass_that_the_band_weight_misses() -> None:
    data = minute(0.02)
    band, information = run(data).theta[-1], run(data, weighting="information").theta[-1]
    assert abs(information[0] - 1.0) < 0.03 < abs(band[0] - 1.0)


# --------------------------------------------------------------------------------------------------------- contact
def test_nothing_is_known_before_the_first_contact() -> None:
    data = minute(0.0)[:2000]
    trace = estimate(data, np.zeros(2000))
    assert np.isnan(trace.theta).all() and not trace.stable.any() and not trace.regrouped.any()
    assert not trace.estimated_force.any() and trace.filtered_force[-1].any()


@pytest.mark.parametrize(("flag", "contact"), [(0.6, 1.0), (0.4, 0.0)])
def test_a_flag_between_two_samples_counts_as_contact_above_one_half(flag: float, contact: float) -> None:
    data = minute(0.0)[:2000]
    between, whole = estimate(data, np.full(2000, flag)), estimate(data, np.full(2000, contact))
    np.testing.assert_array_equal(between.regrouped, whole.regrouped)
    assert whole.regrouped.any() == (contact == 1.0)


def test_both_estimators_put_out_the_same_first_five_signals() -> None:
    assert list(thesis.PORT_SIZES)[:5] == list(output_error.PORT_SIZES)[:5]
    theirs = [output_error.PORT_SIZES[name] for name in ("regrouped", "stable", "estimated_force", "filtered_force")]
    assert [thesis.PORT_SIZES[name] for name in thesis.PORT_SIZES if name != "theta"] == theirs


def test_out_of_contact_learning_pauses_and_the_filters_run_on() -> None:
    data = minute(0.0)[:8000]
    contact = np.ones(8000)
    contact[5000:6000] = 0.0
    trace = estimate(data, contact)
    paused = slice(5000, 6000)
    for held in (trace.theta, trace.regrouped, trace.stable):
        assert (held[paused] == held[4999]).all()
    assert not trace.estimated_force[paused].any()
    np.testing.assert_array_equal(trace.filtered_force, run(data).filtered_force)
    assert (trace.regrouped[6000] != trace.regrouped[5999]).any()


def test_with_forgetting_a_pause_does_not_inflate_the_covariance() -> None:
    data = minute(0.0)[:4000]
    contact = np.ones(4000)
    contact[2000:] = 0.0
    paused = estimate(data, contact, RlsOptions(forgetting=0.999)).covariance
    np.testing.assert_array_equal(paused, run(data[:2000], forgetting=0.999).covariance)


def test_settling_skips_the_samples_in_which_the_filters_remember_free_space() -> None:
    data = without_friction(Box(), 6.0)
    contact = np.zeros(6000)
    contact[2000:] = 1.0
    data[:2000, 6:9] = 0.0  # free space; the force sets in at touch
    wrong = estimate(data, contact).theta[-1]
    settled = estimate(data, contact, RlsOptions(settle=0.5))
    assert not settled.regrouped[2499].any() and settled.regrouped[2500].any()
    frequency = np.array([0.3, 1.0, 3.0])
    assert force_error(settled.theta[-1], Box(), frequency).max() < 0.01
    assert force_error(wrong, Box(), frequency).max() > 0.05


def test_freezing_stops_learning_after_so_much_contact_but_not_the_estimate_of_force() -> None:
    data = minute(0.0)[:9000]
    contact = np.ones(9000)
    contact[1000:2000] = 0.0
    trace = estimate(data, contact, RlsOptions(freeze_after=5.0))
    free = estimate(data, contact)
    np.testing.assert_array_equal(trace.theta[:6000], free.theta[:6000])
    assert (trace.regrouped[6000:] == trace.regrouped[5999]).all() and (
        free.regrouped[6000] != free.regrouped[5999]
    ).any()
    assert (np.diff(trace.estimated_force[6000:, 0]) != 0).all()


def test_counting_x_from_the_touch_finds_a_ground_spring_wherever_the_object_stands() -> None:
    box = Box(k1=150.0, Fc=0.0)
    _, data = strokes(box, 12.0)
    data[:, :2] += (0.06, -0.05)
    frequency = np.array([0.1, 0.3, 1.0, 3.0])
    assert force_error(run(data, position_origin="touch").theta[-1], box, frequency).max() < 0.01
    assert force_error(run(data).theta[-1], box, frequency).max() > 0.1


@pytest.mark.parametrize("filter_friction", [False, True])
def test_the_body_s_own_velocity_gives_the_better_friction(filter_friction: bool) -> None:
    by_probe, by_body = (
        run(minute(0.0), friction_velocity=choice, filter_friction=filter_friction).theta[-1, 5]
        for choice in ("probe", "body")
    )
    assert abs(by_body - Box.Fc) < 0.7 * abs(by_probe - Box.Fc)


def test_with_no_physical_solution_the_last_one_is_held_and_flagged() -> None:
    data = minute(0.0)[:12000].copy()
    data[6000:, 6:8] *= -1.0  # now it pushes along: negative stiffness and damping
    trace = run(data, forgetting=0.998)
    assert trace.stable[3000:6000].all()
    assert not trace.stable[9000:].any()
    held = trace.theta[9000:, :6]
    assert np.isfinite(held).all() and (held == held[0]).all()
    assert (trace.regrouped[-1] != trace.regrouped[9000]).any()


def test_a_rotated_stroke_teaches_the_same_theta() -> None:
    """x and y share theta: without friction only the direction of the motion differs."""
    data = without_friction(Box(), 8.0)
    turned = data.copy()
    c, s = np.cos(0.6), np.sin(0.6)
    for start in (0, 3, 6):
        turned[:, start] = c * data[:, start] - s * data[:, start + 1]
        turned[:, start + 1] = s * data[:, start] + c * data[:, start + 1]
    contact = (np.arange(8000) > 1000).astype(float)
    expected, found = estimate(data, contact).theta[-1], estimate(turned, contact).theta[-1]
    np.testing.assert_allclose(found[:5], expected[:5], rtol=1e-3, atol=1e-2)


# --------------------------------------------------------------------------------------------------------- refusal
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": 0.0}, "step"),
        ({"step": float("nan")}, "step"),
        ({"filter_order": 0}, "filter_order"),
        ({"filter_order": 6.0}, "filter_order"),
        ({"cutoff_hz": 500.0}, r"0\.01 to 500 Hz"),
        ({"initial_covariance": -1.0}, "initial_covariance"),
        ({"forgetting": 1.01}, "above 0 to 1"),
        ({"equations": "abcdef"}, "one of all, without_a"),
        ({"weighting": "none"}, "band, information"),
        ({"weighting": "information", "equations": "without_d"}, "where weighting is information"),
        ({"friction_velocity": "mass"}, "probe, body"),
        ({"position_origin": "probe"}, "table, touch"),
        ({"settle": -0.1}, "settle"),
        ({"freeze_after": float("inf")}, "freeze_after"),
    ],
)
def test_an_option_out_of_range_is_told_in_one_line(options: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message) as raised:
        RlsOptions(**options)  # type: ignore[arg-type]
    assert "\n" not in str(raised.value)


def test_data_that_are_no_recording_are_refused() -> None:
    good = minute(0.0)[:10]
    with pytest.raises(BadInput, match=r"\(n, 9\)"):
        estimate(good[:, :8], np.ones(10))
    with pytest.raises(BadInput, match=r"\(n, 9\)"):
        estimate(good, np.ones(9))
    bad = good.copy()
    bad[7, 4] = np.nan
    with pytest.raises(BadInput, match="row 7"):
        estimate(bad, np.ones(10))
