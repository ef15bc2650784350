"""Drake: the object as a linear system under Drake's integrators, and as a multibody plant with its own time stepping.

All of it is native: no Python runs between two steps.
"""

import time
from functools import partial

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    PdControllerGains,
    PrismaticJoint,
    PrismaticSpring,
    SpatialInertia,
    default_model_instance,
)
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import LinearSystem, Multiplexer, Sine, TrajectorySource, VectorLogSink
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.diagrams.proof.experiments.engines.method import STEP, Method, Setting, Trace, us_per_step
from mmt_drake.model.linear import state_space

_AXIS = (0.0, 1.0, 0.0)
_RADIUS = 0.1  # [m] of the body, which never turns


def _input(builder: DiagramBuilder, setting: Setting) -> OutputPort:
    """The probe's position and velocity, at all times."""
    probe = setting.probe
    if probe.input == "sampled":
        x, v = probe.at_samples()
        path = PiecewisePolynomial.CubicHermite(probe.times, x[None, :], v[None, :])
        return builder.AddSystem(TrajectorySource(path, output_derivative_order=1)).get_output_port()
    sine = builder.AddSystem(Sine(amplitude=1.0, frequency=probe.omega, phase=0.0, size=1))
    both = builder.AddSystem(Multiplexer(2))
    for i in range(2):  # position, velocity
        builder.Connect(sine.get_output_port(i), both.get_input_port(i))
    return both.get_output_port()


def _advanced(simulator: Simulator, setting: Setting) -> float:
    """Run to the end; processor time of a step [us]."""
    simulator.Initialize()
    start = time.process_time()
    simulator.AdvanceTo(setting.probe.times[-1])
    return us_per_step(start, setting.probe.steps)


def _integrate(setting: Setting, scheme: str) -> Trace:
    builder = DiagramBuilder()
    object_ = builder.AddNamedSystem("object", LinearSystem(*state_space(setting.parameters)))
    builder.Connect(_input(builder, setting), object_.get_input_port())
    log = builder.AddSystem(VectorLogSink(1, STEP))
    builder.Connect(object_.get_output_port(), log.get_input_port())
    simulator = Simulator(builder.Build())
    ResetIntegratorFromFlags(simulator, scheme, STEP).set_fixed_step_mode(True)
    simulator.get_mutable_context().SetContinuousState(setting.body_at_start())
    us = _advanced(simulator, setting)
    return Trace(log.FindLog(simulator.get_context()).data()[0], us)


def _step_plant(setting: Setting) -> Trace:
    """The contact spring and damper are the gains of a PD controller, which the plant's solver takes implicitly."""
    p, builder = setting.parameters, DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(STEP))
    body = plant.AddRigidBody("object", SpatialInertia.SolidSphereWithMass(p.m, _RADIUS))
    joint = plant.AddJoint(PrismaticJoint("slide", plant.world_frame(), body.body_frame(), _AXIS, damping=p.b1))
    if p.k1 > 0.0:
        plant.AddForceElement(PrismaticSpring(joint, 0.0, p.k1))
    plant.AddJointActuator("contact", joint).set_controller_gains(PdControllerGains(p=p.k2, d=p.b2))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    builder.Connect(_input(builder, setting), plant.get_desired_state_input_port(default_model_instance()))
    log = builder.AddSystem(VectorLogSink(2, STEP))
    builder.Connect(plant.get_state_output_port(), log.get_input_port())
    simulator = Simulator(builder.Build())
    at_start = plant.GetMyContextFromRoot(simulator.get_mutable_context())
    plant.SetPositionsAndVelocities(at_start, setting.body_at_start())
    us = _advanced(simulator, setting)
    return Trace(setting.force(*log.FindLog(simulator.get_context()).data()), us)


_SCHEMES = ("explicit_euler", "implicit_euler", "runge_kutta2", "runge_kutta3", "runge_kutta5", "radau3")

METHODS = (
    *(Method("drake", scheme, partial(_integrate, scheme=scheme)) for scheme in _SCHEMES),
    Method("drake", "multibody plant, SAP", _step_plant),
)
