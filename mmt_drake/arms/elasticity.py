"""Elasticity of joints: what it does to the torque, and what a second encoder behind the gear tells of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy import stats

from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant, give_links
from mmt_drake.numeric.arrays import Array

_PER_S: Final = 40.0
"""Inertias and gravity change as slowly as the arm's pose: they are computed so often."""
_STEP: Final = 1e-4
"""Of position, for the rate of gravity [rad] or [m]."""

_BLOCKS: Final = 12
"""Parts of a log, each held out in turn."""
_STANDS: Final = 0.5
"""A second encoder whose position moves by less than this part of the drive's way is none."""


@dataclass(frozen=True)
class Deflection:
    """What a second encoder tells of a joint.

    Attributes:
        joint: its number.
        stiffness: torque over deflection [N m/rad].
        interval: of 95 %, over blocks.
        late: by how much the second encoder is read later than the drive's [s].
        left: RMS of the deflection that is not explained, over its spread, of blocks held out; without a spring and
            with it.
    """

    joint: int
    stiffness: float
    interval: tuple[float, float]
    late: float
    left: tuple[float, float]


def deflections(logs: Sequence[JointLog], band_hz: float, link_torque: Sequence[Array]) -> list[Deflection]:
    """The spring between the two encoders of each joint that has them, from how far they are apart.

    Beside the spring they may be read at other times, turn by other amounts, and have play: v, q and the direction of
    motion stand beside the torque. A joint without a spring, or one that the log does not tell, is left out.

    Args:
        logs: of one arm.
        band_hz: below which all is compared [Hz].
        link_torque: of each log (n, joints), on the clock of its motion: what moves the links [N m].
    """
    found = []
    motions = [ArmMotion.of(log, band_hz) for log in logs if log.link is not None]
    links = [ArmMotion.of(replace(log, q=log.link), band_hz) for log in logs if log.link is not None]
    torques = [torque for log, torque in zip(logs, link_torque, strict=True) if log.link is not None]
    for j in range(logs[0].q.shape[1] if motions else 0):
        way, own = (sum(float(np.ptp(one.q[:, j])) for one in some) for some in (motions, links))
        if own < _STANDS * way or way == 0.0:
            continue
        columns, apart = [], []
        for drive, link, torque in zip(motions, links, torques, strict=True):
            kept = drive.thinning
            direction = np.clip(drive.v[:, j] / (0.01 * np.abs(drive.v[:, j]).max()), -1.0, 1.0)
            beside = [drive.v[:, j], drive.q[:, j], drive.filtered(direction), np.ones(len(drive.q))]
            columns.append(np.stack([torque[:, j], *beside], 1)[kept])
            apart.append((drive.q[:, j] - link.q[:, j])[kept])
        told = _spring(j, np.concatenate(columns), np.concatenate(apart))
        if told is not None:
            found.append(told)
    return found


def _spring(joint: int, columns: Array, apart: Array) -> Deflection | None:
    blocks = np.array_split(np.arange(len(apart)), _BLOCKS)
    left = np.zeros(2)
    compliances = []
    for block in blocks:
        others = np.setdiff1d(np.arange(len(apart)), block)
        for i, used in enumerate((columns[:, 1:], columns)):
            x = np.linalg.lstsq(used[others], apart[others], rcond=None)[0]
            left[i] += ((apart[block] - used[block] @ x) ** 2).sum()
        compliances.append(x[0])
    x = np.linalg.lstsq(columns, apart, rcond=None)[0]
    # Jackknife over blocks (Efron 1982).
    spread = np.sqrt((_BLOCKS - 1) / _BLOCKS * ((compliances - np.mean(compliances)) ** 2).sum())
    half = stats.t.ppf(0.975, _BLOCKS - 1) * spread
    if x[0] <= half or not apart.std() > 0.0:
        return None
    over = np.sqrt(left / len(apart)) / apart.std()
    interval = float(1.0 / (x[0] + half)), float(1.0 / (x[0] - half))
    return Deflection(joint, float(1.0 / x[0]), interval, float(x[1]), (float(over[0]), float(over[1])))


def softened(arm: ArmPlant, numbers: Array, motion: ArmMotion, rigid: Array) -> Array:
    """What one unit of compliance of each joint adds to the torque of all, to first order (n, joints, joints).

    The link is behind its drive by c tau, tau the torque of a stiff joint, so M c tau'' + dg/dq c tau is missing of all
    torques; M is the column of the mass matrix, g the torque of gravity. The last index is the joint that gives way.

    Args:
        arm: whose.
        numbers: (links, 10) inertial numbers believed.
        motion: of the drives.
        rigid: (n, joints) torque that moves the links, were they stiff.
    """
    rate = np.gradient(np.gradient(motion.filtered(rigid), motion.step, axis=0), motion.step, axis=0)
    inertia, gravity = _at_poses(arm, numbers, motion)
    return -(inertia * rate[:, None, :] + gravity * rigid[:, None, :])


def _at_poses(arm: ArmPlant, numbers: Array, motion: ArmMotion) -> tuple[Array, Array]:
    """The mass matrix, and the rate of the torques against gravity over each position, (n, joints, joints) each."""
    plant = arm.plant
    context = plant.CreateDefaultContext()
    give_links(arm, plant, context, dict(zip(arm.links, numbers, strict=True)))
    at, of = arm.position_index, arm.velocity_index
    positions = plant.GetPositions(context)
    chosen = np.arange(0, len(motion.time), max(1, int(1.0 / (_PER_S * motion.step))))
    inertia, gravity = (np.empty((len(chosen), len(at), len(at))) for _ in range(2))
    for row, i in enumerate(chosen):
        positions[at] = motion.q[i]
        plant.SetPositions(context, positions)
        inertia[row] = plant.CalcMassMatrix(context)[np.ix_(of, of)]
        for j, place in enumerate(at):
            sides = []
            for side in (_STEP, -_STEP):
                positions[place] = motion.q[i, j] + side
                plant.SetPositions(context, positions)
                sides.append(-plant.CalcGravityGeneralizedForces(context)[of])
            positions[place] = motion.q[i, j]
            gravity[row, :, j] = (sides[0] - sides[1]) / (2.0 * _STEP)
    now = motion.time[chosen]
    return _between(now, inertia, motion.time), _between(now, gravity, motion.time)


def _between(now: Array, values: Array, time: Array) -> Array:
    """Values (m, ...) at some times, at others (n, ...)."""
    flat = values.reshape(len(now), -1)
    return np.stack([np.interp(time, now, column) for column in flat.T], 1).reshape(len(time), *values.shape[1:])
