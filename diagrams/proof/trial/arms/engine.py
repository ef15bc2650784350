"""An arm in MuJoCo with effects of its own formulas, moved by a controller and logged as robots log.

Nothing here is shared with the diagnosis: neither laws nor dynamics nor filters.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mmt_drake.errors import MissingDependency
from mmt_drake.numeric.arrays import Array

STEP = 1e-3
_HARD = 0.9999  # of 1: how much of what friction has to hold it holds at once
_GAINS = (400.0, 40.0)  # [1/s^2], [1/s] of the tracking error, times the inertia
_HARMONICS = 5


@dataclass(frozen=True)
class Concealment:
    """One effect that the engine has and the model has not.

    Attributes:
        name: as the diagnosis calls it.
        where: joint or link; empty: the whole arm.
        numbers: of its formula.
    """

    name: str
    where: str
    numbers: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Logged:
    """What the robot's own log has, and what really happened.

    Attributes:
        time: (n,) [s], uneven.
        q, torque: (n, joints) as logged.
        clean: (n, joints) torque without noise, gain and delay [N m].
        links: (n, joints) torque that moved the links [N m].
        velocity: (n, joints) [rad/s].
    """

    time: Array
    q: Array
    torque: Array
    clean: Array
    links: Array
    velocity: Array


def bare_urdf(source: Path, target: Path) -> Path:
    """A robot's file without anything to look at or to touch, which needs no meshes, and without friction of joints.

    That is what the model handed in says, in the place of the file.
    """
    tree = ET.parse(source)
    root = tree.getroot()
    for link in root.iter("link"):
        for kind in ("visual", "collision"):
            for element in link.findall(kind):
                link.remove(element)
    for joint in root.iter("joint"):
        for element in joint.findall("dynamics"):
            joint.remove(element)
    for kind in ("transmission", "gazebo"):
        for element in root.findall(kind):
            root.remove(element)
    ET.SubElement(
        ET.SubElement(root, "mujoco"), "compiler", fusestatic="false", balanceinertia="true", strippath="true"
    )
    tree.write(target)
    return target


class ArmEngine:
    """One arm, its concealed effects and what nobody has a name for.

    Args:
        urdf: of `bare_urdf`.
        joints: that move, in order; others are locked where they are.
        believed: joint -> viscous and Coulomb friction that the model knows.
        concealed: effects.
        nameless: (joints,) RMS of the torque of each joint that has no name [N m].
        rng: of everything random.

    Raises:
        MissingDependency: MuJoCo is not installed.
    """

    def __init__(
        self,
        urdf: Path,
        joints: Sequence[str],
        believed: dict[str, tuple[float, float]],
        concealed: Sequence[Concealment],
        nameless: Array,
        rng: np.random.Generator,
    ) -> None:
        try:
            import mujoco
        except ImportError as error:
            raise MissingDependency(
                "mujoco not found; install the project with its extra: pip install -e '.[engines]'"
            ) from error
        self._mujoco, self._rng, self._joints = mujoco, rng, list(joints)
        self._model = mujoco.MjModel.from_xml_path(str(urdf))
        self._data = mujoco.MjData(self._model)
        self._model.opt.timestep = STEP
        self._model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self._at = [self._model.joint(name).dofadr[0] for name in joints]
        # MuJoCo's dry friction gives way softly, over 20 ms if not told: torques would come some ms before the motion.
        self._model.dof_solref[:] = 2.0 * STEP, 1.0
        self._model.dof_solimp[:, :2] = _HARD
        others = [i for i in range(self._model.nv) if i not in self._at]
        self._model.dof_armature[others] = 1e6  # locked
        self._believed, self._concealed, self._nameless_rms = believed, list(concealed), nameless
        self._texture = [
            (rng.uniform(3.0, 25.0, 12), rng.uniform(0.0, 2.0 * np.pi, 12), rng.normal(size=12)) for _ in joints
        ]
        self._wander = rng.normal(size=len(joints))
        self._noise = np.zeros(len(joints))
        for effect in concealed:
            self._apply(effect)

    def _apply(self, effect: Concealment) -> None:
        """What MuJoCo has itself."""
        model = self._model
        if effect.name == "rotor_inertia":
            model.dof_armature[self._dof(effect.where)] += effect.numbers["I"]
        if effect.name == "payload":
            body = model.body(effect.where)
            m, c = effect.numbers["m"], np.array([effect.numbers[f"c{axis}"] for axis in "xyz"])
            before, own = float(body.mass[0]), np.array(body.ipos)
            flat = np.zeros(9)
            self._mujoco.mju_quat2Mat(flat, np.array(body.iquat))
            turned = flat.reshape(3, 3)
            centre = (before * own + m * c) / (before + m)
            inertia = turned @ np.diag(body.inertia) @ turned.T
            for mass, at in ((before, own), (m, c)):
                off = at - centre
                inertia = inertia + mass * (off @ off * np.eye(3) - np.outer(off, off))
            values, axes = np.linalg.eigh(inertia)
            axes = axes * np.sign(np.linalg.det(axes))
            quaternion = np.zeros(4)
            self._mujoco.mju_mat2Quat(quaternion, axes.ravel())
            body.mass[0], body.ipos[:], body.inertia[:], body.iquat[:] = before + m, centre, values, quaternion
            self._mujoco.mj_setConst(model, self._data)
        if effect.name == "gravity_offset":
            rx, ry = effect.numbers["rx"], effect.numbers["ry"]
            cx, sx, cy, sy = math.cos(rx), math.sin(rx), math.cos(ry), math.sin(ry)
            about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
            about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
            model.opt.gravity[:] = about_x @ about_y @ np.array([0.0, 0.0, -9.81])

    def _dof(self, joint: str) -> int:
        return int(self._at[self._joints.index(joint)])

    def _resistances(self, rigid: Array) -> tuple[Array, Array, Array]:
        """Level of dry friction, damping and further torque of each joint now; and which of it is concealed."""
        q, v = self._data.qpos[self._at], self._data.qvel[self._at]
        damping = np.array([self._believed[name][0] for name in self._joints])
        level = np.array([self._believed[name][1] for name in self._joints])
        further = np.zeros(len(self._joints))
        for effect in self._concealed:
            if effect.where not in self._joints:
                continue
            j, n = self._joints.index(effect.where), effect.numbers
            match effect.name:
                case "coulomb_friction":
                    level[j] += n["Fc"]
                case "viscous_friction":
                    damping[j] += n["b"]
                case "stribeck_friction":
                    level[j] += n["Fc"] + (n["Fs"] - n["Fc"]) * math.exp(-((v[j] / n["v_s"]) ** 2))
                case "load_dependent_friction":
                    level[j] += n["mu"] * abs(rigid[j])
                case "asymmetric_viscous_friction":
                    damping[j] += n["b_plus"] if v[j] > 0.0 else n["b_minus"]
                case "constant_force":
                    further[j] += n["F"]
                case "torque_ripple":
                    further[j] += n["amplitude"] * math.sin(2.0 * math.pi * q[j] / n["period"] + n["phase"])
        return level, damping, further

    def run(self, seconds: float, amplitude: float, rate: float, noise: float) -> Logged:
        """Move the arm and log it.

        Args:
            seconds: of the log.
            amplitude: of each joint's motion about the middle of its way [rad].
            rate: of the log [Hz].
            noise: of the torque, over its spread.
        """
        model, data, mujoco = self._model, self._data, self._mujoco
        count = round(seconds / STEP)
        way = self._reference(count, amplitude)
        data.qpos[self._at], data.qvel[self._at] = way[0][0], way[1][0]
        inertia = np.zeros((model.nv, model.nv))
        q, torque = np.empty((count, len(self._at))), np.empty((count, len(self._at)))
        resisted = np.empty_like(q)
        rigid = np.zeros(len(self._at))
        own = np.ix_(self._at, self._at)
        for i in range(count):
            mujoco.mj_forward(model, data)
            mujoco.mj_fullM(model, data, inertia)
            drive = inertia[own] @ (
                way[2][i]
                + _GAINS[0] * (way[0][i] - data.qpos[self._at])
                + _GAINS[1] * (way[1][i] - data.qvel[self._at])
            )
            drive = drive + data.qfrc_bias[self._at]
            level, damping, further = self._resistances(rigid)
            drive = drive + damping * way[1][i] + level * np.tanh(way[1][i] / 0.02) - further
            nameless = self._nameless(i) if self._nameless_rms.any() else np.zeros(len(drive))
            model.dof_frictionloss[self._at], model.dof_damping[self._at] = level, damping
            data.qfrc_applied[self._at] = drive + further + nameless
            before = data.qvel[self._at].copy()
            q[i], torque[i] = data.qpos[self._at], drive
            mujoco.mj_step(model, data)
            gained = (data.qvel[self._at] - before) / STEP
            rigid = inertia[own] @ gained + data.qfrc_bias[self._at]
            resisted[i] = rigid - drive
        return self._logged(q, torque, resisted, seconds, rate, noise)

    def _reference(self, count: int, amplitude: float) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration (count, joints) of a Fourier series that begins at rest in its middle."""
        time = np.arange(count) * STEP
        model, rng = self._model, self._rng
        q, v, a = (np.zeros((count, len(self._at))) for _ in range(3))
        for j, name in enumerate(self._joints):
            low, high = model.joint(name).range
            reach = min(amplitude, 0.35 * (high - low)) if high > low else amplitude
            middle = 0.5 * (low + high) if high > low else 0.0
            parts = rng.normal(size=(_HARMONICS, 2))
            base = rng.uniform(0.06, 0.12)
            wave = np.zeros((3, count))
            for k, (sine, cosine) in enumerate(parts, start=1):
                w = 2.0 * np.pi * base * k
                weight = 1.0 / k
                wave[0] += weight * (sine * np.sin(w * time) + cosine * np.cos(w * time))
                wave[1] += weight * w * (sine * np.cos(w * time) - cosine * np.sin(w * time))
                wave[2] -= weight * w**2 * (sine * np.sin(w * time) + cosine * np.cos(w * time))
            scale = reach / np.abs(wave[0]).max()
            q[:, j], v[:, j], a[:, j] = middle + scale * wave[0], scale * wave[1], scale * wave[2]
        return q, v, a

    def _nameless(self, i: int) -> Array:
        """Texture that never comes back over the way, a friction level that wanders, and 1/f noise [N m]."""
        q, v = self._data.qpos[self._at], self._data.qvel[self._at]
        self._wander += -self._wander * STEP / 5.0 + self._rng.normal(size=len(q)) * math.sqrt(2.0 * STEP / 5.0)
        self._noise += -self._noise * STEP / 0.5 + self._rng.normal(size=len(q)) * math.sqrt(2.0 * STEP / 0.5)
        texture = np.array(
            [np.sum(a * np.sin(w * q[j] + p)) / math.sqrt(6.0) for j, (w, p, a) in enumerate(self._texture)]
        )
        mixed: Array = self._nameless_rms * (texture + self._wander * np.sign(v) + self._noise) / math.sqrt(3.0)
        return mixed

    def _logged(self, q: Array, torque: Array, resisted: Array, seconds: float, rate: float, noise: float) -> Logged:
        rng, true = self._rng, np.arange(len(q)) * STEP
        delay = 0.0
        reading = torque.copy()
        for effect in self._concealed:
            if effect.name == "torque_gain":
                j = self._joints.index(effect.where)
                links = resisted[:, j] + torque[:, j]
                reading[:, j] += effect.numbers["gain"] * links
            if effect.name == "joint_coupling":
                j, k = (self._joints.index(n) for n in (effect.where, self._joints[int(effect.numbers["other"])]))
                reading[:, j] += effect.numbers["gain"] * torque[:, k]
            if effect.name == "time_delay":
                delay = effect.numbers["delay"]
        time = np.arange(0.5, seconds - 0.1, 1.0 / rate)
        time = np.sort(time + rng.uniform(-0.2, 0.2, len(time)) / rate)
        position = np.stack([np.interp(time, true, column) for column in q.T], 1)
        read = np.stack([np.interp(time - delay, true, column) for column in reading.T], 1)
        clean = np.stack([np.interp(time, true, column) for column in torque.T], 1)
        spread = clean.std(axis=0)
        read = read + noise * spread * rng.normal(size=read.shape)
        step = 0.002 * spread
        resolution = 2.0 * np.pi / 2**18
        return Logged(
            time,
            np.round(position / resolution) * resolution,
            np.round(read / step) * step,
            clean,
            np.stack([np.interp(time, true, column) for column in (torque + resisted).T], 1),
            np.gradient(position, time, axis=0),
        )
