"""The torque that a model believes in, for a motion that was recorded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from mmt_drake.arms.arm_effect import Shape
from mmt_drake.arms.arm_file import ArmModel, JointEffect
from mmt_drake.arms.elasticity import softened
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.joint_motion import JointMotion
from mmt_drake.arms.laws import ARM_EFFECTS, VISCOUS
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.regressor import Regressor, regressor, tilt_parts
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags


@dataclass(frozen=True)
class PreparedLog:
    """A log, ready to be held against models.

    Attributes:
        log: what was recorded.
        motion: smooth.
        asked: torque for one unit of each inertial number.
        carried: (links, 10) inertial numbers of the links with what they carry.
        rigid: (n, joints) torque that moves the links with these, under gravity as believed [N m].
        believed: (n, joints) the same with the model's effects.
        softened: (n, joints, joints) what one unit of compliance of each joint, the last index, adds to the torque.
    """

    log: JointLog
    motion: ArmMotion
    asked: Regressor
    carried: Array
    rigid: Array
    believed: Array
    softened: Array

    def joint(self, j: int) -> JointMotion:
        """The motion of joint j."""
        motion, jerk = self.motion, self.motion.jerk[:, j]
        q, v, a = motion.q[:, j], motion.v[:, j], motion.a[:, j]
        return JointMotion(j, motion.step, q, v, a, self.rigid[:, j], motion.torque, jerk)

    def counted(self, j: int) -> Flags:
        """Samples that were recorded and at which joint j moves, (n,)."""
        moves: Flags = np.abs(self.motion.v[:, j]) >= self.joint(j).rest
        return moves & self.motion.recorded

    def turns(self, j: int) -> Flags:
        """Samples at which joint j turns over or rests, or that the filter brings into touch with that, (n,)."""
        v = self.motion.v[:, j]
        turned = np.abs(v) < self.joint(j).rest
        turned[1:] |= np.sign(v[1:]) != np.sign(v[:-1])
        near: Flags = ndimage.maximum_filter1d(turned, 2 * int(1.0 / (self.motion.band_hz * self.motion.step)) + 1)
        return near

    def columns(self, arm: ArmPlant, effect: str, where: str, shape: Shape, j: int) -> Array | None:
        """Torque of joint j for one unit of each number of an effect (n, k); None where it has no part there."""
        law = ARM_EFFECTS[effect]
        if law.place == "joint" and law.reaches_all:
            return self.softened[:, j, arm.joints.index(where)][:, None]
        if law.place == "joint" and arm.joints[j] != where:
            return None
        if not law.of_plant:
            return law.columns(self.joint(j), shape)
        if law.place == "link":
            k = arm.links.index(where)
            return self.asked.inertial[:, j, 10 * k : 10 * k + 10]
        return np.einsum("npk,p->nk", self.asked.tilted[:, j, :, :2], self.carried.ravel())

    def moving(self, arm: ArmPlant, model: ArmModel, believed: ArmModel) -> PreparedLog:
        """The same log, with the links, what they carry and the gravity of another model under its other effects.

        Gains, friction that grows with the load, and springs act on the torque that moves those. A tilt that is sought
        is one to first order about that of the other model.

        Args:
            arm: of the model.
            model: whose links move.
            believed: that which the log was held against.
        """
        carried, rigid = _moved(arm, model, self.asked)
        (exact, straight), (exact_before, straight_before) = _tilt(arm, model), _tilt(arm, believed)
        curved = self.asked.turned(carried, exact - straight - exact_before + straight_before)
        springs = softened(arm, carried, self.motion, rigid)
        return replace(self, carried=carried, rigid=rigid, believed=self.believed + curved, softened=springs)


def inertias(arm: ArmPlant, model: ArmModel) -> Array:
    """Inertial numbers of the links that a model believes in, (links, 10).

    Raises:
        BadInput: it has numbers of a link that no recorded joint moves.
    """
    numbers = arm.inertias()
    for name, values in model.links.items():
        if name not in arm.links:
            raise BadInput(model.source, at=f"links.{name}", found=name, expected=f"one of {', '.join(arm.links)}")
        numbers[arm.links.index(name)] = values
    return numbers


def check_places(arm: ArmPlant, model: ArmModel) -> None:
    """Refuse effects at joints or links that are not there, and another number of controllers.

    Raises:
        BadInput: so they are.
    """
    if len(model.controller) not in (0, 1, len(arm.joints)):
        expected = f"1, or {len(arm.joints)}: one for each joint"
        raise BadInput(model.source, at="controller", found=f"{len(model.controller)} controllers", expected=expected)
    known: Mapping[str, Sequence[str]] = {"joint": arm.joints, "link": arm.links, "arm": ("",)}
    for number, effect in enumerate(model.effects):
        place = ARM_EFFECTS[effect.name].place
        if effect.where not in known[place]:
            expected = f"one of {', '.join(known[place])}"
            raise BadInput(model.source, at=f"effects[{number}].{place}", found=effect.where, expected=expected)
        other = effect.parameters.get("joint")
        if other is not None and other not in arm.joints:
            at = f"effects[{number}].parameters.joint"
            raise BadInput(model.source, at=at, found=other, expected=f"one of {', '.join(arm.joints)}")


def coefficients(arm: ArmPlant, effect: JointEffect) -> tuple[Array, Shape]:
    """The linear numbers of an effect, and its shape; another joint stands by its number there."""
    numbers = {
        symbol: float(arm.joints.index(str(value))) if symbol == "joint" else value
        for symbol, value in effect.parameters.items()
    }
    return ARM_EFFECTS[effect.name].coefficients(numbers)


def with_damping(arm: ArmPlant, model: ArmModel) -> ArmModel:
    """The model with the damping of the robot's file as viscous friction, where it says nothing of that itself.

    Args:
        arm: of the model.
        model: of an arm.
    """
    told = {effect.where for effect in model.effects if effect.name in VISCOUS}
    damped = [(joint, b) for joint, b in zip(arm.joints, arm.damping, strict=True) if b and joint not in told]
    added = [JointEffect("viscous_friction", joint, {"b": float(b)}) for joint, b in damped]
    return replace(model, effects=(*model.effects, *added)) if added else model


def of_the_plant(effect: str) -> bool:
    """Whether an effect belongs to what moves: a payload, the direction of gravity."""
    law = ARM_EFFECTS[effect]
    return law.of_plant and law.place != "joint"


def with_payloads(arm: ArmPlant, model: ArmModel) -> Array:
    """Inertial numbers of the links with the payloads that a model has, (links, 10).

    Raises:
        BadInput: it has numbers of a link that no recorded joint moves.
    """
    carried = inertias(arm, model)
    for effect in model.effects:
        if ARM_EFFECTS[effect.name].place == "link":
            carried[arm.links.index(effect.where)] += coefficients(arm, effect)[0]
    return carried


def _moved(arm: ArmPlant, model: ArmModel, asked: Regressor) -> tuple[Array, Array]:
    """Inertial numbers of the links with what they carry (links, 10), and the torque that moves them (n, joints)."""
    carried = with_payloads(arm, model)
    return carried, asked.inertial @ carried.ravel() + asked.turned(carried, _tilt(arm, model)[0])


def _tilt(arm: ArmPlant, model: ArmModel) -> tuple[Array, Array]:
    """What a model's turns of gravity have of each column of `Regressor.tilted`, (3,): to all orders, and to first."""
    gravity = np.asarray(arm.plant.gravity_field().gravity_vector())
    angles = [coefficients(arm, effect)[0] for effect in model.effects if effect.name == "gravity_offset"]
    exact = sum((tilt_parts(gravity, rx, ry) for rx, ry in angles), np.zeros(3))
    return exact, sum((np.array([rx, ry, 0.0]) for rx, ry in angles), np.zeros(3))


