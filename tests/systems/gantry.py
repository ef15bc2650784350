"""The simplest arm: a mass on three crossed rails."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, PrismaticJoint, SpatialInertia

MASS = 2.0
"""Of the tip; each rail before it weighs a tenth of that [kg]."""


def gantry(rails: str = "xyz", step: float = 1e-3) -> tuple[MultibodyPlant, Frame]:
    """The plant, finalized, and its tip's frame; a joint and an actuator per rail."""
    plant = MultibodyPlant(step)
    frame = plant.world_frame()
    for number, rail in enumerate(rails):
        mass = MASS if number == len(rails) - 1 else 0.1 * MASS
        body = plant.AddRigidBody(f"body{number}", SpatialInertia.SolidSphereWithMass(mass, 0.05))
        axis = np.eye(3)["xyz".index(rail)]
        joint = plant.AddJoint(PrismaticJoint(f"joint{number}", frame, body.body_frame(), axis))
        plant.AddJointActuator(f"actuator{number}", joint)
        frame = body.body_frame()
    plant.Finalize()
    return plant, frame
