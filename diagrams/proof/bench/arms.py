"""The diagnosis of an arm: how long it takes on a minute of seven joints at 1 kHz."""

import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.proof.trial.arms.cases import ROBOTS
from mmt_drake.diagrams.proof.trial.arms.engine import ArmEngine, Concealment, bare_urdf
from mmt_drake.diagrams.stations.arm import robot_file

SECONDS, RATE_HZ = 60.0, 1000.0
_AT_MOST_S = 60.0
_WARM_UP_S = 8.0


def measurements() -> Iterator[Measurement]:
    """A Panda that rubs on every joint, simulated by MuJoCo, whose model does not know."""
    file, joints, _ = ROBOTS["panda"]
    with tempfile.TemporaryDirectory() as folder:
        urdf = bare_urdf(robot_file(file), Path(folder) / "robot.urdf")
        rubbing = [Concealment("coulomb_friction", joint, {"Fc": 1.0}) for joint in joints]
        none = dict.fromkeys(joints, (0.0, 0.0))
        engine = ArmEngine(urdf, joints, none, rubbing, np.zeros(len(joints)), np.random.default_rng(1))
        logged = engine.run(SECONDS, 1.0, RATE_HZ, 0.01)
        log = JointLog("log", logged.time, logged.q, logged.torque, "tau")
        model = ArmModel(urdf, joints=joints)
        first = slice(0, round(_WARM_UP_S * RATE_HZ))
        diagnose_arm([replace(log, time=log.time[first], q=log.q[first], torque=log.torque[first])], model)  # compiles
        begun = time.perf_counter()
        found = diagnose_arm([log], model)
        seconds = time.perf_counter() - begun
    name = f"diagnosis of {SECONDS:g} s of {len(joints)} joints at 1 kHz"
    yield Measurement(name, seconds, "s", _AT_MOST_S)
    dry = {effect.where for effect in found.effects if effect.family == "dry_friction" and effect.certain}
    name = "of these joints with dry friction named"
    yield Measurement(name, len(dry), "", len(joints), at_least=True)
