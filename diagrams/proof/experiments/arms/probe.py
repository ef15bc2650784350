"""What an arm's own diagnosis is worth in set-up 3: the probe's force, from the torques of the joints.

The whole Panda of set-up 3 is moved in free space, its probe off, and diagnosed. Then it slides its probe under forces
that are known, and tells them from its joints alone, with the model handed in and with what was found.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.analysis import Simulator

from mmt_drake.analysis.page import Section
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.arms.arm_file import ArmModel, JointEffect
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Reached, Report, Study, Target
from mmt_drake.diagrams.stations.arm import Arm, robot_file, simulated_arm, without_hand
from mmt_drake.numeric.arrays import Array

JOINTS: Final = tuple(f"panda_joint{n}" for n in range(1, 8))
STEP, EVERY = 1e-3, 4
"""Of the simulation [s]; the log has every so many of its samples."""
SECONDS: Final = {"free": 40.0, "contact": 20.0}
SEEDS: Final = 3
_START = np.array([0.0, 0.0, 0.1])
_NO_PROBE_KG, _PROBE_KG = 1e-4, 0.15
_PROBE_AT = (0.0, 0.0, 0.107 + 0.05)
"""Centre of the probe, and 0.05 m beyond it its tip, in the frame of the last link [m]."""
_NOISE_NM, _RESOLUTION = 0.03, 2.0 * np.pi / 2**20
_SLIDING = 0.05
"""Speed at which friction of the joints has set in [rad/s]."""
_LESS: Final = Target("error of the probe's force, over that with the model handed in", to_reach=0.5)


@dataclass(frozen=True)
class ProbeCase:
    """One arm.

    Attributes:
        seed: of its friction, of what is wrong with its links and of its motion.
        force: RMS of the force on the probe [N].
        handed_in, found, known: RMS of the error of that force, told from the joints with the model handed in, with
            what the diagnosis found, and with all that is true [N].
        verdict: of the diagnosis.
        named: effects that it is sure of.
    """

    seed: int
    force: float
    handed_in: float
    found: float
    known: float
    verdict: str
    named: int


@dataclass(frozen=True)
class JointFriction:
    """Of the joints, (7,): Fc tanh(v / v_s) + b v."""

    dry: Array
    viscous: Array

    def effects(self) -> tuple[JointEffect, ...]:
        """It as a model file has it."""
        dry = [
            JointEffect("smooth_coulomb_friction", joint, {"Fc": float(Fc), "v_s": _SLIDING})
            for joint, Fc in zip(JOINTS, self.dry, strict=True)
        ]
        viscous = [
            JointEffect("viscous_friction", joint, {"b": float(b)})
            for joint, b in zip(JOINTS, self.viscous, strict=True)
        ]
        return (*dry, *viscous)


def moved(friction: JointFriction, rng: np.random.Generator, seconds: float, touching: bool) -> tuple[JointLog, Array]:
    """The arm's log under its impedance controller, and the force on its probe (n, 3) [N].

    Args:
        friction: of its joints.
        rng: of the motion and of the noise.
        seconds: of the log.
        touching: whether the probe is on, and slides; else it is off and nothing is touched.
    """
    arm = simulated_arm(Arm(probe_mass=_PROBE_KG if touching else _NO_PROBE_KG), _START, STEP)
    simulator = Simulator(arm)
    context = simulator.get_mutable_context()
    plant, controller = (arm.GetSubsystemByName(name) for name in ("plant", "controller"))
    inside, beside = (arm.GetMutableSubsystemContext(part, context) for part in (plant, controller))
    rubbed = plant.get_applied_generalized_force_input_port()
    commanded, pushed, motion = arm.GetInputPort("commanded"), arm.GetInputPort("force"), arm.GetOutputPort("motion")
    reach = np.array([0.06, 0.06, 0.01]) if touching else np.array([0.12, 0.15, 0.08])
    w = 2.0 * np.pi * rng.uniform(0.15, 0.7, (3, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, (3, 3))
    rows = []
    for i in range(round(seconds / STEP)):
        now = i * STEP
        begun = min(1.0, now / 2.0)
        way = begun * reach * np.sin(w * now + phase).mean(axis=1)
        rate = begun * reach * (w * np.cos(w * now + phase)).mean(axis=1)
        commanded.FixValue(context, np.concatenate([_START + way, rate]))
        velocity = plant.GetVelocities(inside)
        rubbed.FixValue(inside, -friction.dry * np.tanh(velocity / _SLIDING) - friction.viscous * velocity)
        force = np.zeros(3)
        if touching:
            sliding = motion.Eval(context)[3:5]
            force[2] = begun * (4.0 + 2.0 * np.sin(2.0 * np.pi * 0.7 * now))
            force[:2] = -0.3 * force[2] * np.tanh(sliding / 0.02)
        pushed.FixValue(context, force)
        if i % EVERY == 0:
            rows.append([now, *plant.GetPositions(inside), *controller.GetOutputPort("torque").Eval(beside), *force])
        simulator.AdvanceTo(now + STEP)
    table = np.array(rows)
    q = np.round(table[:, 1:8] / _RESOLUTION) * _RESOLUTION
    torque = table[:, 8:15] + _NOISE_NM * rng.standard_normal((len(table), 7))
    return JointLog("log", table[:, 0], q, torque, "tau"), table[:, 15:]


def believed(folder: Path, factors: Array) -> ArmModel:
    """The arm's file, in which the inertial numbers of each link are wrong by a factor (7,)."""
    folder.mkdir(parents=True, exist_ok=True)
    robot = ET.fromstring(without_hand(robot_file("panda.urdf")))
    for number, factor in enumerate(factors, start=1):
        (link,) = [link for link in robot.iter("link") if link.get("name") == f"panda_link{number}"]
        for element, keys in (("mass", ("value",)), ("inertia", ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))):
            (one,) = link.iter(element)
            for key in keys:
                one.set(key, str(float(one.get(key, "0")) * factor))
    path = folder / "robot.urdf"
    ET.ElementTree(robot).write(path)
    return ArmModel(path, source="robot.urdf", joints=JOINTS)


