"""A simulated Panda that holds a probe: an impedance controller at its tip, a force sensor at its wrist.

The arm's model comes from the package `example-robot-data` (the optional extra `arm`).
"""

from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, FixedOffsetFrame, Frame, JointIndex, SpatialInertia
from pydrake.solvers import Solve
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, DiscreteValues

from mmt_drake.errors import MissingDependency, MmtError
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.cartesian_impedance import CartesianImpedance, Impedance
from mmt_drake.systems.compliant_tip import WristSensor
from mmt_drake.systems.leaf import LeafSystem

_FLANGE: Final = "panda_link8"
_PACKAGE, _MODEL = "example-robot-data", "panda.urdf"
_INSTALL = "install the project with its extra: pip install -e '.[arm]' -c constraints.txt"
TABLE: Final = RigidTransform(np.array([0.5, 0.0, 0.2]))
"""The table frame, seen from the arm's base."""
_READY: Final = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 1.9, 0.785])  # [rad], from where the posture is sought
_PROBE_LENGTH: Final = 0.1  # [m] from the sensor to the tip
_GRAVITY: Final = 9.81


@dataclass(frozen=True)
class Arm:
    """The arm and what it holds.

    Attributes:
        impedance: of the controller.
        probe_mass: beyond the sensor [kg].
        sensor: at the wrist.
    """

    impedance: Impedance = field(default_factory=Impedance)
    probe_mass: float = 0.15
    sensor: WristSensor = field(default_factory=WristSensor)


def missing_arm() -> str | None:
    """Why there is no arm, in one line; None if there is one."""
    try:
        robot_file(_MODEL)
    except MissingDependency as error:
        return str(error)
    return None


def simulated_arm(arm: Arm, start: Array, step: float) -> Diagram:
    """The arm as a diagram, at rest with the tip at `start`.

    Inputs: `commanded` (6), where the tip should be [m] and its velocity [m/s]; `force` (3), what the environment
    exerts on it [N]. Outputs: `motion` (6), where it is, and `raw_measurement` (9), what the sensors read: position,
    velocity and the wrist's force with the sign of a force on the probe. All in the table frame.

    Args:
        arm: what is built.
        start: (3,) in the table frame [m].
        step: of the simulation [s].

    Raises:
        MissingDependency: the arm's model is not installed.
        MmtError: the arm does not reach the start.
    """
    builder = DiagramBuilder()
    plant = builder.AddNamedSystem("plant", MultibodyPlant(step))
    plant.SetUseSampledOutputPorts(False)  # the sensor reads what is, not what was a step ago
    (panda,) = Parser(plant).AddModelsFromString(without_hand(robot_file(_MODEL)), "urdf")
    for number in range(1, 8):
        plant.AddJointActuator(f"joint{number}", plant.GetJointByName(f"panda_joint{number}"))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("panda_link0"))
    half = 0.5 * _PROBE_LENGTH
    inertia = SpatialInertia.SolidCylinderWithMass(arm.probe_mass, 0.01, _PROBE_LENGTH, np.array([0.0, 0.0, 1.0]))
    probe = plant.AddRigidBody("probe", panda, inertia)
    sensor = plant.WeldFrames(
        plant.GetFrameByName(_FLANGE), probe.body_frame(), RigidTransform(np.array([0.0, 0.0, half]))
    )
    tip = plant.AddFrame(FixedOffsetFrame("tip", probe.body_frame(), RigidTransform(np.array([0.0, 0.0, half]))))
    plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -_GRAVITY]))
    plant.Finalize()
    posture = _posture(plant, tip, TABLE @ start)
    plant.SetDefaultPositions(posture)

    controller = builder.AddNamedSystem("controller", CartesianImpedance(plant, tip, TABLE, posture, arm.impedance))
    push = builder.AddNamedSystem("push", _TipForce(probe.index(), np.array([0.0, 0.0, half])))
    wrist = builder.AddNamedSystem("wrist", _WristSensor(probe.index(), sensor.index(), arm.sensor, step))
    builder.Connect(plant.get_state_output_port(), controller.GetInputPort("state"))
    builder.Connect(controller.GetOutputPort("torque"), plant.get_actuation_input_port())
    builder.Connect(push.GetOutputPort("spatial_forces"), plant.get_applied_spatial_force_input_port())
    builder.Connect(plant.get_body_poses_output_port(), wrist.GetInputPort("poses"))
    builder.Connect(plant.get_reaction_forces_output_port(), wrist.GetInputPort("reactions"))
    builder.Connect(controller.GetOutputPort("motion"), wrist.GetInputPort("motion"))
    builder.ExportInput(controller.GetInputPort("commanded"), "commanded")
    builder.ExportInput(push.GetInputPort("force"), "force")
    builder.ExportOutput(controller.GetOutputPort("motion"), "motion")
    builder.ExportOutput(wrist.GetOutputPort("raw_measurement"), "raw_measurement")
    return builder.Build()


