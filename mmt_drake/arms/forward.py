"""Forward simulation of an arm over short windows: what one who simulates feels of a model's errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.believed import prepared
from mmt_drake.arms.deliver import arm_diagram, set_links
from mmt_drake.arms.joint_effects import IN_THE_LOG
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.numeric.arrays import Array

WINDOW_S = 0.2
"""Length of a window: an arm in open loop leaves its way soon, whatever the model."""
_MOST = 12
_ACCURACY = 1e-3
_MOST_STEPS = 3000
"""Integration steps of a window; a plant that asks for more is so stiff that nobody would simulate it so."""


@dataclass(frozen=True)
class ForwardErrors:
    """How far simulated joints are from recorded ones.

    Attributes:
        rms: (joints,) RMS of the position's error over all windows [rad] or [m]; infinite where one could not be
            simulated.
        way: (joints,) RMS of the way from where each window began.
        windows: how many.
    """

    rms: Array
    way: Array
    windows: int


def forward(model: ArmModel, log: JointLog, spans: Sequence[tuple[float, float]]) -> ForwardErrors:
    """Simulate an arm under its recorded torque over windows, each from the recorded state.

    Args:
        model: of the arm.
        log: what was recorded.
        spans: times within which windows may lie [s]; the first one of each, `_MOST` of them at most, evenly chosen.
    """
    arm = ArmPlant.of(model)
    motion, in_log = (
        ArmMotion.of(log, model.band_hz),
        [e for e in model.effects if e.name in IN_THE_LOG],
    )  # taken off its torque
    torque = motion.torque
    if in_log:
        one = prepared(arm, replace(model, effects=tuple(in_log)), log)
        torque = torque - motion.filtered(one.believed - one.rigid)
    usable = [start for start, end in spans if end - start >= WINDOW_S and end <= motion.time[-1]]
    chosen = usable[:: max(1, -(-len(usable) // _MOST))]
    diagram, plant = arm_diagram(model)
    squares, ways, count = np.zeros(len(arm.joints)), np.zeros(len(arm.joints)), 0
    for start in chosen:
        first = int(np.searchsorted(motion.time, start))
        own = slice(first, first + int(WINDOW_S / motion.step) + 1)
        time, q = motion.time[own] - motion.time[first], motion.q[own]
        simulated = _simulated(diagram, plant, model, arm, time, q[0], motion.v[first], torque[own])
        squares += ((simulated - q) ** 2).mean(axis=0)
        ways += ((q - q[0]) ** 2).mean(axis=0)
        count += 1
    n = max(count, 1)
    return ForwardErrors(np.sqrt(squares / n), np.sqrt(ways / n), count)


def _simulated(
    diagram: Any, plant: Any, model: ArmModel, arm: ArmPlant, time: Array, q: Array, v: Array, torque: Array
) -> Array:
    """Positions (n, joints) at the times (n,) of a window; infinite where the integration fails."""
    context = diagram.CreateDefaultContext()
    inside = diagram.GetMutableSubsystemContext(plant, context)
    set_links(model, plant, inside)
    positions, velocities = plant.GetPositions(inside).copy(), np.zeros(plant.num_velocities())
    positions[arm.position_index], velocities[arm.velocity_index] = q, v
    plant.SetPositions(inside, positions)
    plant.SetVelocities(inside, velocities)
    course = PiecewisePolynomial.FirstOrderHold(time, torque.T)
    simulator = Simulator(diagram, context)
    simulator.get_mutable_integrator().set_target_accuracy(_ACCURACY)
    found = np.full((len(time), len(q)), np.inf)
    port = diagram.GetInputPort("torque")
    try:
        for i, now in enumerate(time):
            port.FixValue(context, course.value(now).ravel())
            simulator.AdvanceTo(float(now))
            if simulator.get_integrator().get_num_steps_taken() > _MOST_STEPS:
                return np.full_like(found, np.inf)
            found[i] = plant.GetPositions(inside)[arm.position_index]
    except RuntimeError:  # an arm that no step is short enough for
        return found
    return found
