"""Noise on the measured motion makes no parameters: what it adds to the least squares is taken off."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.objects import STEP, drawn, path_of
from mmt_drake.diagrams.proof.experiments.tick_by_tick import behind_sensor, measured_along
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.offline import OutputErrorTrace, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.unknowns import TABLE, Stick, unknowns
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.numeric.least_squares import minimise

OPTIONS = OutputErrorOptions(step=STEP, in_plane="vector")
DELAY = 0.004


def estimated(motion: str, seconds: float) -> tuple[FlexibleBoxModel, OutputErrorTrace]:
    """An object whose damper passes the noise of the velocity on, its force late."""
    model = replace(drawn(0), in_plane="vector")
    time, path = path_of(motion, seconds)
    measurement, contact, force = measured_along(time, path, model, NOISE, np.random.default_rng(3))
    measurement[:, 6:] += behind_sensor(time, force, DELAY, 0.0) - force
    return model, estimate_output_error(measurement, contact, OPTIONS)


@pytest.mark.parametrize(("motion", "seconds"), [("reaches", 10.0), ("chirp", 14.0)])
def test_numbers_and_lateness_lie_within_three_of_their_deviations(motion: str, seconds: float) -> None:
    model, trace = estimated(motion, seconds)
    off = (trace.theta[-1] - model.theta())[:6] / trace.deviation[-1][:6]
    assert np.abs(off).max() < 3.0
    delay, _, total, of_delay, _, of_total = trace.force_lateness[-1]
    assert abs(total - DELAY) < 3.0 * of_total
    assert motion != "chirp" or abs(delay - DELAY) < 3.0 * of_delay


def test_on_a_body_that_hardly_moves_the_slope_is_that_of_the_noise_through_spring_and_damper() -> None:
    """Of half the sum of (k2 dx + b2 dv)^2 after log b2."""
    _, trace = estimated("reaches", 6.0)
    objective = Learner(OPTIONS)._objective(trace.knowledge)
    k2, b2 = 700.0, 30.0
    x = unknowns(np.array([50.0, 0.0, k2, 1000.0, b2, 0.0]))
    (slope,), _ = objective.slope_of_noise(x, Stick(), [list(TABLE).index("b2")])
    window = objective.window
    noise = (window.shaken - window.motion) * objective.weight[:1].T
    of_spring, of_damper = k2 * noise[:, :2], b2 * noise[:, 3:5]
    assert slope == pytest.approx(float(np.sum((of_spring + of_damper) * of_damper)), rel=0.1)


def test_of_an_object_that_is_not_moved_nothing_is_taken_off() -> None:
    """Its least squares know the noise alone, and without it nothing would be known."""
    n = 4000
    measurement = np.random.default_rng(0).standard_normal((n, 9)) * np.repeat([1e-5, 5e-4, 0.02], 3)
    measurement[:, 2] -= 0.004
    measurement[:, 8] += 2.0
    known = estimate_output_error(measurement, np.ones(n), OPTIONS).knowledge
    assert known.noise_slope[list(TABLE).index("b2")] == 0.0


@pytest.mark.parametrize("seed", [0, 3])
def test_in_the_first_second_the_noise_of_the_motion_makes_no_object_stiffer_and_stiffer(seed: int) -> None:
    """Stiff objects pass more of it on, and so what is taken off grew with what it had made: k2 came to 5700 N/m."""
    recording = run(load_scenario("setup1-free-running", [f"seed={seed}"]), seconds=1.2)
    learned = np.flatnonzero(recording["in_contact"])[300:]
    assert recording["theta_k2"][learned].max() < 2.0 * 500.0
    assert recording["theta_b2"][learned].max() < 2.0 * 60.0


def test_least_squares_beside_a_linear_term_end_where_both_slopes_cancel() -> None:
    wide, pull = np.array([9.0, 9.0]), np.array([0.5, -2.0])
    found = minimise(lambda x: x - [1.0, 2.0], np.zeros(2), -wide, wide, np.ones(2), pull=pull)
    np.testing.assert_allclose(found.x, [0.5, 4.0], atol=1e-6)
