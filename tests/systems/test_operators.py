"""Operators: the motion they promise at any time."""

import math

import numpy as np
import pytest
from hand_recording import hand_motion
from pydrake.systems.analysis import Simulator

from mmt_drake.errors import BadInput
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.systems.interactive_operator import InteractiveOperator
from mmt_drake.systems.scripted_operator import ScriptedOperator
from mmt_drake.viewer.viewer import Viewer


@pytest.fixture(scope="module")
def viewer():
    with Viewer("") as opened:
        yield opened


def motion_at(operator, t):
    context = operator.CreateDefaultContext()
    context.SetTime(t)
    return operator.GetOutputPort("motion").Eval(context)


@pytest.mark.parametrize("t", [0.0, 0.3217, 17.5, 61.2])
def test_scripted_hand_is_where_its_motion_says(t):
    motion = scripted_motion("strokes")
    np.testing.assert_array_equal(motion_at(ScriptedOperator(motion), t), np.concatenate(motion.at(t)))


def test_recorded_hand_passes_through_its_samples_and_then_rests():
    hand = hand_motion()
    operator = ScriptedOperator(hand)
    for i in (0, 1234, len(hand.time) - 1):
        np.testing.assert_array_equal(
            motion_at(operator, hand.time[i]), np.concatenate([hand.position[i], hand.velocity[i]])
        )
    np.testing.assert_array_equal(
        motion_at(operator, hand.time[-1] + 100.0), np.concatenate([hand.position[-1], np.zeros(3)])
    )


def test_interactive_hand_follows_a_slider_critically_damped(viewer):
    operator = InteractiveOperator(viewer, bandwidth=1.5)
    simulator = Simulator(operator)
    port = operator.GetOutputPort("motion")
    np.testing.assert_allclose(port.Eval(simulator.get_context()), [0, 0, 0.02, 0, 0, 0])
    simulator.AdvanceTo(0.1)
    np.testing.assert_allclose(port.Eval(simulator.get_context()), [0, 0, 0.02, 0, 0, 0], atol=1e-12)
    viewer.values["hand y [m]"] = 0.06
    viewer.values["hand z [m]"] = -0.005
    simulator.AdvanceTo(0.6)
    w = 2.0 * math.pi * 1.5
    since = 0.6 - 0.101  # read at 0.1 s, followed from the next step on
    risen = 1.0 - (1.0 + w * since) * math.exp(-w * since)
    rate = w * w * since * math.exp(-w * since)
    np.testing.assert_allclose(
        port.Eval(simulator.get_context()),
        [0.0, 0.06 * risen, 0.02 - 0.025 * risen, 0.0, 0.06 * rate, -0.025 * rate],
        atol=1e-9,
    )


def test_interactive_hand_refuses_a_filter_that_is_none(viewer):
    with pytest.raises(BadInput, match="bandwidth"):
        InteractiveOperator(viewer, bandwidth=0.0)


def test_interactive_hand_never_exceeds_its_speed_however_far_the_sliders_jump(viewer):
    operator = InteractiveOperator(viewer, bandwidth=3.0, greatest_speed=0.25)
    simulator = Simulator(operator)
    port = operator.GetOutputPort("motion")
    fastest, now = 0.0, 0.0
    for y in (0.1, -0.1, 0.1, -0.1, 0.0):
        viewer.values["hand y [m]"] = y
        for _ in range(60 if y else 300):
            now += 0.005
            simulator.AdvanceTo(now)
            fastest = max(fastest, abs(port.Eval(simulator.get_context())[4]))
    assert 0.24 < fastest <= 0.25
    np.testing.assert_allclose(port.Eval(simulator.get_context()), [0, 0, 0.02, 0, 0, 0], atol=1e-6)


@pytest.mark.parametrize("value", [math.nan, math.inf, -0.2, 1e300])
def test_interactive_hand_does_not_believe_what_no_slider_can_say(viewer, value):
    operator = InteractiveOperator(viewer)
    simulator = Simulator(operator)
    viewer.values["hand y [m]"] = value
    simulator.AdvanceTo(0.3)
    motion = operator.GetOutputPort("motion").Eval(simulator.get_context())
    np.testing.assert_allclose(motion, [0, 0, 0.02, 0, 0, 0], atol=1e-12)
