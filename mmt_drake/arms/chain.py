"""A plant from a table of joints, for an arm that has no file: lengths are known, masses are guessed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, SpatialInertia, UnitInertia


@dataclass(frozen=True)
class ChainJoint:
    """One joint of a chain, and the link that it moves.

    Attributes:
        xyz: where its frame stands on the link before it [m].
        rpy: how it is turned there: roll, pitch, yaw [rad].
        axis: of the motion, in its own frame.
        slides: whether it slides along that axis; else it turns about it.
        mass: a guess of what it moves [kg]; a fit says how far it may be off.
        size: a guess of that link's length [m].
    """

    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    slides: bool = False
    mass: float = 1.0
    size: float = 0.1


def chain(
    joints: Sequence[ChainJoint], gravity: tuple[float, float, float] = (0.0, 0.0, -9.81), time_step: float = 0.0
) -> Any:
    """A `MultibodyPlant` of a chain, not yet finalized; joints are called joint_1, joint_2 ..., links link_1 ...

    Args:
        joints: from the foot to the hand.
        gravity: in the frame of the foot [m/s^2].
        time_step: of the plant [s]; 0: continuous.
    """
    plant = MultibodyPlant(time_step)
    parent = plant.world_body()
    for number, one in enumerate(joints, start=1):
        inertia = SpatialInertia(one.mass, np.zeros(3), UnitInertia.SolidSphere(0.5 * one.size))
        link = plant.AddRigidBody(f"link_{number}", inertia)
        placed = RigidTransform(RollPitchYaw(*one.rpy), np.array(one.xyz))
        frame = plant.AddFrame(FixedOffsetFrame(f"before_joint_{number}", parent.body_frame(), placed))
        kind = PrismaticJoint if one.slides else RevoluteJoint
        plant.AddJoint(kind(f"joint_{number}", frame, link.body_frame(), np.array(one.axis)))
        parent = link
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    return plant
