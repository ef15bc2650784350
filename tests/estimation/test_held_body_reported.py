"""The estimator reports where friction holds the body: the plant's own position, at the time of the stamp."""

import numpy as np

from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model import flexible_box as box
from mmt_drake.model.held_body import HELD_ANCHOR, HELD_ENTRY, HELD_POSITION, HELD_SIZE, HELD_STAMP, report
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.motion.scripted import scripted_motion

STEP = 1e-3
HOLDING = FlexibleBoxModel(
    BoxParameters(m=2.4, k1=45.0, k2=418.0, b1=53.0, b2=35.0, Fc=1.7), NormalContact(k=418.0, b=35.0)
)


def test_it_is_the_plants_own_position_at_that_time() -> None:
    n = 6000
    time = np.arange(n) * STEP
    position, velocity = scripted_motion("strokes", duration=20.0, lifts=0).sample(time)
    force, body = np.empty((n, 3)), np.empty((n, 4))
    box.replay(time, position, velocity, np.full(n, box.CONTACT_BY_GEOMETRY), HOLDING.kernel_vector(), force, body)
    contact = position[:, 2] < 0.0
    noise = np.random.default_rng(0).normal(0.0, np.repeat([1e-5, 5e-4, 0.02], 3), (n, 9))
    reported = estimate_output_error(
        np.hstack([position, velocity, force]) + noise, contact, OutputErrorOptions(step=STEP)
    ).held_body
    assert np.all(reported[np.flatnonzero(contact)[0]] == 0.0)  # nothing before there is a fit
    touch = np.flatnonzero(contact[1:] & ~contact[:-1])[-1] + 1
    for i in range(2):
        last = reported[-1, HELD_ENTRY * i : HELD_ENTRY * (i + 1)]
        stamp = round(last[HELD_STAMP] / STEP)
        assert n - 500 < stamp < n - 50  # as old as the delay of the fit says, and no older than a stroke
        assert body[stamp, 2 + i] == 0.0
        assert abs(last[HELD_POSITION] - body[stamp, i]) < 1e-4
        anchor = position[touch, i] - body[touch, i]
        assert abs(last[HELD_ANCHOR] - anchor) < 3e-4  # the probe crosses the surface between two samples
    assert np.abs(body[-1, :2]).max() > 1e-3


def test_an_axis_that_slides_keeps_the_report_before_counted_as_it_is_now() -> None:
    before, bodies = np.arange(HELD_SIZE, dtype=np.float64), np.zeros((2, 13))
    bodies[0, :4] = 0.1, 0.0, 0.2, 0.0  # held
    bodies[1, :4] = 0.3, 0.01, 0.4, 1.0  # slides
    of_y = [3.0 + 4.0 - 0.4, 0.4, 5.0]  # as far as the contact spring goes, the same
    np.testing.assert_array_equal(report(before, bodies, 7.0), [0.1, 0.2, 7.0, *of_y, 7.0])
    bodies[0, 1] = 1e-6  # moves without friction
    np.testing.assert_array_equal(report(before, bodies, 7.0), [0.0 + 1.0 - 0.2, 0.2, 2.0, *of_y, 7.0])
    np.testing.assert_array_equal(before, np.arange(HELD_SIZE))
