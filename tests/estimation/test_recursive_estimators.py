"""The recursive estimators: what they find, without bias by noise, what they do with bad input, and what they cost."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from faults import BAD, FAULTS, LASTING, PERIOD, SECONDS, TOTAL
from hand_and_box import OBJECT, STEP, Contact, assert_settles_by_itself, contact, free_running_error
from scipy.signal import lsim

from mmt_drake.diagrams.scenario import load_scenario
from mmt_drake.errors import BadInput
from mmt_drake.estimation.kinds import learner_of
from mmt_drake.estimation.offline import estimate
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.offline import LearningTrace, learned_along
from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.estimation.output_error.places import Status
from mmt_drake.estimation.output_error.unknowns import UNKNOWNS
from mmt_drake.estimation.recursive.instrumental import prefilter
from mmt_drake.estimation.recursive.instrumental_step import BANK, REGRESSORS, Sums, add_samples
from mmt_drake.estimation.recursive.kalman_step import OWN
from mmt_drake.estimation.recursive.options import InstrumentalOptions, KalmanOptions
from mmt_drake.estimation.recursive.samples import Samples
from mmt_drake.model.body import AXIS_SIZE, MODE, VELOCITY
from mmt_drake.model.flexible_box import replay_axis
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.regrouping import regroup
from mmt_drake.model.structure import Friction

KINDS = {"kalman": KalmanOptions, "instrumental_variable": InstrumentalOptions}
#: Error of the free-running force after some seconds on an object with friction. That of the auxiliary model has to be
#: right before the instrumental variable can be, and it is told by nothing but the parameters.
WITH_FRICTION = {"kalman": 0.005, "instrumental_variable": 0.025}
#: Its mode, 3.2 Hz, is within the strokes' band, and so there is no twin.
SMOOTH = FlexibleBoxModel(BoxParameters(m=1.0, k1=100.0, k2=300.0, b1=5.0, b2=8.0), NormalContact(300.0, 8.0))
THESIS = FlexibleBoxModel(friction=Friction(Fs=0.1, Fd=0.05, v_d=0.005))

both = pytest.mark.parametrize("kind", KINDS)


def run(kind: str, seen: Contact, **options: Any) -> LearningTrace[Any]:
    return learned_along(learner_of(KINDS[kind](**options)), seen.measurement, seen.in_contact)


@cache
def strokes(kind: str) -> LearningTrace[Any]:
    return run(kind, contact())


@both
def test_the_parameters_of_a_plant_without_friction_and_noise_are_recovered(kind: str) -> None:
    theta = run(kind, contact(noise=0.0, model=SMOOTH)).theta[-1]
    np.testing.assert_allclose(theta[:5], SMOOTH.theta()[:5], rtol=0.01)
    assert theta[5] < 2e-3


@both
def test_three_times_the_noise_biases_least_squares_and_not_this(kind: str) -> None:
    seen = contact(8.0, noise=3.0, model=SMOOTH)
    here = run(kind, seen).theta[-1]
    least_squares = estimate(seen.measurement, seen.in_contact, RlsOptions(settle=0.5)).theta[-1]
    assert free_running_error(here, seen) < 0.003
    assert free_running_error(least_squares, seen) > 3.0 * free_running_error(here, seen)


@both
def test_an_object_that_sticks_is_found_and_rendered(kind: str) -> None:
    theta = strokes(kind).theta[-1]
    np.testing.assert_allclose(theta[:8], OBJECT.theta()[:8], rtol=10.0 * WITH_FRICTION[kind])
    assert free_running_error(theta, contact()) < WITH_FRICTION[kind]


def test_rivals_of_the_kalman_filter_find_static_friction() -> None:
    seen = contact(20.0, model=THESIS)
    found, alone = run("kalman", seen), run("kalman", seen, rivals=0)
    assert 0.003 < found.theta[-1, 9] < 0.008
    assert found.theta[-1, 8] - found.theta[-1, 5] == pytest.approx(0.05, rel=0.5)
    assert free_running_error(found.theta[-1], seen) < 0.5 * free_running_error(alone.theta[-1], seen)


@both
def test_it_hands_over_a_stable_set_from_the_start_and_never_another(kind: str) -> None:
    theta = strokes(kind).theta
    assert_settles_by_itself(theta)
    np.testing.assert_allclose(theta[0, :6], (0.5, 0.0, 300.0, 15.0, 15.0, 0.5))
    assert (theta >= 0.0).all()


@both
def test_the_deviations_it_tells_cover_its_errors(kind: str) -> None:
    trace = strokes(kind)
    error = np.abs(trace.theta[-1] - OBJECT.theta())[:8]
    assert (error < 5.0 * trace.deviation[-1][:8] + 2.0 * WITH_FRICTION[kind] * np.abs(OBJECT.theta()[:8])).all()
    assert (trace.deviation[-1][:6] < trace.deviation[500][:6]).all()


@both
def test_what_the_motion_does_not_excite_stays_at_the_prior(kind: str) -> None:
    seen = contact(2.0)
    pressed = seen.measurement.copy()
    noise = [1e-5, 1e-5, 5e-4, 5e-4, 0.02, 0.02]
    pressed[:, [0, 1, 3, 4, 6, 7]] = np.random.default_rng(3).normal(0.0, noise, (2000, 6))
    trace = run(kind, replace(seen, measurement=pressed))
    theta, deviation = trace.theta[-1], trace.deviation[-1]
    assert theta[0] == pytest.approx(Prior().m, rel=0.1)
    assert theta[5] == pytest.approx(Prior().Fc, rel=0.1)
    assert deviation[0] > 0.3 * Prior().m
    # The normal axis was pressed, and what is one material is as stiff along the surface.
    assert theta[6] == pytest.approx(OBJECT.normal.k, rel=0.02)
    assert theta[2] == pytest.approx(OBJECT.normal.k, rel=0.3)


# ---------------------------------------------------------------------------------------------------------- bad input
@both
@pytest.mark.parametrize("name", FAULTS)
def test_it_says_what_is_wrong_holds_what_it_knows_and_recovers(kind: str, name: str) -> None:
    fault, status = FAULTS[name]
    seen = contact(SECONDS)
    data, flag, at = seen.measurement.copy(), seen.in_contact.copy(), seen.time.copy()
    fault(data, flag, at)
    trace = learned_along(learner_of(KINDS[kind](step=STEP)), data, flag, time=at)
    assert np.isfinite(trace.theta).all()
    assert np.isfinite(trace.deviation).all()
    assert_settles_by_itself(trace.theta)
    assert (trace.status == status).any()
    if name in TOTAL:
        # What came before the fault is handed over two periods and the smoothing's 0.1 s later; then nothing is new.
        held = trace.theta[BAD.start + 2 * PERIOD + 130 : BAD.stop]
        assert len(held) > 100
        assert (held == held[0]).all()
    if name not in LASTING:
        assert set(np.unique(trace.status[-1000:])) <= {Status.LEARNING, Status.FREE}
        assert (trace.theta[-500:] != trace.theta[BAD.stop]).any()
    assert free_running_error(trace.theta[-1], seen) < 4.0 * WITH_FRICTION[kind]


@both
def test_nothing_but_nan_leaves_the_prior(kind: str) -> None:
    trace = learned_along(learner_of(KINDS[kind]()), np.full((500, 9), np.nan), np.ones(500))
    assert (trace.theta == trace.theta[0]).all()
    assert (trace.status[1:] == Status.NOT_FINITE).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("KalmanOptions {force_noise: 0.0}", "estimator.force_noise: found 0"),
        ("KalmanOptions {rivals: 11}", "estimator.rivals: found 11"),
        ("KalmanOptions {drift: -1.0}", "estimator.drift: found -1"),
        ("InstrumentalOptions {growth: 0.0}", "estimator.growth: found 0"),
        ("InstrumentalOptions {memory: 0.5}", "estimator.memory: found 0.5"),
        ("InstrumentalOptions {period: 2.0}", "estimator.period: found 2"),
    ],
)
def test_options_that_make_no_sense_are_refused_by_their_place(options: str, message: str) -> None:
    with pytest.raises(BadInput, match=message):
        load_scenario("setup1", (f"estimator=!{options}",))


# --------------------------------------------------------------------------------------------------------------- parts
@both
def test_it_takes_less_than_a_tenth_of_the_time_that_passes(kind: str) -> None:
    """Processor time; 30 s of 1 kHz cost about a second, so there is a margin of three."""
    strokes(kind)  # compiles
    learner, seen = learner_of(KINDS[kind]()), contact()
    start = time.process_time()
    learned_along(learner, seen.measurement, seen.in_contact)
    assert time.process_time() - start < 0.1 * seen.time[-1]


def test_the_kalman_filter_s_covariance_stays_one_and_a_body_that_is_stuck_has_no_velocity() -> None:
    seen, learner = contact(), learner_of(KalmanOptions())
    stuck = 0
    for end in range(1000, 3000, 200):
        belief = learned_along(learner, seen.measurement[:end], seen.in_contact[:end]).knowledge.belief
        np.testing.assert_array_equal(belief.P, belief.P.T)
        assert np.linalg.eigvalsh(belief.P).min() > -1e-12
        for i in range(2):
            if belief.axes[i, MODE] == 0.0:
                stuck += 1
                assert belief.axes[i, VELOCITY] == 0.0
                assert belief.P[UNKNOWNS + OWN * i + 1, UNKNOWNS + OWN * i + 1] < 1e-12
    assert stuck > 0


def test_the_prefilter_is_exact_for_what_is_linear_between_samples() -> None:
    """Against SciPy's simulation of 1 / (e p^2 + f p + 1)."""
    h = 0.005
    through, random = prefilter(0.002, 0.05, h), np.random.default_rng(0)
    u = np.append(0.0, random.standard_normal(200))
    _, _, expected = lsim(
        ([[0.0, 1.0], [-500.0, -25.0]], [[0.0], [500.0]], np.eye(2), np.zeros((2, 1))), u, h * np.arange(201)
    )
    state = np.zeros(2)
    for k in range(1, 201):
        state = through.free @ state + through.before * u[k - 1] + through.after * u[k]
        np.testing.assert_allclose(state, expected[k], rtol=1e-9, atol=1e-12)


