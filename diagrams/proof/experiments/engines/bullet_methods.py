"""Bullet: a prismatic joint of a multibody, its own damping switched off, under a torque that Python computes.

Its Python package steps one by one, and has neither springs nor a choice of integrator.
"""

from typing import Any

from mmt_drake.diagrams.proof.experiments.engines.method import STEP, Method, Setting, Trace, engine_package, stepped

_PACKAGE = "pybullet"


def _run(setting: Setting) -> Trace:
    bullet = engine_package(_PACKAGE)
    client = bullet.connect(bullet.DIRECT)
    try:
        return _stepped(bullet, {"physicsClientId": client}, setting)
    finally:
        bullet.disconnect(client)


def _stepped(bullet: Any, there: dict[str, int], setting: Setting) -> Trace:
    p = setting.parameters
    bullet.setTimeStep(STEP, **there)
    body = bullet.createMultiBody(
        baseMass=0.0,
        linkMasses=[p.m],
        linkCollisionShapeIndices=[-1],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]],
        linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0],
        linkJointTypes=[bullet.JOINT_PRISMATIC],
        linkJointAxis=[[0, 1, 0]],
        **there,
    )
    for link in (-1, 0):
        bullet.changeDynamics(body, link, linearDamping=0.0, angularDamping=0.0, jointDamping=p.b1, **there)
    bullet.setJointMotorControl2(body, 0, bullet.VELOCITY_CONTROL, force=0.0, **there)  # the motor that each joint has
    bullet.resetJointState(body, 0, *setting.body_at_start(), **there)
    x, v = (signal.tolist() for signal in setting.probe.at_samples())

    def advance(k: int, q: float, u: float) -> tuple[float, float]:
        push = p.k2 * (x[k] - q) + p.b2 * (v[k] - u) - p.k1 * q
        bullet.setJointMotorControl2(body, 0, bullet.TORQUE_CONTROL, force=push, **there)
        bullet.stepSimulation(**there)
        position, velocity, _, _ = bullet.getJointState(body, 0, **there)
        return position, velocity

    return stepped(setting, advance)


METHODS = (Method("bullet", "multibody, force from Python", _run, _PACKAGE, from_python=True),)
