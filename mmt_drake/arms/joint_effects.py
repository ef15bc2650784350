"""The effects of an arm's joints as a system beside its plant."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, Context, ContinuousState

from mmt_drake.arms.arm_file import ArmModel, JointEffect
from mmt_drake.arms.law_torque import instant
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.systems.leaf import LeafSystem

REST = 2e-3
"""Speed below which dry friction turns over from one direction to the other, and so does not hold a joint for ever."""

IN_THE_LOG = ("torque_gain", "time_delay", "force_lag", "joint_coupling")
"""Effects that no joint feels: they are in the log alone."""
UNFELT = (*IN_THE_LOG, "rotor_inertia", "payload", "gravity_offset", "joint_elasticity")
"""... and those that are the plant's own, or that a plant of stiff joints cannot have."""


class JointEffects(LeafSystem):
    """Generalized forces of drives and of what acts on the joints beside the links.

    .. pydrake_system::

        name: JointEffects
        input_ports:
        - state
        - torque
        output_ports:
        - force

    - ``state`` (plant's positions and velocities): of the plant [rad], [m], [rad/s], [m/s].
    - ``torque`` (joints): what the drives give to the recorded joints [N m], [N].
    - ``force`` (plant's velocities): generalized force on the plant [N m], [N].

    Dry friction turns over between -2e-3 and 2e-3 rad/s. Load-dependent friction grows with what of the drive's torque
    the other effects leave to the links.

    Args:
        arm: its plant is finalized.
        model: whose effects act.
    """

    def __init__(self, arm: ArmPlant, model: ArmModel) -> None:
        super().__init__()
        self._positions, self._of = arm.plant.num_positions(), arm.velocity_index
        self._velocities = arm.plant.num_velocities()
        self._at = arm.position_index
        felt = [e for e in model.effects if e.name not in UNFELT]
        felt.sort(key=lambda e: e.name == "load_dependent_friction")
        self._laws = [(arm.joints.index(e.where), e) for e in felt]
        self._remembering = [number for number, (_, e) in enumerate(self._laws) if e.name == "dahl_friction"]
        self.declare_inputs(state=self._positions + self._velocities, torque=len(arm.joints))
        if self._remembering:
            self.DeclareContinuousState(len(self._remembering))
        for _, effect in self._laws:  # compiled before the clock starts
            instant(effect.name, _numbers(effect), 0.0, 0.0, 0.0, 0.0, REST)
        self.DeclareVectorOutputPort("force", BasicVector(self._velocities), self._force)

    def _resisting(self, context: Context, number: int, load: float) -> tuple[float, float]:
        """The torque that a law takes, and the rate of its memory."""
        joint, effect = self._laws[number]
        state = self.GetInputPort("state").Eval(context)
        q, v = float(state[self._at[joint]]), float(state[self._positions + self._of[joint]])
        z = 0.0
        if number in self._remembering:
            z = float(context.get_continuous_state_vector()[self._remembering.index(number)])
        return instant(effect.name, _numbers(effect), q, v, load, z, REST)

    def _force(self, context: Context, output: Any) -> None:
        force = np.zeros(self._velocities)
        force[self._of] = self.GetInputPort("torque").Eval(context)
        for number, (joint, _) in enumerate(self._laws):  # what grows with the load comes last
            taken, _ = self._resisting(context, number, abs(force[self._of[joint]]))
            force[self._of[joint]] -= taken
        output.SetFromVector(force)

    def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:  # Drake's
        """Rates of the laws' memories."""
        rates = [self._resisting(context, number, 0.0)[1] for number in self._remembering]
        derivatives.get_mutable_vector().SetFromVector(np.array(rates))


def _numbers(effect: JointEffect) -> dict[str, float]:
    return {symbol: float(value) for symbol, value in effect.parameters.items()}