def with_probe(model: ArmModel) -> ArmModel:
    """The same with the probe on, whose mass is known."""
    place = dict(zip(("cx", "cy", "cz"), _PROBE_AT, strict=True))
    return replace(model, effects=(*model.effects, JointEffect("payload", "panda_link7", {"m": _PROBE_KG, **place})))


def told_force(model: ArmModel, log: JointLog) -> Array:
    """The force on the tip (n, 3) [N] in the band, from the torques that the model does not explain."""
    arm = ArmPlant.of(model)
    one = predicted(arm, model, log)
    motion = ArmMotion.of(log, model.band_hz)
    q = motion.q[motion.thinning]
    plant, context = arm.plant, arm.plant.CreateDefaultContext()
    tip, world = np.array([*_PROBE_AT[:2], _PROBE_AT[2] + 0.05]), plant.world_frame()
    frame = plant.GetFrameByName("panda_link7")
    found = []
    for pose, left in zip(q, one.predicted - one.measured, strict=True):
        positions = plant.GetPositions(context)
        positions[arm.position_index] = pose
        plant.SetPositions(context, positions)
        jacobian = plant.CalcJacobianTranslationalVelocity(context, JacobianWrtVariable.kV, frame, tip, world, world)[
            :, arm.velocity_index
        ]
        found.append(np.linalg.lstsq(jacobian.T, left, rcond=None)[0])
    return np.array(found)


def run_case(folder: Path, seed: int, seconds: dict[str, float] | None = None) -> ProbeCase:
    """Diagnose an arm in free space, and tell the force on its probe.

    Args:
        folder: for its file.
        seed: of all that is drawn.
        seconds: of both logs, `SECONDS` unless given.
    """
    rng, lasting = np.random.default_rng((seed, 3)), seconds or SECONDS
    strong = np.array([1.0, 1.0, 0.8, 0.8, 0.25, 0.2, 0.15])
    friction = JointFriction(strong * rng.uniform(0.4, 1.0, 7), strong * rng.uniform(0.3, 1.0, 7))
    factors = rng.uniform(0.9, 1.1, 7)
    model = believed(folder / f"arm-{seed}", factors)
    free, _ = moved(friction, rng, lasting["free"], touching=False)
    diagnosis = diagnose_arm([free], model)
    log, force = moved(friction, rng, lasting["contact"], touching=True)
    motion = ArmMotion.of(log, model.band_hz)
    even = np.stack([np.interp(motion.time, log.time, column) for column in force.T], 1)
    true = motion.filtered(even)[motion.thinning]
    right = believed(folder / f"true-{seed}", np.ones(7)).with_found(friction.effects(), {})
    models = (model, diagnosis.model, right)
    errors = [_rms(told_force(with_probe(m), log) - true) for m in models]
    sure = sum(1 for effect in diagnosis.effects if effect.certain)
    return ProbeCase(seed, _rms(true), errors[0], errors[1], errors[2], diagnosis.verdict, sure)


def _rms(vectors: Array) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))


def report_of(cases: Sequence[ProbeCase]) -> Report:
    """What it comes to."""
    rows: list[list[Cell]] = [
        [f"arm {c.seed}", c.force, c.handed_in, c.found, c.known, c.verdict.replace("_", " "), c.named] for c in cases
    ]
    headers = ["arm", "force [N]", "off, as handed in [N]", "off, with what was found [N]", "off, all known [N]"]
    table = Table((*headers, "verdict", "names"), rows, "RMS of the force on the probe and of its errors.", digits=3)
    before, after = (float(np.median([getattr(c, name) for c in cases])) for name in ("handed_in", "found"))
    return Report(
        {"experiment": "arm-force", "cases": [asdict(case) for case in cases]},
        "The probe's force, from the torques of the arm",
        (
            "The whole Panda of set-up 3 moves its flange in free space for 40 s, its probe off, under its impedance "
            "controller, and is diagnosed: its joints rub, and the file handed in has links wrong by up to 10 %. Then "
            "it slides its probe for 20 s under forces that are known, and tells them from the torques of its joints."
        ),
        "Force on the probe",
        [table],
        [f"RMS error of the probe's force, median: {before:.3g} N as handed in, {after:.3g} N with what was found."],
        [Section("By arm", table=table)],
        [Reached(f"arm {case.seed}", _LESS, case.found / case.handed_in) for case in cases],
    )


def _run(asked: Asked, progress: Progress) -> Report:
    count = asked.objects("arm-force", SEEDS)
    tasks = [partial(run_case, asked.out, asked.seed + number) for number in range(count)]
    return report_of(results_of(tasks, asked.jobs, progress, compile_first=True))


STUDIES: Final = {"arm-force": Study("arms", ("seed", "count"), lambda asked: float(asked.count or SEEDS), _run)}
