"""Effects of arms: what each adds to the torque of a joint that moves as recorded.

Laws of friction, drag and bodies are those of the library (`mmt_drake.effects`), called through their addresses: N is
N m and m is rad where a joint turns. Others only an arm has. All are linear in numbers that say how strongly they act;
numbers that say how (`shapes`) are sought on a grid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from mmt_drake.arms.arm_effect import ANY, ArmEffect, Numbers, Shape
from mmt_drake.arms.joint_motion import JointMotion
from mmt_drake.arms.law_torque import along
from mmt_drake.numeric.arrays import Array

_BRIEF_S: Final = 1e-3
"""Of a delay that is shorter the first order is all that shows."""
_FARTHEST: Final = 1.0
"""A payload is no farther from the frame of its link than this [m]."""


def _speeds(*parts: float) -> Callable[[JointMotion], list[Shape]]:
    return lambda motion: [(part * motion.fastest,) for part in parts]


def _ripple_values(x: Array, form: Shape) -> Numbers:
    return {"amplitude": math.hypot(x[0], x[1]), "period": form[0], "phase": math.atan2(x[1], x[0])}


def _ripple_coefficients(values: Numbers) -> tuple[Array, Shape]:
    amplitude, phase = float(values["amplitude"]), float(values["phase"])
    return np.array([amplitude * math.cos(phase), amplitude * math.sin(phase)]), (float(values["period"]),)


def _ripple_columns(motion: JointMotion, form: Shape) -> Array:
    numbers = [{"amplitude": 1.0, "period": form[0], "phase": phase} for phase in (0.0, 0.5 * math.pi)]
    return np.stack([along("torque_ripple", motion, values) for values in numbers], 1)


def _dahl_columns(motion: JointMotion, form: Shape) -> Array:
    return along("dahl_friction", motion, {"Fc": 1.0, "sigma": 1.0 / form[0]})[:, None]


def _two_levels(motion: JointMotion, form: Shape) -> Array:
    slow = np.abs(motion.v) < form[0]
    return np.stack([motion.direction * slow, motion.direction * ~slow], 1)


def _later(motion: JointMotion, form: Shape) -> Array:
    """What is later in a torque that is read so late (s), in parts of that; of a short time its rate."""
    if abs(form[0]) < _BRIEF_S:
        return -motion.jerk[:, None]
    time = np.arange(len(motion.q)) * motion.step
    own = motion.others[:, motion.joint]
    return ((own - CubicSpline(time, own)(time + form[0])) / form[0])[:, None]


def _point(m: float, c: Sequence[float]) -> Array:
    """The ten inertial numbers of a point mass."""
    x, y, z = c
    return m * np.array([1.0, x, y, z, y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z])


_MOMENTS: Final = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")


def _payload_values(x: Array, form: Shape) -> Numbers:
    c = [float(x[1 + i] / x[0]) if x[0] else 0.0 for i in range(3)]
    own = x[4:] - _point(float(x[0]), c)[4:]
    return {"m": float(x[0]), **dict(zip(("cx", "cy", "cz"), c, strict=True)), **dict(zip(_MOMENTS, own, strict=True))}


def _payload_coefficients(values: Numbers) -> tuple[Array, Shape]:
    numbers = _point(float(values["m"]), [float(values[f"c{axis}"]) for axis in "xyz"])
    return numbers + np.array([0.0] * 4 + [float(values.get(symbol, 0.0)) for symbol in _MOMENTS]), ()


_DRY, _VISCOUS = "dry friction", "viscous friction"
_STIFF_START = (0.015, 0.03, 0.06, 0.12, 0.2, 0.35)
_GAUTIER: Final = "Gautier and Khalil 1990, IEEE Trans. Robotics and Automation 6(3)"
_SICILIANO: Final = "Siciliano, Sciavicco, Villani and Oriolo 2009, Robotics, chapter 7"

ARM_EFFECTS: Final[dict[str, ArmEffect]] = {
    effect.name: effect
    for effect in (
        ArmEffect("viscous_friction", ("b",), ("N m s/rad",), replaces=_VISCOUS),
        ArmEffect(
            "asymmetric_viscous_friction",
            ("b_plus", "b_minus"),
            ("N m s/rad", "N m s/rad"),
            holds=("viscous_friction",),
            replaces=_VISCOUS,
        ),
        ArmEffect("quadratic_drag", ("c",), ("N m s^2/rad^2",)),
        ArmEffect("coulomb_friction", ("Fc",), ("N m",), replaces=_DRY),
        ArmEffect(
            "smooth_coulomb_friction",
            ("Fc", "v_s"),
            ("N m", "rad/s"),
            shape=("v_s",),
            shapes=_speeds(*_STIFF_START),
            holds=("coulomb_friction",),
            replaces=_DRY,
        ),
        ArmEffect(
            "stribeck_friction",
            ("Fc", "Fs", "v_s"),
            ("N m", "N m", "rad/s"),
            shape=("v_s",),
            shapes=_speeds(*_STIFF_START),
            check=lambda x: bool(x[1] >= x[0]),  # it falls with speed
            holds=("coulomb_friction",),
            replaces=_DRY,
        ),
        ArmEffect(
            "dahl_friction",
            ("Fc", "sigma"),
            ("N m", "N m/rad"),
            torque=_dahl_columns,
            shape=("sigma",),
            shapes=lambda motion: [(part * motion.reach,) for part in (0.003, 0.006, 0.012, 0.025, 0.05, 0.1)],
            to_file=lambda x, form: {"Fc": float(x[0]), "sigma": float(x[0]) / form[0]},
            from_file=lambda v: (np.array([float(v["Fc"])]), (float(v["Fc"]) / (float(v["sigma"]) or 1.0),)),
            holds=("coulomb_friction",),
            replaces=_DRY,
        ),
        ArmEffect(
            "static_friction",
            ("Fs", "Fd", "v_d"),
            ("N m", "N m", "rad/s"),
            equation="Fs sgn v while |v| < v_d, else Fd sgn v; what it holds at rest is not looked at",
            torque=_two_levels,
            shape=("v_d",),
            shapes=_speeds(*_STIFF_START),
            check=lambda x: bool(x[0] >= x[1]),
            holds=("coulomb_friction",),
            replaces=_DRY,
            near_equal={"stribeck_friction": "where few strokes are as slow as v_d"},
        ),
        ArmEffect("load_dependent_friction", ("mu",), ("1",)),
        ArmEffect("constant_force", ("F",), ("N m",), least=(ANY,)),
        ArmEffect("ground_spring", ("k",), ("N m/rad",)),
        ArmEffect(
            "torque_ripple",
            ("amplitude", "period", "phase"),
            ("N m", "rad", "rad"),
            torque=_ripple_columns,
            shape=("period",),
            shapes=lambda motion: [(period,) for period in motion.ripples],
            to_file=_ripple_values,
            from_file=_ripple_coefficients,
            least=(ANY, ANY),
        ),
        ArmEffect(
            "rotor_inertia",
            ("I",),
            ("kg m^2",),
            family="inertia",
            block="body",
            equation="I q'', I as seen from the joint",
            source=_SICILIANO,
            torque=lambda motion, form: motion.a[:, None],
            near_equal={"link_inertia": "on the first joint of a chain, about its axis"},
        ),
        ArmEffect(
            "torque_gain",
            ("gain",),
            ("1",),
            family="sensor",
            block="force_sensor",
            equation="the log tells gain times the torque that moves the links; the numbers tell gain - 1",
            source=_SICILIANO,
            torque=lambda motion, form: motion.rigid[:, None],
            least=(ANY,),
            near_equal={"scaled_inertias": "where it is the same on every joint"},
        ),
        ArmEffect(
            "joint_elasticity",
            ("k",),
            ("N m/rad",),
            family="drive_train",
            block="drive",
            equation="the link is behind the drive by the torque that moves the links over k; to first order",
            source="Spong 1987, J. Dynamic Systems, Measurement and Control 109(4)",
            of_plant=True,
            to_file=lambda x, form: {"k": 1.0 / float(x[0]) if x[0] > 0.0 else math.inf},
            from_file=lambda v: (np.array([1.0 / float(v["k"])]), ()),
            near_equal={"rotor_inertia": "in motion far below the resonance of joint and link"},
        ),
        ArmEffect(
            "time_delay",
            ("delay",),
            ("s",),
            "arm",
            equation="the torque comes later than the position, by the same time on every joint",
            torque=_later,
            shapes=lambda motion: [(delay,) for delay in motion.delays],
            to_file=lambda x, form: {"delay": float(x[0])},
            from_file=lambda v: (np.array([float(v["delay"])]), (float(v["delay"]),)),
            least=(ANY,),
            near_equal={"force_lag": "in motion slower than 1/(2 pi tau)"},
        ),
        ArmEffect(
            "force_lag",
            ("tau",),
            ("s",),
            "arm",
            block="channel",
            equation="the torque is read through a first-order filter, of the same time constant on every joint",
            torque=lambda motion, form: -motion.jerk[:, None],
            near_equal={"time_delay": "in motion slower than 1/(2 pi tau)"},
        ),
        ArmEffect(
            "joint_coupling",
            ("joint", "gain"),
            ("", "1"),
            family="drive_train",
            block="drive",
            equation="gain times the torque of another joint",
            source=_SICILIANO,
            torque=lambda motion, form: motion.others[:, int(form[0])][:, None],
            shape=("joint",),
            shapes=lambda motion: [(float(k),) for k in motion.geared],
            to_file=lambda x, form: {"joint": str(int(form[0])), "gain": float(x[0])},
            least=(ANY,),
        ),
        ArmEffect(
            "payload",
            ("m", "cx", "cy", "cz", *_MOMENTS),
            ("kg", "m", "m", "m", *["kg m^2"] * 6),
            "link",
            family="inertia",
            block="body",
            equation="a body of mass m with its centre at c of a link's frame, and its moments about that centre",
            source=_GAUTIER,
            of_plant=True,
            to_file=_payload_values,
            from_file=_payload_coefficients,
            least=(0.0, *[ANY] * 9),
            check=lambda x: bool(np.abs(x[1:4]).max() <= _FARTHEST * x[0]),
            near_equal={"link_inertia": "always, of the link that carries it: the file's may have been wrong"},
            optional=_MOMENTS,
        ),
        ArmEffect(
            "gravity_offset",
            ("rx", "ry"),
            ("rad", "rad"),
            "arm",
            equation="gravity turned by the rotation vector (rx, ry, 0) of the robot's foot",
            source=_SICILIANO,
            of_plant=True,
            least=(ANY, ANY),
        ),
    )
}
"""Name -> effect."""

DRY = ("coulomb_friction", "smooth_coulomb_friction", "stribeck_friction", "static_friction", "dahl_friction")
"""Laws of dry friction, of which a joint has one."""
VISCOUS = ("viscous_friction", "asymmetric_viscous_friction")
"""The same of viscous friction."""
OF_THE_LINKS = ("load_dependent_friction", "torque_gain")
"""Effects that are parts of the torque that moves the links."""
LATE = ("time_delay", "force_lag")
"""Effects of when the torque is logged."""
ARM_WIDE = ("gravity_offset", *LATE)
"""Effects of the whole arm."""
BESIDE = (
    "constant_force",
    "load_dependent_friction",
    "quadratic_drag",
    "rotor_inertia",
    "torque_gain",
    "joint_coupling",
    "torque_ripple",
    "ground_spring",
)
"""Effects that a joint may have beside these."""