def test_eq_7_with_friction_in_full_misses_nothing_where_the_parameters_are_true() -> None:
    """Sticking included; what is left comes of taking friction as linear between samples."""
    model = replace(OBJECT, parameters=replace(OBJECT.parameters, Fc=1.0))
    h, n = 0.005, 1200
    t = h * np.arange(n)
    w = 2.0 * np.pi * np.array([0.7, 1.9])
    x = 0.02 * (1.0 - np.cos(w[0] * t)) + 0.005 * (1.0 - np.cos(w[1] * t))
    v = 0.02 * w[0] * np.sin(w[0] * t) + 0.005 * w[1] * np.sin(w[1] * t)
    force, body, level = np.empty(n), np.empty((2, n)), np.zeros(n)
    p = model.kernel_vector()
    replay_axis(t, x, v, level, level, True, np.empty(0), p, force, body[0], body[1])
    two, ones = np.vstack, np.ones(n)
    samples = Samples(h, two([x, x]), two([v, v]), ones, ones, ones, two([force, force]), np.ones((2, n)))
    rho = np.array(regroup(*model.theta()[:UNKNOWNS]))
    square = np.zeros((REGRESSORS, REGRESSORS))
    sums = Sums(square.copy(), square.copy(), np.zeros(REGRESSORS), np.zeros(3))
    axes, through = np.zeros((2, AXIS_SIZE)), prefilter(rho[4], rho[5], h)
    add_samples(samples, (1, n), p, rho, (through, through), 1.0, 1e6, axes, np.zeros((2, 2, BANK)), sums)
    assert (body[1] == 0.0).mean() > 0.05
    assert np.sqrt(sums.counts[1] / sums.counts[0]) < 0.01 * np.sqrt(np.mean(force**2))
    np.testing.assert_allclose(np.linalg.solve(sums.cross, sums.target)[[0, 4, 5, 6]], rho[[0, 4, 5, 6]], rtol=0.05)
