"""An impedance controller for the tip of an arm."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable
from pydrake.systems.framework import BasicVector, Context

from mmt_drake.ceilings import Bound
from mmt_drake.errors import check_number
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.leaf import LeafSystem

_ROBOT = "the arm's own controller, libfranka's setCartesianImpedance"
_DAMPING = "twice critical, at that stiffness and 5 kg, or 0.3 kg m^2"


@dataclass(frozen=True)
class Impedance:
    """How the arm yields. The bounds are those of a real one, `hw.franka.settings`.

    Attributes:
        stiffness, damping: of the tip's position [N/m], [N s/m].
        rotational_stiffness, rotational_damping: of its orientation [N m/rad], [N m s/rad].
        posture_stiffness, posture_damping: of the joints, as far as the tip does not notice [N m/rad], [N m s/rad].

    Raises:
        BadInput: a value that is negative or not finite.
    """

    stiffness: Annotated[float, Bound(3000.0, "N/m", _ROBOT)] = 1500.0
    damping: Annotated[float, Bound(490.0, "N s/m", _DAMPING)] = 120.0
    rotational_stiffness: Annotated[float, Bound(300.0, "N m/rad", _ROBOT)] = 100.0
    rotational_damping: Annotated[float, Bound(38.0, "N m s/rad", _DAMPING)] = 5.0
    posture_stiffness: Annotated[float, Bound(100.0, "N m/rad", "this project's own bound")] = 10.0
    posture_damping: Annotated[float, Bound(20.0, "N m s/rad", "this project's own bound")] = 3.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            check_number("impedance", name, value, least=0.0)


class CartesianImpedance(LeafSystem):
    """Pulls the tip of an arm to where it is commanded, like a spring and a damper, and carries the arm's weight.

    torque = -g(q) + J^T (w) + N^T (posture), w = (K (x_d - x) + D (v_d - v), K_r e - D_r omega), where e is the axis
    times the angle from the tip's orientation to the one it starts with, g the generalized gravity, and N = I - J^+ J
    the joints' motions that the tip does not notice. Forces that the tip meets deflect it, as the stiffness says.

    .. pydrake_system::

        name: CartesianImpedance
        input_ports:
        - state
        - commanded
        output_ports:
        - motion
        - torque

    Ports:

    - `state` (size of the plant's): positions and velocities of all joints [rad, rad/s or m, m/s].
    - `commanded` (6): where the tip should be [m], and its velocity [m/s], in the table frame.
    - `motion` (6): where it is [m], and its velocity [m/s], in the table frame.
    - `torque` (number of actuators): for the actuated joints [N m or N].

    Args:
        plant: the arm, finalized; it must outlive this system.
        tip: a frame of it.
        table: the table frame in the world.
        posture: positions of all joints, in which the tip has its orientation and to which they are drawn back.
        impedance: of the tip and of the joints.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        tip: Frame,
        table: RigidTransform,
        posture: Array,
        impedance: Impedance | None = None,
    ) -> None:
        super().__init__()
        self._plant, self._tip, self._table = plant, tip, table
        self._gains = impedance or Impedance()
        self._posture = np.array(posture, dtype=float)
        self._actuation = np.asarray(plant.MakeActuationMatrix()).T
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, self._posture)
        self._orientation = tip.CalcPoseInWorld(context).rotation()
        self._state = self.DeclareVectorInputPort("state", plant.num_multibody_states())
        self._commanded = self.DeclareVectorInputPort("commanded", 6)
        sources = {self._state.ticket()}
        self._arm = self.declare_cached("arm in its present state", self._new_arm, self._calc_arm, sources)
        self.DeclareVectorOutputPort("motion", 6, self._calc_motion, {self._state.ticket()})
        sources = {self._state.ticket(), self._commanded.ticket()}
        self.DeclareVectorOutputPort("torque", plant.num_actuated_dofs(), self._calc_torque, sources)

    def _new_arm(self) -> AbstractValue:
        return AbstractValue.Make(self._plant.CreateDefaultContext())

    def _calc_arm(self, context: Context, arm: AbstractValue) -> None:
        self._plant.SetPositionsAndVelocities(arm.get_mutable_value(), self._state.Eval(context))

    def _calc_motion(self, context: Context, output: BasicVector) -> None:
        arm: Context = self._arm.Eval(context)
        position = self._table.inverse() @ self._tip.CalcPoseInWorld(arm).translation()
        velocity = self._tip.CalcSpatialVelocityInWorld(arm).translational()
        output.SetFromVector(np.concatenate([position, self._table.rotation().matrix().T @ velocity]))

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        plant, gains, arm = self._plant, self._gains, self._arm.Eval(context)
        commanded: Array = self._commanded.Eval(context)
        world = plant.world_frame()
        pose, velocity = self._tip.CalcPoseInWorld(arm), self._tip.CalcSpatialVelocityInWorld(arm)
        jacobian = plant.CalcJacobianSpatialVelocity(arm, JacobianWrtVariable.kV, self._tip, np.zeros(3), world, world)
        away = self._table @ commanded[:3] - pose.translation()
        slower = self._table.rotation().matrix() @ commanded[3:] - velocity.translational()
        turned = RotationMatrix(self._orientation @ pose.rotation().inverse()).ToAngleAxis()
        wrench = np.concatenate(
            [
                gains.rotational_stiffness * turned.angle() * turned.axis()
                - gains.rotational_damping * velocity.rotational(),
                gains.stiffness * away + gains.damping * slower,
            ]
        )
        posture = gains.posture_stiffness * (self._posture - plant.GetPositions(arm))
        posture -= gains.posture_damping * plant.GetVelocities(arm)
        unnoticed = posture - jacobian.T @ np.linalg.lstsq(jacobian.T, posture, rcond=1e-6)[0]
        generalized = jacobian.T @ wrench + unnoticed - plant.CalcGravityGeneralizedForces(arm)
        output.SetFromVector(self._actuation @ generalized)
