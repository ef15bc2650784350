"""An arm of three joints, its motion in closed form, and its torques by Drake's inverse dynamics alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces, SpatialInertia, UnitInertia

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.joint_log import JointLog

JOINTS = ("turn", "lift", "bend")
LINKS = ("post", "upper", "fore")
RATE_HZ, SECONDS = 100.0, 30.0


def link(name: str, m: float, c: tuple[float, float, float], about: tuple[float, ...]) -> str:
    """A link; its moments about its centre are xx, yy, zz and, where given, xy, xz, yz."""
    named = dict(zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), (*about, 0.0, 0.0, 0.0), strict=False))
    moments = " ".join(f'{key}="{value}"' for key, value in named.items())
    centre = " ".join(map(str, c))
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}" rpy="0 0 0"/><mass value="{m}"/>'
        f"<inertia {moments}/></inertial></link>"
    )


def joint(name: str, parent: str, child: str, at: str, axis: str = "0 0 1", kind: str = "revolute") -> str:
    """A joint between two links, or what welds one to the other."""
    limit = "" if kind == "fixed" else f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="200" velocity="9"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}" rpy="0 0 0"/>{limit}</joint>'
    )


def robot(*parts: str) -> str:
    """A URDF."""
    return '<?xml version="1.0"?>\n<robot name="small">' + "\n".join(parts) + "</robot>\n"


URDF = robot(
    '<link name="foot"/>',
    link("post", 4.0, (0.02, -0.01, 0.12), (0.03, 0.03, 0.02)),
    link("upper", 3.0, (0.18, 0.01, 0.02), (0.006, 0.05, 0.05, 0.001)),
    link("fore", 1.6, (0.14, -0.02, 0.01), (0.003, 0.02, 0.02)),
    joint("turn", "foot", "post", "0 0 0.1"),
    joint("lift", "post", "upper", "0 0.05 0.25", "0 1 0"),
    joint("bend", "upper", "fore", "0.4 0 0", "0 1 0"),
)


@dataclass(frozen=True)
class Moves:
    """Position, velocity and acceleration in closed form, each (n, joints)."""

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


def sines(joints: int, seed: int, seconds: float = SECONDS, size: float = 1.0) -> Moves:
    """A sum of five sines a joint between 0.1 and 1 Hz, each of another phase."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1.0 / RATE_HZ)
    w = 2.0 * np.pi * rng.uniform(0.1, 1.0, (joints, 5))
    amplitude, phase = size * rng.uniform(0.3, 0.7, (joints, 5)) / w, rng.uniform(0.0, 2.0 * np.pi, (joints, 5))
    angle = w[None] * time[:, None, None] + phase[None]
    q, v, a = (
        (amplitude * w**k * part).sum(axis=2) for k, part in enumerate((np.sin(angle), np.cos(angle), -np.sin(angle)))
    )
    return Moves(time, q, v, a)


def plant_of(path: Path, gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)) -> Any:
    """Drake's plant of a URDF, its foot welded to the world, not yet finalized."""
    plant = MultibodyPlant(0.0)
    (instance,) = Parser(plant).AddModels(str(path))
    plant.WeldFrames(plant.world_frame(), plant.get_body(plant.GetBodyIndices(instance)[0]).body_frame())
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    return plant


def with_point(plant: Any, link_name: str, m: float, c: tuple[float, float, float]) -> Any:
    """The plant with a point mass welded to a link."""
    body = plant.GetBodyByName(link_name)
    point = plant.AddRigidBody(
        "point", body.model_instance(), SpatialInertia(m, np.zeros(3), UnitInertia.SolidSphere(1e-4))
    )
    plant.WeldFrames(plant.GetFrameByName(link_name), point.body_frame(), RigidTransform(np.array(c)))
    return plant


def inverse_dynamics(plant: Any, moves: Moves) -> np.ndarray:
    """Torques that a finalized plant asks for (n, velocities); its velocities are those of `moves` in their order."""
    context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
    found = []
    for q, v, a in zip(moves.q, moves.v, moves.a, strict=True):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        forces.SetZero()
        plant.CalcForceElementsContribution(context, forces)
        found.append(plant.CalcInverseDynamics(context, a, forces))
    return np.array(found)


@cache
def rigid(seed: int, folder: Path) -> tuple[Moves, np.ndarray]:
    """A motion of the small arm, and its torques without any effect."""
    moves = sines(3, seed)
    plant = plant_of(written(folder))
    plant.Finalize()
    return moves, inverse_dynamics(plant, moves)


def written(folder: Path) -> Path:
    """The small arm's URDF in a folder."""
    path = folder / "small.urdf"
    path.write_text(URDF)
    return path


def model(folder: Path, **keys: Any) -> ArmModel:
    """What is believed of the small arm."""
    return ArmModel(robot=written(folder), source="arm.yaml", **keys)


def noisy(moves: Moves, torque: np.ndarray, seed: int, part: float = 0.01) -> JointLog:
    """A log with white noise on each torque, a part of its spread."""
    rng = np.random.default_rng(1000 + seed)
    noise = part * torque.std(axis=0) * rng.standard_normal(torque.shape)
    return JointLog("log", moves.time, moves.q, torque + noise, "tau")


def named(diagnosis: Any) -> set[tuple[str, str]]:
    """Effects that are sure, and where."""
    return {(e.name, e.where) for e in diagnosis.effects if e.certain}


def values(diagnosis: Any, name: str, where: str) -> Mapping[str, Any]:
    """Numbers of an effect that was found."""
    (one,) = [e for e in diagnosis.effects if (e.name, e.where) == (name, where)]
    return {symbol: getattr(n, "value", n) for symbol, n in one.numbers.items()}
