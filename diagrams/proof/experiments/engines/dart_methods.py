"""DART: a prismatic joint whose own spring and damper DART takes implicitly, driven one step at a time from Python.

The contact spring and damper can be the joint's too, with the probe as their moving end (all implicit), or a force that
Python computes.
"""

from typing import Any

from mmt_drake.diagrams.proof.experiments.engines.method import STEP, Method, Setting, Trace, engine_package, stepped

_PACKAGE = "dartpy"


def _world(setting: Setting, stiffness: float, damping: float) -> tuple[Any, Any]:
    """A world with the body on its joint, the spring and the damper in the joint."""
    dart = engine_package(_PACKAGE)
    world, skeleton = dart.simulation.World(), dart.dynamics.Skeleton("object")
    world.setGravity([0.0, 0.0, 0.0])
    world.setTimeStep(STEP)
    joint, body = skeleton.createPrismaticJointAndBodyNodePair()
    joint.setAxis([0.0, 1.0, 0.0])
    joint.setSpringStiffness(0, stiffness)
    joint.setDampingCoefficient(0, damping)
    body.setMass(setting.parameters.m)
    world.addSkeleton(skeleton)
    position, velocity = setting.body_at_start()
    joint.setPosition(0, position)
    joint.setVelocity(0, velocity)
    return world, joint


def _forced(setting: Setting) -> Trace:
    p = setting.parameters
    world, joint = _world(setting, p.k1, p.b1)
    x, v = (signal.tolist() for signal in setting.probe.at_samples())

    def advance(k: int, q: float, u: float) -> tuple[float, float]:
        joint.setForce(0, p.k2 * (x[k] - q) + p.b2 * (v[k] - u))
        world.step()
        return joint.getPosition(0), joint.getVelocity(0)

    return stepped(setting, advance)


def _jointed(setting: Setting) -> Trace:
    p = setting.parameters
    world, joint = _world(setting, p.k1 + p.k2, p.b1 + p.b2)
    x, v = setting.probe.at_samples()
    rest, push = (p.k2 / (p.k1 + p.k2) * x).tolist(), (p.b2 * v).tolist()

    def advance(k: int, *_: float) -> tuple[float, float]:
        joint.setRestPosition(0, rest[k])
        joint.setForce(0, push[k])
        world.step()
        return joint.getPosition(0), joint.getVelocity(0)

    return stepped(setting, advance)


METHODS = (
    Method("dart", "contact as a force from Python", _forced, _PACKAGE, from_python=True),
    Method("dart", "contact as the joint's spring", _jointed, _PACKAGE, from_python=True),
)