def prepared(arm: ArmPlant, model: ArmModel, log: JointLog) -> PreparedLog:
    """A log, held against a model.

    Args:
        arm: of the model.
        model: what is believed.
        log: of that arm.
    """
    motion = ArmMotion.of(log, model.band_hz)
    asked = regressor(arm, motion.q, motion.v, motion.a)
    carried, rigid = _moved(arm, model, asked)
    bare = PreparedLog(log, motion, asked, carried, rigid, rigid, softened(arm, carried, motion, rigid))
    believed = rigid.copy()
    for effect in model.effects:
        if of_the_plant(effect.name):
            continue
        x, shape = coefficients(arm, effect)
        for j in range(len(arm.joints)):
            columns = bare.columns(arm, effect.name, effect.where, shape, j)
            if columns is not None:
                believed[:, j] += columns @ x
    return replace(bare, believed=believed)


@dataclass(frozen=True)
class Predicted:
    """Torque as measured and as a model predicts it, in the band.

    Attributes:
        time: (n,) [s].
        measured, predicted: (n, joints) [N m].
        velocity: (n, joints) [rad/s].
        counted: (n, joints) samples that were recorded and at which a joint moves; where it rests dry friction holds
            whatever it has to.
    """

    time: Array
    measured: Array
    predicted: Array
    velocity: Array
    counted: Flags

    @property
    def nrmse(self) -> Array:
        """RMS of the error over the standard deviation of what was measured, each joint over its counted samples."""
        found = []
        for j in range(self.measured.shape[1]):
            own = self.counted[:, j]
            spread = float(self.measured[own, j].std()) if own.any() else 0.0
            error = self.measured[own, j] - self.predicted[own, j]
            found.append(float(np.sqrt(np.mean(error**2))) / spread if spread > 0.0 else float("nan"))
        return np.array(found)


def predicted(arm: ArmPlant, model: ArmModel, log: JointLog) -> Predicted:
    """The torque of a log as a model predicts it from the motion alone (inverse dynamics)."""
    one = prepared(arm, with_damping(arm, model), log)
    kept = one.motion.thinning
    counted = np.stack([one.counted(j) for j in range(len(arm.joints))], 1)
    motion = one.motion
    smooth = motion.filtered(one.believed)
    return Predicted(motion.time[kept], motion.torque[kept], smooth[kept], motion.v[kept], counted[kept])
