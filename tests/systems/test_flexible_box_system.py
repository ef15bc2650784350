"""The environment as a system: aligned outputs, noise, touch and release, a cloud that moves along."""

import numpy as np
import pytest
from driven import STEP, driven
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.cloud import plane
from mmt_drake.errors import BadInput
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.systems.flexible_box import FlexibleBox, SensorNoise
from mmt_drake.systems.scripted_operator import ScriptedOperator
from mmt_drake.systems.surface_system import PORT_SIZES

MODEL = FlexibleBoxModel(BoxParameters(k1=30), friction=Friction(0.3, 0.2, 0.002))


def hand(n=3000):
    t = np.arange(n) * STEP
    position = np.column_stack([0.03 * np.sin(9 * t), 0.02 * np.sin(5 * t), 0.004 * np.cos(6 * t) + 0.001])
    velocity = np.column_stack([0.27 * np.cos(9 * t), 0.1 * np.cos(5 * t), -0.024 * np.sin(6 * t)])
    return t, position, velocity


def run(system, time, position, velocity, *, end=None):
    """Every vector output at every tick, by name, and the context in the end."""
    motion = ScriptedOperator(SampledMotion(time, position, velocity))
    return driven(system, PORT_SIZES, time[-1] if end is None else end, motion=motion)


def test_outputs_of_one_tick_belong_to_the_input_of_that_tick():
    time, position, velocity = hand()
    out, _ = run(FlexibleBox(MODEL), time, position, velocity)
    force, body = np.empty((len(time), 3)), np.empty((len(time), 4))
    box.replay(
        time, position, velocity, np.full(len(time), box.CONTACT_BY_GEOMETRY), MODEL.kernel_vector(), force, body
    )
    np.testing.assert_allclose(out["force"], force, atol=1e-9)
    np.testing.assert_allclose(out["body"], body, atol=1e-11)
    np.testing.assert_array_equal(out["measurement"], np.hstack([position, velocity, out["force"]]))
    np.testing.assert_array_equal(out["in_contact"][:, 0], position[:, 2] < 0)


def test_between_updates_the_output_is_integrated_up_to_now():
    time, position, velocity = hand()
    system = FlexibleBox(MODEL)
    _, context = run(system, time, position, velocity, end=1.2345)
    force = system.GetOutputPort("force").Eval(context)
    fine = np.append(time[:1235], 1.2345)
    there, moving = SampledMotion(time, position, velocity).sample(fine)
    expected, body = np.empty((len(fine), 3)), np.empty((len(fine), 4))
    contact = np.full(len(fine), box.CONTACT_BY_GEOMETRY)
    box.replay(fine, there.copy(), moving.copy(), contact, MODEL.kernel_vector(), expected, body)
    np.testing.assert_allclose(force, expected[-1], atol=1e-9)


def test_noise_has_the_stated_deviation_is_white_and_leaves_the_truth_alone():
    time, position, velocity = hand(20000)
    noisy, _ = run(FlexibleBox(MODEL, noise=SensorNoise(0.02, 1e-5, 5e-4, seed=4)), time, position, velocity)
    clean, _ = run(FlexibleBox(MODEL), time, position, velocity)
    np.testing.assert_array_equal(noisy["force"], clean["force"])
    error = noisy["measurement"] - clean["measurement"]
    np.testing.assert_allclose(error.std(axis=0), np.repeat([1e-5, 5e-4, 0.02], 3), rtol=0.03)
    correlation = np.corrcoef(np.hstack([error[1:], error[:-1]]).T) - np.eye(18)
    assert np.abs(correlation).max() < 0.03


def test_the_seed_decides_the_noise():
    time, position, velocity = hand(200)

    def measured(seed):
        system = FlexibleBox(MODEL, noise=SensorNoise(force=0.02, seed=seed))
        return run(system, time, position, velocity)[0]["measurement"]

    np.testing.assert_array_equal(measured(1), measured(1))
    assert np.all(measured(1)[:, 6:] != measured(2)[:, 6:])


def test_the_cloud_moves_with_the_body_at_its_own_rate():
    time, position, velocity = hand()
    surface = plane(400, (0.2, 0.2))
    system = FlexibleBox(MODEL, surface=surface, cloud_period=0.1)
    out, context = run(system, time, position, velocity, end=1.25)
    cloud = system.GetOutputPort("point_cloud").Eval(context)
    assert cloud.stamp == pytest.approx(1.2)
    np.testing.assert_allclose(cloud.points() - surface.points(), [[*out["body"][1200, :2], 0.0]] * 400, atol=1e-15)
    assert np.abs(out["body"][1200, :2]).min() > 1e-4


def test_cloud_noise_is_fresh_in_every_cloud_and_has_the_stated_deviation():
    time, position, velocity = hand()
    surface = plane(2000)
    clouds = []
    for end in (0.05, 0.15):
        system = FlexibleBox(MODEL, surface=surface, cloud_period=0.1, cloud_noise=1e-3)
        _, context = run(system, time, position, velocity, end=end)
        clouds.append(system.GetOutputPort("point_cloud").Eval(context))
    errors = [cloud.points()[:, 2] for cloud in clouds]
    np.testing.assert_allclose([error.std() for error in errors], 1e-3, rtol=0.06)
    assert abs(np.corrcoef(errors)[0, 1]) < 0.1


def test_told_contact_overrules_geometry():
    pressed, apart = ConstantVectorSource([0, 0, -0.01, 0, 0, 0]), ConstantVectorSource([0.0])
    out, _ = driven(FlexibleBox(MODEL, told_contact=True), ["force"], 0.0, motion=pressed, contact=apart)
    np.testing.assert_array_equal(out["force"], np.zeros((1, 3)))


@pytest.mark.parametrize(
    "arguments", [{"period": -1.0}, {"cloud_period": 0.0}, {"cloud_noise": float("nan")}, {"period": float("inf")}]
)
def test_meaningless_settings_are_refused(arguments):
    with pytest.raises(BadInput, match="environment"):
        FlexibleBox(MODEL, **arguments)


@pytest.mark.parametrize("kind", [SensorNoise, BoxParameters, Friction])
def test_negative_parameters_are_refused(kind):
    first = next(iter(kind.__dataclass_fields__))
    with pytest.raises(BadInput, match=first):
        kind(**{first: -1.0})