@cache
def robot_file(name: str) -> Path:
    """The model of a robot of the package.

    Args:
        name: of the file.

    Raises:
        MissingDependency: it is not installed.
    """
    try:
        found = [file for file in metadata.files(_PACKAGE) or () if file.name == name]
    except metadata.PackageNotFoundError:
        found = []
    if not found:
        raise MissingDependency(f"{_PACKAGE} not found; {_INSTALL}")
    return Path(str(found[0].locate()))


def without_hand(model: Path) -> str:
    """The model as far as the flange, as URDF; nothing but what moves it is kept."""
    robot = ElementTree.parse(model).getroot()
    for child in list(robot):
        of_hand = any(part in child.get("name", "") for part in ("hand", "finger"))
        if child.tag not in ("link", "joint") or of_hand:
            robot.remove(child)
    for element in robot:
        for part in list(element):
            if part.tag in ("visual", "collision", "safety_controller"):
                element.remove(part)
    return ElementTree.tostring(robot, encoding="unicode")


def _posture(plant: MultibodyPlant, tip: Frame, at: Array) -> Array:
    """Positions of the joints with the tip at a place in the world, pointing down.

    Raises:
        MmtError: there are none.
    """
    search = InverseKinematics(plant)
    world, down = plant.world_frame(), RotationMatrix(RollPitchYaw(np.pi, 0.0, 0.0))
    search.AddPositionConstraint(tip, np.zeros(3), world, at, at)
    search.AddOrientationConstraint(world, RotationMatrix(), tip, down.inverse(), 0.0)
    program = search.get_mutable_prog()
    program.AddQuadraticErrorCost(np.eye(len(_READY)), _READY, search.q())
    result = Solve(program, _READY)
    if not result.is_success():
        raise MmtError(f"the arm does not reach {at} m in its base's frame")
    return np.asarray(result.GetSolution(search.q()))


class _TipForce(LeafSystem):
    """A force in the table frame on a point of a body, as a MultibodyPlant takes it."""

    def __init__(self, body: BodyIndex, point: Array) -> None:
        super().__init__()
        self._body, self._point = body, point
        self._force = self.DeclareVectorInputPort("force", 3)
        make = lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()])  # noqa: E731
        self.DeclareAbstractOutputPort("spatial_forces", make, self._calc, {self._force.ticket()})

    def _calc(self, context: Context, output: AbstractValue) -> None:
        push = ExternallyAppliedSpatialForce()
        push.body_index, push.p_BoBq_B = self._body, self._point
        push.F_Bq_W = SpatialForce(np.zeros(3), TABLE.rotation() @ self._force.Eval(context))
        output.set_value([push])


class _WristSensor(LeafSystem):
    """What arm and wrist measure: with offset, drift and noise."""

    def __init__(self, probe: BodyIndex, joint: JointIndex, sensor: WristSensor, step: float) -> None:
        super().__init__()
        self._probe, self._joint, self._sensor = int(probe), int(joint), sensor
        self._poses = self.DeclareAbstractInputPort("poses", AbstractValue.Make([RigidTransform()]))
        self._motion = self.DeclareVectorInputPort("motion", 6)
        self._reactions = self.DeclareAbstractInputPort("reactions", AbstractValue.Make([SpatialForce()]))
        self.DeclareDiscreteState(1)  # samples, for the noise
        self.DeclareVectorOutputPort("raw_measurement", 9, self._calc)
        self.DeclarePeriodicDiscreteUpdateEvent(step, 0.0, self._count)

    def _count(self, context: Context, state: DiscreteValues) -> None:
        state.get_mutable_value()[0] += 1.0

    def _calc(self, context: Context, output: BasicVector) -> None:
        reaction = self._reactions.Eval(context)[self._joint].translational()  # in the probe's frame
        turned = self._poses.Eval(context)[self._probe].rotation()
        # The joint carries the probe: what it exerts on it is the opposite of what the probe hangs on it with.
        read = -(TABLE.rotation().inverse() @ (turned @ reaction))
        sample = int(context.get_discrete_state_vector().value()[0])
        wrong = self._sensor.errors(context.get_time(), sample)
        output.SetFromVector(np.concatenate([self._motion.Eval(context), read]) + wrong)
