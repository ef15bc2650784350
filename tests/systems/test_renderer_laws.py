"""Laws that the renderer is told by its port or its option: the station's object with a cubic spring, and refusals."""

import numpy as np
import pytest

from mmt_drake.diagrams.stations.scenario import load_scenario, scenario_from
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect
from mmt_drake.rendering.status import RENDERING, TOO_FAST
from mmt_drake.rendering.structures import COUPLING
from mmt_drake.systems.impedance_reflection import ImpedanceRenderer

STEP = 1e-3
THETA = FlexibleBoxModel().theta()


def told(name, values, number=1):
    return ModelMessage(UNKNOWN_THETA, effects=(ToldEffect(name, values),), number=number)


def rendered(motion, message=None, theta=THETA, **options):
    """(n, 4) force and status of every tick under a motion (n, 6) in contact."""
    system = ImpedanceRenderer(**options)
    context = system.CreateDefaultContext()
    fixed = {"theta": theta, "stable": [1.0], "in_contact": [1.0]}
    fixed |= {} if message is None else {"model": message.vector()}
    for name, value in fixed.items():
        system.GetInputPort(name).FixValue(context, value)
    found = np.empty((len(motion), 4))
    for k, row in enumerate(motion):
        context.SetTime(k * STEP)
        system.GetInputPort("motion").FixValue(context, row)
        found[k] = system.GetOutputPort("readout").Eval(context)[:4]
        context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
    return found


def strokes(n, speed=0.2):
    t = np.arange(n) * STEP
    still = np.zeros(n)
    return np.column_stack([
        still, 0.01 * np.sin(speed / 0.01 * t), still - 0.004, still, speed * np.cos(speed / 0.01 * t), still
    ])  # fmt: skip


def test_the_port_and_the_option_tell_the_same():
    cubic = told("nonlinear_stiffness", {"k3": 3e6})
    by_port, by_option = rendered(strokes(400), cubic), rendered(strokes(400), model=cubic)
    assert np.array_equal(by_port, by_option)
    assert np.abs(by_port - rendered(strokes(400))).max() > 0.1


def test_a_law_that_turns_out_too_fast_is_left_out_and_the_force_goes_on():
    fast = told("hysteresis", {"alpha": 100.0, "beta": 1e9})
    motion = strokes(300)
    found, bare = rendered(motion, fast), rendered(motion)
    assert found[-1, 3] == TOO_FAST and bare[-1, 3] == RENDERING
    np.testing.assert_allclose(found[:, :3], bare[:, :3], atol=1e-3 * np.abs(bare[:, :3]).max())


def scenario(**changes):
    cubic = {"name": "nonlinear_stiffness", "parameters": {"k3": 3e6}}
    renderer = {"!": "ImpedanceReflection", "effects": [cubic]} | changes.pop("renderer", {})
    return scenario_from({"renderer": renderer, **changes})


def test_a_scenario_says_which_laws_the_renderer_knows():
    assert scenario().renderer.effects == (ToldEffect("nonlinear_stiffness", {"k3": 3e6}),)


@pytest.mark.parametrize(
    ("effect", "line"),
    [
        ({"name": "levitation", "parameters": {}}, "renderer.*'levitation'"),
        ({"name": "force_bias", "parameters": {"bias": 0.1}}, "renderer.force_bias: found .*never felt"),
        ({"name": "nonlinear_stiffness", "parameters": {"k3": -3e6}}, "renderer.nonlinear_stiffness: .*k3 >= 0"),
        ({"name": "nonlinear_stiffness", "parameters": {"k3": "much"}}, "k3: found 'much'"),
        ({"name": "nonlinear_stiffness", "values": {"k3": 1.0}}, "the key 'values'"),
    ],
)
def test_a_scenario_with_laws_that_are_not_to_be_felt_is_refused(effect, line):
    with pytest.raises(BadInput, match=line):
        scenario(renderer={"effects": [effect]})


def test_a_spring_is_stiffness_times_the_way_from_where_it_was_touched_whatever_else_theta_says():
    motion, k2, k = strokes(400), THETA[2], THETA[6]
    found = rendered(motion, structure="spring")
    np.testing.assert_allclose(found[:, 1], -k2 * (motion[:, 1] - motion[0, 1]), atol=1e-9)
    np.testing.assert_allclose(found[:, 2], -k * motion[:, 2], atol=1e-9)


def test_a_mass_spring_damper_is_its_equation_behind_the_virtual_coupling():
    t, speed, stiff = np.arange(2000) * STEP, 0.05, 40.0
    theta = THETA.copy()
    theta[1] = stiff
    found = rendered(strokes(len(t), speed), structure="mass_spring_damper", theta=theta)
    m, b, s = theta[0], theta[3], 1j * speed / 0.01
    K, B, Z = COUPLING**2 * m, 2.0 * COUPLING * m, m * s**2 + b * s + stiff
    behind, bare = (np.imag(-0.01 * G * np.exp(s * t)) for G in ((K + B * s) * Z / (K + B * s + Z), Z))
    settled = t > 0.5
    np.testing.assert_allclose(found[settled, 1], behind[settled], atol=2e-3 * np.abs(bare).max())
    np.testing.assert_allclose(found[settled, 1], bare[settled], atol=0.02 * np.abs(bare).max())


@pytest.mark.parametrize("structure", ["mass_spring_damper", "spring"])
def test_a_scenario_chooses_the_structure_and_none_but_the_flexible_box_has_laws(structure):
    chosen = [f"renderer.structure={structure}"]
    assert load_scenario("setup1", chosen).renderer.structure == structure
    with pytest.raises(BadInput, match=r"renderer.structure: found " + structure):
        load_scenario("setup1-learning", chosen)
    with pytest.raises(BadInput, match="effects: found nonlinear_stiffness, expected none"):
        load_scenario("setup1", [*chosen, "renderer.effects=[{name: nonlinear_stiffness, parameters: {k3: 3.0e6}}]"])
    with pytest.raises(BadInput, match="structure"):
        ImpedanceRenderer(structure="jelly")
