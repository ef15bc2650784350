"""What the output-error estimator finds, what it leaves alone, and how sure it is."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hand_and_box import OBJECT, Contact, assert_settles_by_itself, contact, free_running_error
from numba.core.runtime import _nrt_python, rtsys

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error import fit
from mmt_drake.estimation.output_error.beginning import Beginning
from mmt_drake.estimation.output_error.fit import Objective
from mmt_drake.estimation.output_error.gate import initial_readout, settings
from mmt_drake.estimation.output_error.layout import READOUT_SIZE, Status
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.offline import OutputErrorTrace, _ticks, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions, Prior
from mmt_drake.estimation.output_error.smoothing import filter_bank
from mmt_drake.estimation.output_error.trials import other_stick
from mmt_drake.estimation.output_error.unknowns import HIGH, LOW, Information, Stick, theta_of, unknowns
from mmt_drake.estimation.output_error.window import POSITION, SAMPLE_SIZE, Window
from mmt_drake.model.parameters import THETA, BoxParameters, FlexibleBoxModel, InPlane, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.numeric.least_squares import Minimum

#: Set-up 1 of the thesis: without a ground spring and with b1 = b2 it has a twin.
THESIS = FlexibleBoxModel(friction=Friction(Fs=0.1, Fd=0.05, v_d=0.005))
SLIDING = [THETA.index(name) for name in ("m", "k2", "b1", "b2", "Fc")]


def run(seen: Contact, **options: Any) -> OutputErrorTrace:
    return estimate_output_error(seen.measurement, seen.in_contact, OutputErrorOptions(**options))


@cache
def strokes() -> OutputErrorTrace:
    return run(contact())


@pytest.mark.parametrize("in_plane", ["per_axis", "vector"])
def test_three_seconds_of_contact_give_the_parameters_within_five_percent(in_plane: InPlane) -> None:
    seen = contact(model=replace(OBJECT, in_plane=in_plane))
    trace = strokes() if in_plane == "per_axis" else run(seen, in_plane=in_plane)
    at = int(np.searchsorted(np.cumsum(seen.in_contact) * 1e-3, 3.0))
    np.testing.assert_allclose(trace.theta[at][:8], OBJECT.theta()[:8], rtol=0.05)


def test_its_free_running_force_is_the_plant_s_within_half_a_percent() -> None:
    assert free_running_error(strokes().theta[-1], contact()) < 0.005


def test_the_thesis_s_object_is_found_in_spite_of_its_twin_and_of_static_friction() -> None:
    seen = contact(model=THESIS)
    theta = run(seen).theta[-1]
    np.testing.assert_allclose(theta[SLIDING], THESIS.theta()[SLIDING], rtol=0.06)
    assert theta[1] < 5.0
    assert free_running_error(theta, seen) < 0.005


@pytest.mark.parametrize(
    ("model", "noise", "rtol"),
    [(OBJECT, 0.0, 5e-3), (replace(OBJECT, normal=NormalContact(k=300.0, b=80.0)), 1.0, 0.05)],
)
def test_without_noise_it_finds_the_parameters_to_a_few_thousandths_and_those_of_two_materials_all_the_same(
    model: FlexibleBoxModel, noise: float, rtol: float
) -> None:
    np.testing.assert_allclose(run(contact(noise=noise, model=model)).theta[-1][:8], model.theta()[:8], rtol=rtol)


@pytest.mark.parametrize(("k", "b"), [(400.0, 0.1), (400.0, -20.0), (-50.0, 30.0)])
def test_a_surface_neither_pulls_nor_gives_energy(k: float, b: float) -> None:
    seen = contact(1.5, noise=0.0)
    measured = seen.measurement.copy()
    measured[:, 8] = seen.in_contact * (-k * measured[:, 2] - b * measured[:, 5])
    normal = estimate_output_error(measured, seen.in_contact).theta[-1, 6:8]
    np.testing.assert_allclose(normal, (max(k, 1.0), max(b, 0.0)), rtol=0.01, atol=0.05)


def test_what_the_motion_does_not_excite_stays_at_the_prior_and_is_told_as_uncertain() -> None:
    seen = contact(2.0)
    pressed = seen.measurement.copy()
    pressed[:, [0, 1, 3, 4, 6, 7]] = np.random.default_rng(3).normal(
        0.0, [1e-5, 1e-5, 5e-4, 5e-4, 0.02, 0.02], (2000, 6)
    )
    trace = estimate_output_error(pressed, seen.in_contact)
    theta, deviation = trace.theta[-1], trace.deviation[-1]
    prior = Prior()
    assert theta[0] == pytest.approx(prior.m, rel=0.1)
    assert theta[5] == pytest.approx(prior.Fc, rel=0.1)
    assert deviation[0] > 0.3 * prior.m
    assert deviation[5] > 0.5
    # The normal axis was pressed, and what is one material is as stiff along the surface.
    assert theta[6] == pytest.approx(OBJECT.normal.k, rel=0.02)
    assert theta[2] == pytest.approx(OBJECT.normal.k, rel=0.3)
    assert deviation[6] < 0.02 * theta[6]


def test_the_deviations_it_tells_cover_its_errors() -> None:
    trace = strokes()
    error = np.abs(trace.theta[-1] - OBJECT.theta())[:8]
    assert (error < 4.0 * trace.deviation[-1][:8] + 1e-3 * np.abs(OBJECT.theta()[:8])).all()
    assert (trace.deviation[-1][:6] < trace.deviation[500][:6]).all()


def test_it_hands_over_a_stable_set_from_the_start_and_never_another() -> None:
    trace = strokes()
    assert_settles_by_itself(trace.theta)
    np.testing.assert_allclose(trace.theta[0, :6], (0.5, 0.0, 300.0, 15.0, 15.0, 0.5))
    assert (trace.theta[:, [0, 2, 4, 6]] > 0.0).all()
    assert (trace.theta >= 0.0).all()


def test_the_first_touch_already_tells_it_something() -> None:
    seen, trace = contact(), strokes()
    at = int(np.flatnonzero(seen.in_contact)[0]) + 300
    theta, true = trace.theta[at], OBJECT.theta()
    assert theta[6] == pytest.approx(true[6], rel=0.05)  # the normal axis
    assert abs(np.log(theta[4] / true[4])) < 0.5


def test_a_fit_is_handed_over_one_period_after_its_last_sample() -> None:
    """The trace does not depend on samples of the last period before it was handed over."""
    seen = contact()
    cut = 3050
    changed = replace(seen, measurement=seen.measurement.copy())
    changed.measurement[cut - 50 :, 6:] += 0.5
    before, after = strokes().theta, run(changed).theta
    np.testing.assert_array_equal(before[: cut + 50], after[: cut + 50])
    assert (before[cut + 151] != after[cut + 151]).any()


def test_the_information_of_samples_that_were_let_go_is_kept() -> None:
    """After strokes the probe rests; once the strokes have left the window their parameters are still known."""
    seen = contact(5.0)
    still = np.tile(seen.measurement[-1], (4000, 1))
    still[:, 3:6] = 0.0
    still[:, 6:8] = 0.0
    noise = np.random.default_rng(5).normal(0.0, np.repeat([1e-5, 5e-4, 0.02], 3), still.shape)
    data = np.vstack([seen.measurement, still + noise])
    flag = np.append(seen.in_contact, np.ones(4000))
    trace = estimate_output_error(data, flag, OutputErrorOptions(window=3.0))
    assert len(trace.knowledge.window) <= 3.0 / 0.005
    np.testing.assert_allclose(trace.theta[-1][SLIDING], OBJECT.theta()[SLIDING], rtol=0.1)


def test_a_heavy_loose_object_is_found() -> None:
    model = FlexibleBoxModel(BoxParameters(m=2.8, k1=0.0, k2=1500.0, b1=5.0, b2=10.0, Fc=1.5))
    seen = contact(model=model)
    assert free_running_error(run(seen).theta[-1], seen, start=2.0) < 0.01


def test_contact_is_told_by_the_status() -> None:
    seen, trace = contact(), strokes()
    told = trace.status[int(np.flatnonzero(seen.in_contact)[0]) + 20 :]
    assert set(np.unique(trace.status)) <= {Status.LEARNING, Status.FREE}
    assert (told[:4000] == Status.LEARNING).all()


def test_a_tick_allocates_nothing() -> None:
    options = OutputErrorOptions()
    fixed, known = settings(options), Learner(options).beginning()
    readout = initial_readout(fixed, known)
    seen, out = contact(), np.empty((len(contact().time), READOUT_SIZE))
    force = np.ascontiguousarray(seen.measurement[:, 6:])
    _nrt_python.memsys_enable_stats()
    try:
        _ticks(seen.measurement, force, seen.in_contact, seen.time, (0, 1), readout, fixed, out)  # compiles
        counts = [rtsys.get_allocation_stats().alloc]
        for span in ((1, 2), (2, 2000)):  # handing arrays to compiled code allocates too, the same for either
            _ticks(seen.measurement, force, seen.in_contact, seen.time, span, readout, fixed, out)
            counts.append(rtsys.get_allocation_stats().alloc)
    finally:
        _nrt_python.memsys_disable_stats()
    one, many = np.diff(counts)
    assert one == many


# ------------------------------------------------------------------------------------------------------------- parts
def test_unknowns_and_theta_are_each_other_s_inverse_within_bounds() -> None:
    theta = np.array([0.7, 20.0, 400.0, 10.0, 25.0, 0.3, 500.0, 60.0, 0.5, 0.004])
    x = unknowns(theta)
    assert ((x > LOW) & (x < HIGH))[:6].all()
    assert x[6] == 0.0  # no lateness
    np.testing.assert_allclose(theta_of(x, Stick(0.2, 0.004), theta[6:8]), theta)


def test_information_of_two_sets_is_that_of_both_together() -> None:
    random = np.random.default_rng(0)
    J, r, x = random.standard_normal((40, 6)), random.standard_normal(40), random.standard_normal(6)
    both = Information.of(J[:15], r[:15], x).plus(Information.of(J[15:], r[15:], x))
    expected = x - np.linalg.lstsq(J, r, rcond=None)[0]
    np.testing.assert_allclose(both.mean(), expected)
    np.testing.assert_allclose(both.faded(0.5).mean(), expected)
    np.testing.assert_allclose(both.covariance(), np.linalg.inv(J.T @ J))


def test_where_a_fit_left_the_body_is_not_simulated_again(monkeypatch: pytest.MonkeyPatch) -> None:
    samples = np.ones((400, SAMPLE_SIZE))
    samples[:, POSITION] = np.column_stack([0.01 * np.sin(0.03 * np.arange(400)), np.zeros(400), np.full(400, -0.004)])
    window = Window.empty().extended(samples, 0.005, filter_bank(0.005, 5))
    objective = Objective(window, 0.005, 5, Beginning.at_rest(), Information.none(), 0.02)
    x, stick = unknowns(OBJECT.theta()), Stick()
    alone = objective.end(x, stick, 399)
    objective.difference(x, stick)
    monkeypatch.setattr(fit, "replay_window", lambda *_: pytest.fail("simulated again"))
    np.testing.assert_array_equal(objective.end(x, stick, 399), alone)


def test_an_unknown_whose_differences_fail_keeps_what_was_known_of_it() -> None:
    """Where a stiffer and a softer object cannot be integrated, the derivative is a column of zeros."""
    known = Information.about(np.zeros(8), np.full(8, 2.0))
    objective = Objective(Window.empty(), 0.005, 5, Beginning.at_rest(), known, 0.02)
    jacobian = np.diag(np.full(8, 0.5))
    jacobian[:, 2] = 0.0
    minimum = Minimum(np.zeros(8), np.zeros(8), jacobian, False, 1)
    np.testing.assert_allclose(objective.covariance(minimum), np.diag(np.full(8, 4.0)))


def test_static_friction_is_sought_all_over_and_about_what_was_found() -> None:
    tried = {other_stick(Stick(), 0.1, number) for number in range(60)}
    assert len(tried) == 13
    assert Stick() in tried
    near = [other_stick(Stick(0.1, 0.005), 0.1, number) for number in range(1, 48, 2)]
    assert all(0.7 < stick.excess / 0.1 < 1.4 and 0.7 < stick.speed / 0.005 < 1.4 for stick in near)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": 0.0}, "step: found 0"),
        ({"window": 1.0}, "window: found 1"),
        ({"period": 2.0}, "period: found 2"),
        ({"force_limit": -1.0}, "force_limit: found -1"),
        ({"prior": {"m": 0.0}}, "prior of the .*: m: found 0"),
        ({"prior": {"k1": -1.0}}, "prior of the .*: k1: found -1"),
    ],
)
def test_options_that_make_no_sense_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        if isinstance(prior := options.get("prior"), dict):
            options = {**options, "prior": Prior(**prior)}
        OutputErrorOptions(**options)


def test_a_scenario_s_prior_is_refused_by_its_place() -> None:
    with pytest.raises(BadInput, match=r"estimator\.prior\.m: found 0"):
        load_scenario("setup1", ("estimator=!OutputErrorOptions {prior: {m: 0.0}}",))


def test_arrays_of_other_shapes_are_refused() -> None:
    with pytest.raises(BadInput, match=r"expected \(n, 9\)"):
        estimate_output_error(np.zeros((10, 6)), np.zeros(10))
    with pytest.raises(BadInput, match="time"):
        estimate_output_error(np.zeros((10, 9)), np.zeros(10), time=np.zeros(9))
