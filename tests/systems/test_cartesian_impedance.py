"""The impedance controller: it carries the weight, yields as it should, and keeps the posture out of the tip's way."""

import numpy as np
import pytest
from gantry import MASS, gantry
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from mmt_drake.errors import BadInput
from mmt_drake.systems.cartesian_impedance import CartesianImpedance, Impedance

TABLE = RigidTransform(RollPitchYaw(0.0, 0.0, 0.5 * np.pi), np.array([0.3, 0.0, 0.1]))
GAINS = Impedance(stiffness=800.0, damping=90.0)


def torque_of(commanded: np.ndarray, state: np.ndarray) -> np.ndarray:
    plant, tip = gantry()
    system = CartesianImpedance(plant, tip, TABLE, np.zeros(3), GAINS)
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, state)
    system.GetInputPort("commanded").FixValue(context, commanded)
    return system.GetOutputPort("torque").Eval(context)


def test_its_force_is_spring_and_damper_in_the_table_frame_and_the_weight() -> None:
    position, velocity = np.array([0.02, -0.01, 0.05]), np.array([0.1, 0.2, -0.3])
    commanded = np.array([0.01, 0.0, -0.02, 0.0, 0.1, 0.2])
    away = TABLE @ commanded[:3] - position
    slower = TABLE.rotation().matrix() @ commanded[3:] - velocity
    # Only the rail along z carries weight: what hangs on it.
    expected = 800.0 * away + 90.0 * slower + np.array([0.0, 0.0, 9.81 * MASS])
    np.testing.assert_allclose(torque_of(commanded, np.concatenate([position, velocity])), expected, rtol=1e-9)


def test_it_tells_the_motion_of_the_tip_in_the_table_frame() -> None:
    plant, tip = gantry()
    system = CartesianImpedance(plant, tip, TABLE, np.zeros(3))
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, [0.3, 0.2, 0.1, 0.0, 0.5, 0.25])
    np.testing.assert_allclose(
        system.GetOutputPort("motion").Eval(context), [0.2, 0.0, 0.0, 0.5, 0.0, 0.25], atol=1e-12
    )


def test_a_force_on_the_tip_deflects_it_by_force_over_stiffness() -> None:
    plant, tip = gantry()
    builder = DiagramBuilder()
    builder.AddSystem(plant)
    system = builder.AddSystem(CartesianImpedance(plant, tip, RigidTransform(), np.zeros(3), GAINS))
    builder.Connect(plant.get_state_output_port(), system.GetInputPort("state"))
    builder.Connect(system.GetOutputPort("torque"), plant.get_actuation_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    system.GetInputPort("commanded").FixValue(system.GetMyMutableContextFromRoot(context), np.zeros(6))
    own = plant.GetMyMutableContextFromRoot(context)
    plant.get_applied_generalized_force_input_port().FixValue(own, [4.0, 0.0, -2.0])
    simulator.AdvanceTo(3.0)
    np.testing.assert_allclose(plant.GetPositions(own), [4.0 / 800.0, 0.0, -2.0 / 800.0], atol=1e-6)


def test_the_posture_is_kept_as_far_as_the_tip_does_not_notice() -> None:
    """Two rails along y: one of them may go back while the other gives way, and the tip stays."""
    plant, tip = gantry("xyzy")
    gains = Impedance(posture_stiffness=10.0, posture_damping=0.0)
    system = CartesianImpedance(plant, tip, RigidTransform(), np.zeros(4), gains)
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, [0.0, 0.2, 0.0, 0.0, *np.zeros(4)])
    system.GetInputPort("commanded").FixValue(context, [0.0, 0.2, 0.0, 0.0, 0.0, 0.0])
    torque = system.GetOutputPort("torque").Eval(context)
    np.testing.assert_allclose(torque[[0, 1, 3]], [0.0, -1.0, 1.0], atol=1e-9)


@pytest.mark.parametrize("name", ["stiffness", "posture_damping"])
def test_a_gain_below_zero_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match=f"{name}: found -1"):
        Impedance(**{name: -1.0})
