"""Forward simulation of an arm over short windows: what one who simulates feels of a model's errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.believed import of_the_plant, prepared
from mmt_drake.arms.deliver import arm_diagram, set_links
from mmt_drake.arms.joint_effects import IN_THE_LOG
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.model.controller import Controller
from mmt_drake.numeric.arrays import Array

WINDOW_S = 0.2
"""Length of a window: an arm in open loop leaves its way soon, whatever the model."""
_MOST = 12
_TICK_S = 1e-3
"""At which controllers of arms put out a torque."""
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
        closed: whether the arm's controller held it to what was recorded.
    """

    rms: Array
    way: Array
    windows: int
    closed: bool = False


def forward(model: ArmModel, log: JointLog, spans: Sequence[tuple[float, float]]) -> ForwardErrors:
    """Simulate an arm under its recorded torque over windows, each from the recorded state.

    Where the model has a controller, that adds what it puts out for the way that the joints are off: what of the
    recorded torque it did not make, such as the torque of gravity that is given beforehand, stays as it was.

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
        moved = [e for e in model.effects if of_the_plant(e.name)]
        one = prepared(arm, replace(model, effects=(*moved, *in_log)), log)
        torque = torque - motion.filtered(one.believed - one.rigid)
    usable = [
        start for start, end in spans if end - start >= WINDOW_S and end <= motion.time[-1] and _is_whole(motion, start)
    ]
    chosen = usable[:: max(1, -(-len(usable) // _MOST))]
    diagram, plant = arm_diagram(model)
    squares, ways, count = np.zeros(len(arm.joints)), np.zeros(len(arm.joints)), 0
    for start in chosen:
        first = int(np.searchsorted(motion.time, start))
        own = slice(first, first + int(WINDOW_S / motion.step) + 1)
        time, q = motion.time[own] - motion.time[first], motion.q[own]
        course = _Course(*(PiecewisePolynomial.FirstOrderHold(time, x[own].T) for x in (motion.q, motion.v, torque)))
        simulated = _simulated(diagram, plant, model, arm, time, course)
        squares += ((simulated - q) ** 2).mean(axis=0)
        ways += ((q - q[0]) ** 2).mean(axis=0)
        count += 1
    n = max(count, 1)
    return ForwardErrors(np.sqrt(squares / n), np.sqrt(ways / n), count, bool(model.controller))


def _is_whole(motion: ArmMotion, start: float) -> bool:
    """Whether a window has no gap."""
    first = int(np.searchsorted(motion.time, start))
    return bool(motion.recorded[first : first + int(WINDOW_S / motion.step) + 1].all())


@dataclass(frozen=True)
class _Course:
    """Position, velocity and torque as recorded, over the time of a window."""

    q: Any
    v: Any
    torque: Any


class _Loop:
    """The controllers of an arm, with what they have integrated.

    Args:
        controllers: one for each joint.
    """

    def __init__(self, controllers: Sequence[Controller]) -> None:
        gains = [(one.kp, one.ki, one.kd, one.low, one.high) for one in controllers]
        self._kp, self._ki, self._kd, self._low, self._high = np.array(gains).T
        self._sum = np.zeros(len(gains))

    def torque(self, recorded: Array, off: Array, rate: Array, seconds: float) -> Array:
        """What the drives give (joints,), within their limits.

        Args:
            recorded: what they gave (joints,).
            off: recorded less simulated position (joints,).
            rate: the same of the velocity.
            seconds: for how long it holds.
        """
        wanted = recorded + self._kp * off + self._ki * self._sum + self._kd * rate
        given: Array = np.clip(wanted, self._low, self._high)
        self._sum += np.where((wanted - given) * off > 0.0, 0.0, off * seconds)  # see `mmt_drake.model.controller`
        return given


def _simulated(diagram: Any, plant: Any, model: ArmModel, arm: ArmPlant, time: Array, course: _Course) -> Array:
    """Positions (n, joints) at the times (n,) of a window; infinite where the integration fails."""
    context = diagram.CreateDefaultContext()
    inside = diagram.GetMutableSubsystemContext(plant, context)
    set_links(model, plant, inside)
    positions, velocities = plant.GetPositions(inside).copy(), np.zeros(plant.num_velocities())
    at, of = arm.position_index, arm.velocity_index
    positions[at], velocities[of] = course.q.value(0.0).ravel(), course.v.value(0.0).ravel()
    plant.SetPositions(inside, positions)
    plant.SetVelocities(inside, velocities)
    loop = _Loop(model.controller * (len(at) if len(model.controller) == 1 else 1)) if model.controller else None
    simulator = Simulator(diagram, context)
    simulator.get_mutable_integrator().set_target_accuracy(_ACCURACY)
    found = np.full((len(time), len(at)), np.inf)
    port = diagram.GetInputPort("torque")
    try:
        for i, now in enumerate(time):
            begun = context.get_time()
            count = 1 if loop is None else max(1, round((now - begun) / _TICK_S))
            for tick in np.linspace(begun, now, count + 1)[1:]:
                given = course.torque.value(tick).ravel()
                if loop is not None:
                    instant = context.get_time()
                    apart = course.q.value(instant).ravel() - plant.GetPositions(inside)[at]
                    rate = course.v.value(instant).ravel() - plant.GetVelocities(inside)[of]
                    given = loop.torque(given, apart, rate, float(tick) - instant)
                port.FixValue(context, given)
                simulator.AdvanceTo(float(tick))
            if simulator.get_integrator().get_num_steps_taken() > _MOST_STEPS:
                return np.full_like(found, np.inf)
            found[i] = plant.GetPositions(inside)[at]
    except RuntimeError:  # an arm that no step is short enough for
        return found
    return found
