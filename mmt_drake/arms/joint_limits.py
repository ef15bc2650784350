"""Limits of an arm's joints: those of its file as Drake reads them, or stricter ones that are handed in."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array


@dataclass(frozen=True)
class JointLimits:
    """What each recorded joint may do, each (joints,).

    Attributes:
        low, high: of its position [rad] or [m].
        speed: [rad/s] or [m/s].
        acceleration: [rad/s^2] or [m/s^2].
        effort: torque of its drive [N m] or [N]; infinite where the file has none.
    """

    low: Array
    high: Array
    speed: Array
    acceleration: Array
    effort: Array

    @classmethod
    def of(
        cls,
        arm: ArmPlant,
        model: ArmModel,
        position: Sequence[float] = (),
        velocity: Sequence[float] = (),
        acceleration: Sequence[float] = (),
    ) -> JointLimits:
        """Those of an arm; of the file's and those handed in the stricter holds.

        Args:
            arm: of the model.
            model: whose robot's file has limits.
            position, velocity, acceleration: a number for each joint, or one for all; a position to either side of 0.

        Raises:
            BadInput: neither the file nor an option has a limit, an option has not a positive number for each joint,
                or a joint has no way.
        """
        joints = [arm.plant.GetJointByName(name) for name in arm.joints]
        reach = _given("--position", position, arm)
        low, high = arm.position_limits
        low, high = np.maximum(low, -reach), np.minimum(high, reach)
        kinds = {"velocity": velocity, "acceleration": acceleration}
        of_file = [
            [min(-getattr(j, f"{kind}_lower_limits")()[0], getattr(j, f"{kind}_upper_limits")()[0]) for j in joints]
            for kind in kinds
        ]
        speed, rate = (
            np.minimum(own, _given(f"--{kind}", given, arm))
            for own, (kind, given) in zip(of_file, kinds.items(), strict=True)
        )
        for kind, limits in (("position", np.minimum(-low, high)), ("velocity", speed), ("acceleration", rate)):
            for name, limit in zip(arm.joints, limits, strict=True):
                if not np.isfinite(limit):
                    found = f"no {kind} limit of {name}"
                    raise BadInput(model.robot, found=found, expected=f"one, or the option --{kind}")
        for name, way, fastest, hardest in zip(arm.joints, high - low, speed, rate, strict=True):
            if not min(way, fastest, hardest) > 0.0:
                found = f"{way:g} of way, {fastest:g} of speed, {hardest:g} of acceleration"
                raise BadInput(model.robot, at=f"limits of {name}", found=found, expected="more than 0 of each")
        return cls(low, high, speed, rate, _efforts(arm, model))


def _given(option: str, values: Sequence[float], arm: ArmPlant) -> Array:
    """A limit for each joint, infinite where none was handed in."""
    if not all(np.isfinite(value) and value > 0.0 for value in values):
        raise BadInput(option, found=", ".join(f"{v:g}" for v in values), expected="finite numbers above 0")
    if len(values) not in (0, 1, len(arm.joints)):
        expected = f"1, or {len(arm.joints)}: one for each of {', '.join(arm.joints)}"
        raise BadInput(option, found=f"{len(values)} numbers", expected=expected)
    return np.broadcast_to(np.array(values or [np.inf]), (len(arm.joints),))


def _efforts(arm: ArmPlant, model: ArmModel) -> Array:
    """Efforts of actuators; of a URDF's joints, too, to which Drake gives no actuator unless it has a transmission."""
    found = dict.fromkeys(arm.joints, np.inf)
    for index in arm.plant.GetJointActuatorIndices():
        actuator = arm.plant.get_joint_actuator(index)
        if actuator.joint().name() in found:
            found[actuator.joint().name()] = float(actuator.effort_limit())
    for joint in ET.parse(model.robot).iter("joint") if model.robot.suffix == ".urdf" else ():
        limit, name = joint.find("limit"), joint.get("name", "")
        effort = float(limit.get("effort", 0.0)) if limit is not None else 0.0
        if name in found and effort > 0.0:
            found[name] = min(found[name], effort)
    return np.array([found[name] for name in arm.joints])
