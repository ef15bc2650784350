"""The output-error estimator fed with what a robot really sends: it holds what it knows, says why, and recovers."""

import math

import numpy as np
import pytest
from faults import BAD, FAULTS, LASTING, PERIOD, SECONDS, TOTAL, Fault
from hand_and_box import STEP, assert_settles_by_itself, contact, contact_motion, free_running_error

from mmt_drake.estimation import probe
from mmt_drake.estimation.output_error import fit, gate
from mmt_drake.estimation.output_error.layout import COUNT, FILTERED, MEMORY, ROWS, STATUS, Status
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.offline import OutputErrorTrace, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.window import CONTACT, SAMPLE_SIZE

Array = np.ndarray


def fed(fault: Fault) -> OutputErrorTrace:
    seen = contact(SECONDS)
    data, flag, time = seen.measurement.copy(), seen.in_contact.copy(), seen.time.copy()
    fault(data, flag, time)
    return estimate_output_error(data, flag, OutputErrorOptions(step=STEP), time=time)


@pytest.mark.parametrize("name", FAULTS)
def test_it_says_what_is_wrong_holds_what_it_knows_and_recovers(name: str) -> None:
    fault, status = FAULTS[name]
    trace = fed(fault)
    assert np.isfinite(trace.theta).all()
    assert np.isfinite(trace.deviation).all()
    assert np.isfinite(trace.estimated_force).all()
    assert_settles_by_itself(trace.theta)
    during = trace.status[BAD]
    # Strokes reach the limit elsewhere.
    assert ((trace.status if status == Status.SATURATED else during) == status).any()
    assert set(np.unique(trace.status)) <= {Status.LEARNING, Status.FREE, status, Status.DROPPED, Status.JUMPED}
    if name in TOTAL:
        # What came before the fault is handed over within two periods; from then on there is nothing new.
        held = trace.theta[BAD.start + 2 * PERIOD + 30 : BAD.stop]
        assert (held == held[0]).all()
        assert (during[30:] == status).all()
    if name not in LASTING:
        assert set(np.unique(trace.status[-1000:])) <= {Status.LEARNING, Status.FREE}
        assert (trace.theta[-500:] != trace.theta[BAD.stop]).any()
    assert free_running_error(trace.theta[-1], contact(SECONDS)) < 0.02


def test_a_sensor_limit_that_is_told_is_seen_at_once() -> None:
    seen = contact(SECONDS)
    data = seen.measurement.copy()
    limit = 0.5 * float(np.abs(data[:, 7]).max())
    data[:, 7] = data[:, 7].clip(-limit, limit)
    trace = estimate_output_error(data, seen.in_contact, OutputErrorOptions(force_limit=limit))
    beyond = np.abs(data[:, 7]) == limit
    assert (trace.status[beyond] == Status.SATURATED).all()
    assert free_running_error(trace.theta[-1], seen) < 0.02


def test_a_sensor_that_saturates_behind_a_probe_is_seen_in_its_own_reading_and_not_in_the_force() -> None:
    seen, mass, weight = contact(SECONDS), 0.2, (0.0, 0.0, -1.962)
    acceleration = np.gradient(contact_motion(len(seen.time))[1], STEP, axis=0)
    raw = seen.measurement.copy()
    raw[:, 6:] += np.array(weight) - mass * acceleration
    limit = 0.5 * np.abs(raw[:, 7]).max()
    raw[:, 6:8] = raw[:, 6:8].clip(-limit, limit)
    options = probe.ProbeOptions(mass, weight, STEP)
    fixed, readout = probe.settings(options), probe.initial_readout(options)
    handed = np.empty((len(raw), sum(probe.PORT_SIZES.values())))
    for k, sample in enumerate(raw):
        probe.compensate(sample, seen.in_contact[k], math.inf, readout, fixed)
        handed[k] = readout[: handed.shape[1]]
    measurement, flag, reading = handed[:, :9], handed[:, 9], handed[:, 13:16]
    assert set(np.abs(reading[:, 1])[np.abs(reading[:, 1]) >= limit]) == {limit}
    blind = estimate_output_error(measurement, flag, OutputErrorOptions(step=STEP))
    told = estimate_output_error(measurement, flag, OutputErrorOptions(step=STEP), reading=reading)
    assert Status.SATURATED not in blind.status
    assert Status.SATURATED in told.status
    assert free_running_error(told.theta[-1], seen) < 0.02 < free_running_error(blind.theta[-1], seen)


