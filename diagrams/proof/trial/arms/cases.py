"""Cases of arms: which effects are concealed, how large, and what is handed to the diagnosis."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml

from mmt_drake.diagrams.proof.trial.arms.engine import ArmEngine, Concealment, Logged, bare_urdf
from mmt_drake.diagrams.stations.arm import robot_file
from mmt_drake.numeric.arrays import Array

SECONDS: Final = 30.0
_SMALLEST, _LARGEST = 0.15, 0.6
"""RMS of a concealed torque over the spread of its joint's."""
_UR5: Final = tuple(f"{n}_joint" for n in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"))
_PANDA: Final = tuple(f"panda_joint{n}" for n in range(1, 8))
ROBOTS: Final = {"panda": ("panda.urdf", _PANDA, "panda_link7"), "ur5": ("ur5_robot.urdf", _UR5, "wrist_3_link")}
"""Name -> file of the package example-robot-data, recorded joints, the link that carries a payload."""

Stats = tuple[float, float, float, float]
"""Of a joint: spread of its torque [N m], RMS speed [rad/s], its way [rad], RMS of the torque of its links [N m]."""

_SIZED: Final[dict[str, Callable[[float, Stats, np.random.Generator], dict[str, float]]]] = {
    "coulomb_friction": lambda rms, s, rng: {"Fc": rms},
    "viscous_friction": lambda rms, s, rng: {"b": rms / s[1]},
    "stribeck_friction": lambda rms, s, rng: {
        "Fc": 0.7 * rms,
        "Fs": 0.7 * rms * rng.uniform(1.8, 3.0),
        "v_s": s[1] * rng.uniform(0.2, 0.5),
    },
    "load_dependent_friction": lambda rms, s, rng: {"mu": rms / max(s[3], 1e-6)},
    "asymmetric_viscous_friction": lambda rms, s, rng: {
        "b_plus": 1.3 * rms / s[1],
        "b_minus": 1.3 * rms / s[1] * rng.uniform(0.1, 0.4),
    },
    "constant_force": lambda rms, s, rng: {"F": rms * rng.choice((-1.0, 1.0))},
    "torque_ripple": lambda rms, s, rng: {
        "amplitude": math.sqrt(2.0) * rms,
        "period": s[2] / rng.uniform(4.0, 12.0),
        "phase": rng.uniform(0.0, 2.0 * math.pi),
    },
    "torque_gain": lambda rms, s, rng: {"gain": rms / max(s[3], 1e-6) * rng.choice((-1.0, 1.0))},
}
"""Effects of one joint: (RMS of its torque, statistics of the joint) -> numbers."""
_FREE: Final = ("coulomb_friction", "viscous_friction", "stribeck_friction", "asymmetric_viscous_friction")
_LOADED: Final = ("load_dependent_friction", "torque_gain")
_WHOLE: Final = ("payload", "gravity_offset", "time_delay")
EFFECTS: Final = (*_SIZED, "rotor_inertia", "joint_coupling", *_WHOLE)


@dataclass(frozen=True)
class ArmTrialCase:
    """One case.

    Attributes:
        name: says nothing.
        robot: of `ROBOTS`.
        concealed: effects.
        folder: with the robot's file, `model.yaml` and `log.npz`.
    """

    name: str
    robot: str
    concealed: tuple[Concealment, ...]
    folder: Path

    def truth(self) -> dict[str, Any]:
        """What is sealed."""
        return {
            "case": self.name,
            "robot": self.robot,
            "effects": [{"name": c.name, "where": c.where, "numbers": c.numbers} for c in self.concealed],
        }


def draw_case(folder: Path, name: str, seed: int, number: int, first: str | None, remainder: float) -> ArmTrialCase:
    """Draw, simulate and write a case.

    Args:
        folder: in which the case gets a folder of its own.
        name: of the case.
        seed, number: of the trial and of the case.
        first: effect that is concealed; one or two more follow. None: nothing is.
        remainder: RMS of what is nameless, over that of the concealed torque.
    """
    rng = np.random.default_rng((seed, number, 22))
    robot = str(rng.choice(list(ROBOTS)))
    source, joints, hand = ROBOTS[robot]
    own = folder / name
    own.mkdir(parents=True, exist_ok=True)
    urdf = bare_urdf(robot_file(source), own / "robot.urdf")
    amplitude, noise = float(rng.uniform(0.7, 1.2)), float(math.exp(rng.uniform(math.log(0.005), math.log(0.02))))
    rate = float(rng.choice((125.0, 250.0, 500.0)))
    motion = int(rng.integers(2**31))

    def logged(believed: dict[str, tuple[float, float]], some: list[Concealment], nameless: Array) -> Logged:
        engine = ArmEngine(urdf, joints, believed, some, nameless, np.random.default_rng(motion))
        return engine.run(SECONDS, amplitude, rate, noise)

    none = np.zeros(len(joints))
    bare = logged(dict.fromkeys(joints, (0.0, 0.0)), [], none)
    rigid = np.maximum(bare.links.std(axis=0), 0.05 * bare.links.std(axis=0).max())
    stats = {
        joint: (
            1.3 * float(rigid[j]),
            float(np.sqrt((bare.velocity[:, j] ** 2).mean())),
            float(np.ptp(bare.q[:, j])),
            float(np.sqrt((bare.links[:, j] ** 2).mean())),
        )
        for j, joint in enumerate(joints)
    }
    names = [] if first is None else [first, *_further(rng, first)]
    concealed: list[Concealment] = []
    for effect in names:
        concealed.append(_concealment(rng, effect, joints, hand, stats, rigid, concealed))
    believed = {}
    for joint in joints:
        spread, speed, _, _ = stats[joint]
        here = {c.name for c in concealed if c.where == joint}
        viscous = 0.0 if here & {"viscous_friction", "asymmetric_viscous_friction"} else 0.15 * spread / speed
        dry = 0.0 if here & {"coulomb_friction", "stribeck_friction"} else 0.2 * spread
        believed[joint] = (viscous, dry)
    nameless = none.copy()
    if remainder and concealed:
        for j, joint in enumerate(joints):
            size = next((float(c.numbers["rms"]) for c in concealed if c.where == joint), 0.0)
            size = size or (0.2 * stats[joint][0] if rng.random() < 0.5 else 0.0)
            nameless[j] = remainder * size
    log = logged(believed, concealed, nameless)
    np.savez_compressed(own / "log.npz", t_s=log.time, q_rad=log.q, tau_Nm=log.torque)
    effects = []
    for joint, (viscous, dry) in believed.items():
        effects += [{"name": "viscous_friction", "joint": joint, "parameters": {"b": viscous}}] if viscous else []
        effects += [{"name": "coulomb_friction", "joint": joint, "parameters": {"Fc": dry}}] if dry else []
    data = {"structure": "multibody", "robot": "robot.urdf", "joints": list(joints), "effects": effects}
    (own / "model.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    return ArmTrialCase(name, robot, tuple(concealed), own)


def _further(rng: np.random.Generator, first: str) -> list[str]:
    count = int(rng.choice((0, 1, 2), p=(0.5, 0.3, 0.2)))
    others = [name for name in EFFECTS if name != first and not (name in _WHOLE and first in _WHOLE)]
    return [str(name) for name in rng.choice(others, count, replace=False)]


def _concealment(
    rng: np.random.Generator,
    effect: str,
    joints: tuple[str, ...],
    hand: str,
    stats: dict[str, Stats],
    rigid: Array,
    taken: list[Concealment],
) -> Concealment:
    size = math.exp(rng.uniform(math.log(_SMALLEST), math.log(_LARGEST)))
    free = [j for j, joint in enumerate(joints) if joint not in {c.where for c in taken}]
    if effect in (*_LOADED, "joint_coupling"):  # where links weigh something
        free = [j for j in free if stats[joints[j]][3] > 0.3 * float(rigid.max())] or free
    j = int(rng.choice(free))
    joint = joints[j]
    spread, speed, way, _ = stats[joint]
    if effect == "payload":
        centre = rng.uniform(-0.05, 0.1, 3)
        c = {f"c{axis}": float(v) for axis, v in zip("xyz", centre, strict=True)}
        return Concealment(effect, hand, {"m": float(rng.uniform(0.5, 3.0)), **c, "rms": 0.0})
    if effect == "gravity_offset":
        angles = np.radians(rng.uniform(1.0, 5.0, 2)) * rng.choice((-1.0, 1.0), 2)
        return Concealment(effect, "", {"rx": float(angles[0]), "ry": float(angles[1]), "rms": 0.0})
    if effect == "time_delay":
        return Concealment(effect, "", {"delay": float(rng.uniform(0.01, 0.03)), "rms": 0.0})
    rms = size * spread
    if effect == "rotor_inertia":
        numbers = {"I": rms / (speed * 2.0 * math.pi * 0.25)}
    elif effect == "joint_coupling":
        near = [k for k in (j - 1, j + 1) if 0 <= k < len(joints)]
        other = int(max(near, key=lambda k: rigid[k]))
        numbers = {"gain": rms / (1.3 * float(rigid[other])), "other": float(other)}
    else:
        numbers = _SIZED[effect](rms, (spread, speed, way, stats[joint][3]), rng)
    return Concealment(effect, joint, {**{k: float(v) for k, v in numbers.items()}, "rms": rms})
