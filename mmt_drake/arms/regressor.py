"""Inverse dynamics of an arm, linear in the inertial numbers of its links.

With w, alpha and a the angular velocity, angular acceleration and acceleration of a link's origin less gravity, all in
the frame of the link, force and moment at its origin are f = m a + alpha x mc + w x (w x mc) and
n = mc x a + I alpha + w x I w: linear in m, mc and I (Atkeson, An and Hollerbach 1986, Int. J. Robotics Research 5(3)).
The drives' torque is the sum over the links of J' (n, f). Poses, velocities, accelerations and Jacobians are Drake's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable
from scipy.spatial.transform import Rotation

from mmt_drake.arms.plant import ArmPlant
from mmt_drake.numeric.arrays import Array

_TEN = 10


@dataclass(frozen=True)
class Regressor:
    """What torque each inertial number asks for.

    Attributes:
        inertial: (n, joints, 10 links) [N m] for one unit of each number.
        tilted: (n, joints, 10 links, 3) the same when gravity is turned by 1 rad about the x and the y axis of the
            robot's foot, to first order, less what it was; and when it is twice what it was, less that.
    """

    inertial: Array
    tilted: Array

    def turned(self, numbers: Array, parts: Array) -> Array:
        """Torque that a change of gravity adds, (n, joints).

        Args:
            numbers: (links, 10) inertial numbers.
            parts: (3,) of each change that `tilted` has columns for.
        """
        if not parts.any():
            return np.zeros(self.inertial.shape[:2])
        added: Array = np.einsum("njpk,p,k->nj", self.tilted, numbers.ravel(), parts)
        return added


def regressor(arm: ArmPlant, q: Array, v: Array, a: Array, *, tilted: bool = True) -> Regressor:
    """The regressor of a motion.

    Args:
        arm: whose.
        q, v, a: (n, joints) of the recorded joints; others rest where the robot's file puts them.
        tilted: whether turns of gravity are wanted; without, they are 0.
    """
    plant, bodies = arm.plant, arm.bodies
    context = plant.CreateDefaultContext()
    positions, velocities = plant.GetPositions(context), np.zeros(plant.num_velocities())
    rates, at, of = velocities.copy(), arm.position_index, arm.velocity_index
    world, frames, indices = plant.world_frame(), [b.body_frame() for b in bodies], [b.index() for b in bodies]
    n, links = len(q), len(bodies)
    turned, moving = np.empty((n, links, 3, 3)), np.empty((n, links, 3, 3))
    jacobian = np.empty((n, links, 6, len(of)))
    origin = np.zeros(3)
    for i in range(n):
        positions[at], velocities[of], rates[of] = q[i], v[i], a[i]
        plant.SetPositions(context, positions)
        plant.SetVelocities(context, velocities)
        accelerations = plant.CalcSpatialAccelerationsFromVdot(context, rates)
        for k, body in enumerate(bodies):
            turned[i, k] = plant.EvalBodyPoseInWorld(context, body).rotation().matrix()
            moving[i, k, 0] = plant.EvalBodySpatialVelocityInWorld(context, body).rotational()
            moving[i, k, 1] = accelerations[indices[k]].rotational()
            moving[i, k, 2] = accelerations[indices[k]].translational()
            jacobian[i, k] = plant.CalcJacobianSpatialVelocity(
                context, JacobianWrtVariable.kV, frames[k], origin, world, world
            )[:, of]
    gravity = np.asarray(plant.gravity_field().gravity_vector())
    turns = _turns(gravity)
    inertial = np.empty((n, len(of), _TEN * links))
    turned_by = np.zeros((n, len(of), _TEN * links, len(turns)))
    for k in range(links):
        into = turned[:, k].transpose(0, 2, 1)
        w, alpha, linear = (np.einsum("nij,nj->ni", into, moving[:, k, j]) for j in range(3))
        own = slice(_TEN * k, _TEN * (k + 1))
        reach = np.concatenate([into @ jacobian[:, k, :3], into @ jacobian[:, k, 3:]], axis=1)
        inertial[:, :, own] = np.einsum("nwj,nwp->njp", reach, _wrench(w, alpha, linear - into @ gravity))
        still = np.zeros_like(w)
        for j, turn in enumerate(turns if tilted else ()):
            turned_by[:, :, own, j] = np.einsum("nwj,nwp->njp", reach, _wrench(still, still, -(into @ turn)))
    return Regressor(inertial, turned_by)


def _turns(gravity: Array) -> list[Array]:
    """Changes of gravity that `Regressor.tilted` has columns for: turned about x, about y, doubled."""
    return [*(np.cross(axis, gravity) for axis in np.eye(3)[:2]), gravity]


def tilt_parts(gravity: Array, rx: float, ry: float) -> Array:
    """What a turn of gravity has of each change that `Regressor.tilted` has columns for, (3,), to all orders.

    Args:
        gravity: before (3,) [m/s^2].
        rx, ry: rotation vector, without its third part [rad].
    """
    change = tilted_gravity(gravity, rx, ry) - gravity
    return np.asarray(np.linalg.lstsq(np.stack(_turns(gravity), 1), change, rcond=None)[0], dtype=np.float64)


def tilted_gravity(gravity: Array, rx: float, ry: float) -> Array:
    """Gravity (3,) turned by the rotation vector (rx, ry, 0) [rad], in the frame of the robot's foot."""
    turned: Array = Rotation.from_rotvec([rx, ry, 0.0]).apply(gravity)
    return turned


def _wrench(w: Array, alpha: Array, a: Array) -> Array:
    """Moment and force at a link's origin for one unit of each of its ten numbers, (n, 6, 10)."""
    n = len(w)
    wrench = np.zeros((n, 6, _TEN))
    wrench[:, 3:, 0] = a
    wrench[:, 3:, 1:4] = _cross(alpha) + _cross(w) @ _cross(w)
    wrench[:, :3, 1:4] = -_cross(a)
    wrench[:, :3, 4:] = _inertia(alpha) + _cross(w) @ _inertia(w)
    return wrench


def _cross(a: Array) -> Array:
    """a x, (n, 3, 3)."""
    zero = np.zeros(len(a))
    x, y, z = a.T
    return np.stack([np.stack([zero, -z, y], 1), np.stack([z, zero, -x], 1), np.stack([-y, x, zero], 1)], 1)


def _inertia(a: Array) -> Array:
    """The matrix that gives I a from Ixx, Iyy, Izz, Ixy, Ixz, Iyz, (n, 3, 6)."""
    zero = np.zeros(len(a))
    x, y, z = a.T
    rows = [[x, zero, zero, y, z, zero], [zero, y, zero, x, zero, z], [zero, zero, z, zero, x, y]]
    return np.stack([np.stack(row, 1) for row in rows], 1)