@pytest.mark.parametrize(
    ("missing", "broken"), [(-1500, True), (-1, True), (0, False), (1, False), (199, False), (200, False), (201, True)]
)
def test_a_gap_of_up_to_two_tenths_of_a_second_is_bridged_and_anything_else_breaks_the_window(
    missing: int, broken: bool
) -> None:
    options = OutputErrorOptions(step=STEP)
    fixed = gate.settings(options)
    readout = gate.initial_readout(fixed, Learner(options).beginning())
    seen = contact(SECONDS)
    for k in range(60):
        t = seen.time[k] + (missing * STEP if k >= 30 else 0.0)
        gate.tick(seen.measurement[k], seen.measurement[k, 6:], 1.0, t, t, readout, fixed)
        if k == 30:
            assert (readout[STATUS] == Status.JUMPED) == (missing != 0)
    waiting = int(readout[MEMORY][COUNT])
    assert waiting == ((30 if broken else 60 + missing) // fixed.ticks)
    assert gate.take_samples(readout, fixed)[1] == broken


def ticked(data: Array, flag: Array, time: Array) -> tuple[Array, Array]:
    """The waiting samples of the fit (k, SAMPLE_SIZE), and the force along x that was believed last (n,)."""
    fixed = gate.settings(OutputErrorOptions(step=STEP))
    readout = gate.initial_readout(fixed, Learner(OutputErrorOptions(step=STEP)).beginning())
    believed = np.empty(len(data))
    for k, sample in enumerate(data):
        gate.tick(sample, sample[6:], flag[k], time[k], time[k], readout, fixed)
        believed[k] = readout[FILTERED][0]
    memory = readout[MEMORY]
    return memory[ROWS:].reshape(-1, SAMPLE_SIZE)[: int(memory[COUNT])], believed


@pytest.mark.parametrize("begins", [30, 60, 90])
@pytest.mark.parametrize("touches", [True, False])
def test_a_contact_that_lasts_counts_from_its_first_sample_on(begins: int, touches: bool) -> None:
    seen, ticks = contact(SECONDS), np.arange(120)
    waiting, _ = ticked(seen.measurement[:120], np.where((ticks >= begins) == touches, 1.0, 0.0), seen.time)
    np.testing.assert_array_equal(waiting[:, CONTACT], (ticks[::5] >= begins) == touches)


@pytest.mark.parametrize("missing", [0, 20, 199])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_position_may_have_moved_by_three_metres_a_second_and_a_millimetre_in_a_gap(
    missing: int, share: float
) -> None:
    data, time = np.zeros((31, 9)), np.arange(31) * STEP
    data[:, 6] = np.arange(31)
    time[30:] += missing * STEP
    data[30, 1] = share * (3.0 * (missing + 1) * STEP + 1e-3)
    _, believed = ticked(data, np.ones(31), time)
    assert believed[30] == (30.0 if share < 1.0 else 29.0)


@pytest.mark.parametrize("spoilt", [0, 4, 8])
def test_one_sample_that_is_not_finite_is_told_for_a_tenth_of_a_second(spoilt: int) -> None:
    seen = contact(SECONDS)
    data = seen.measurement.copy()
    data[BAD.start, spoilt] = np.nan
    status = estimate_output_error(data, seen.in_contact, OutputErrorOptions(step=STEP)).status
    told = np.flatnonzero(status == Status.NOT_FINITE)
    np.testing.assert_array_equal(told, BAD.start + np.arange(100))


def test_nothing_but_nan_leaves_the_prior() -> None:
    trace = estimate_output_error(np.full((500, 9), np.nan), np.ones(500))
    assert (trace.theta == trace.theta[0]).all()
    assert (trace.status[1:] == Status.NOT_FINITE).all()


def test_a_hand_at_rest_on_a_sensor_without_noise_is_no_fault() -> None:
    data = np.zeros((1000, 9))
    data[:, 2], data[:, 8] = -0.005, 2.5
    trace = estimate_output_error(data, np.ones(1000))
    assert (trace.status[10:] == Status.LEARNING).all()


def test_a_force_that_was_zero_in_free_space_is_no_fault_at_the_touch() -> None:
    seen = contact(SECONDS, noise=0.0)
    data, flag = seen.measurement.copy(), seen.in_contact.copy()
    first = int(np.flatnonzero(flag)[0])
    landing = np.flatnonzero(flag[first:])[:300] + first
    data[landing, :2], data[landing, 3:5], data[landing, 6:8] = data[first, :2], 0.0, 0.0  # straight down, and rests
    data[:first, :2] = data[first, :2] + np.linspace(-0.03, 0.0, first)[:, None]
    data[:first, 3:5] = 0.03 / (first * STEP)
    trace = estimate_output_error(data[: first + 300], flag[: first + 300])
    assert set(np.unique(trace.status)) <= {Status.LEARNING, Status.FREE}


@pytest.mark.study
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_an_object_that_slides_evenly_is_no_fault(noise: float) -> None:
    """Its force hardly changes while the probe moves on; at first it is shaken, so that there is something to hear."""
    time = np.arange(6000) * STEP
    velocity = np.where(time < 2.0, 0.2 * np.sin(20.0 * time), 0.01)
    data = np.zeros((len(time), 9))
    data[:, 1], data[:, 4] = np.cumsum(velocity) * STEP, velocity
    data[:, 2] = -0.005
    data[:, 7] = -0.5 * np.sign(velocity) - 15.0 * velocity + 1e-13 * np.arange(len(time))
    data[:, 8] = 2.5
    deviation = noise / 0.02 * np.repeat([1e-5, 5e-4, 0.02], 3)
    data += deviation * np.random.default_rng(6).standard_normal(data.shape)
    trace = estimate_output_error(data, np.ones(len(time)))
    assert (trace.status[10:] == Status.LEARNING).all()


def test_a_body_that_never_ends_to_stick_and_slide_leaves_what_was_known(monkeypatch: pytest.MonkeyPatch) -> None:
    def endless(*_: object) -> None:
        raise RuntimeError("the body sticks and slides more than 1000 times within one step")

    learner = Learner(OutputErrorOptions())
    known = estimate_output_error(contact(SECONDS).measurement[:1500], contact(SECONDS).in_contact[:1500]).knowledge
    monkeypatch.setattr(fit, "replay_window", endless)
    after = learner.learned(known, known.window.samples[:10], broken=True)
    np.testing.assert_array_equal(after.theta, known.theta)
    assert len(after.window) == 10
