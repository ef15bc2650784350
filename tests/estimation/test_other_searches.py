"""What steps downhill do not find: friction that holds the object, and a rest that tells nothing."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.objects import STEP, drawn, path_of
from mmt_drake.diagrams.proof.experiments.tick_by_tick import follow, measured_along
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.estimation.output_error.offline import OutputErrorTrace, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions, Prior
from mmt_drake.estimation.output_error.trials import start_elsewhere
from mmt_drake.estimation.output_error.unknowns import FRICTION, HIGH, LOW, prior_information
from mmt_drake.model.parameters import FlexibleBoxModel

OPTIONS = OutputErrorOptions(step=STEP, in_plane="vector")


def estimated(model: FlexibleBoxModel, path: np.ndarray, seed: int = 0) -> OutputErrorTrace:
    time = np.arange(len(path)) * STEP
    measurement, contact, _ = measured_along(time, path, model, NOISE, np.random.default_rng(seed))
    return estimate_output_error(measurement, contact, OPTIONS)


@pytest.mark.parametrize("number", [0, 7])
def test_friction_that_holds_the_object_between_slow_slides_is_found_and_is_no_other_object(number: int) -> None:
    model = replace(drawn(number), in_plane="vector")
    _, path = path_of("press_slide_lift", 45.0)
    trace = estimated(model, path[:17000])
    assert not np.isin(trace.model_status, (ModelStatus.MISFIT, ModelStatus.CHANGED)).any()
    _, k1, k2, _, b2, Fc = trace.theta[-1][:6]  # m hardly shows in slides
    assert (k1, k2, b2, Fc) == pytest.approx(tuple(model.theta()[[1, 2, 4, 5]]), rel=0.1)


def test_starts_elsewhere_go_from_no_friction_to_all_of_the_force_and_keep_within_bounds() -> None:
    prior = prior_information(Prior(), None)
    starts = np.array([start_elsewhere(prior, number, 4.0) for number in range(40)])
    assert ((starts >= LOW) & (starts <= HIGH)).all()
    assert starts[:, FRICTION].min() == 0.01 and starts[:, FRICTION].max() == 4.0


def pressed_at_rest_then_stroked(rest: float) -> np.ndarray:
    """Down to 4 mm, a rest [s], and 3 s of strokes."""
    _, strokes = path_of("strokes", 6.0)
    strokes = strokes[int(np.argmax(strokes[:, 2] < 0.0)) + 200 :][:3000]
    ticks = round(rest / STEP)
    path = np.zeros((ticks + len(strokes), 6))
    path[:ticks, 2] = 0.002 - 0.003 * (1.0 - np.cos(np.pi * np.minimum(np.arange(ticks) / 300.0, 1.0)))
    path[ticks:, 2] = path[ticks - 1, 2]
    begun = np.minimum(np.arange(len(strokes)) / 200.0, 1.0)[:, np.newaxis]
    path[ticks:, :2] = (strokes[:, :2] - strokes[0, :2]) * begun
    path[:, 3:] = np.gradient(path[:, :3], STEP, axis=0)
    return path


def test_a_rest_under_noise_leaves_the_body_at_its_prior_and_half_a_second_of_strokes_tells_them() -> None:
    model, path = FlexibleBoxModel(in_plane="vector"), pressed_at_rest_then_stroked(8.0)
    time = np.arange(len(path)) * STEP
    measurement, contact, force = measured_along(time, path, model, NOISE, np.random.default_rng(0))
    felt = follow(time, measurement, contact, OPTIONS, motion=path)
    m, k1, _, b1, _, Fc = felt.trace.theta[7900][:6]
    assert (m, k1, b1, Fc) == pytest.approx((0.5, 0.0, 15.0, 0.5), abs=1e-3)
    assert felt.trace.model_status[7900] == ModelStatus.UNEXCITED
    assert felt.trace.force_lateness[7900][2] < 0.001
    assert felt.trace.theta[-1][[0, 3, 4]] == pytest.approx(model.theta()[[0, 3, 4]], rel=0.1)

    def error(span: slice) -> float:
        off, true = (values[span, :2] for values in (felt.rendered - force, force))
        return float(np.linalg.norm(off) / np.linalg.norm(true))

    assert error(slice(8000, 9000)) < 0.35
    assert error(slice(8500, 9000)) < 0.05
    assert error(slice(9000, 11000)) < 0.02
