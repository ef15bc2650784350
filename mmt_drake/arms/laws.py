"""Effects of arms: what each adds to the torque of a joint that moves as recorded.

Laws of friction, drag and bodies are those of the library (`mmt_drake.effects`), called through their addresses: N is
N m and m is rad where a joint turns. Others only an arm has. All are linear in numbers that say how strongly they act;
numbers that say how (`shapes`) are sought on a grid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from mmt_drake.arms.joint_motion import JointMotion
from mmt_drake.arms.law_torque import along
from mmt_drake.effects import LIBRARY
from mmt_drake.numeric.arrays import Array

Shape = tuple[float, ...]
Numbers = Mapping[str, float | str]
_NEIGHBOURS: Final = 2
"""Joints whose drives may be geared together are no farther apart in the chain."""
_FARTHEST: Final = 1.0
"""A payload is no farther from the frame of its link than this [m]."""


@dataclass(frozen=True)
class ArmEffect:
    """One effect of arms.

    Attributes:
        name: in model files and reports.
        place: where it acts: a joint, a link, or the whole arm.
        family, block: how deep its name may hold.
        symbols: its numbers, in the order of files.
        units: theirs, of a joint that turns.
        columns: (motion of a joint, shape) -> (n, k), the torque that its drive has to give [N m] for each of the k
            numbers being 1; None where the regressor of the links says it.
        shapes: (motion of the joint) -> shapes that are tried.
        values: (k numbers, shape) -> numbers by symbol.
        coefficients: numbers by symbol -> (k numbers, shape).
        least: that each of the k numbers may be.
        check: whether k numbers that each may be go together.
        holds: effects that are special or limiting cases of it.
        replaces: the part of a joint that one law alone may have; empty: it stands beside others.
        equation, source: for people.
        equal_to: that no log can tell from it.
        near_equal: effect -> where logs hardly tell it from this one.
    """

    name: str
    place: Literal["joint", "link", "arm"]
    family: str
    block: str
    symbols: tuple[str, ...]
    units: tuple[str, ...]
    values: Callable[[Array, Shape], Numbers]
    coefficients: Callable[[Numbers], tuple[Array, Shape]]
    equation: str
    source: str
    columns: Callable[[JointMotion, Shape], Array] | None = None
    shapes: Callable[[JointMotion], Sequence[Shape]] = lambda motion: [()]
    least: tuple[float, ...] = (-math.inf,)
    check: Callable[[Array], bool] = lambda x: True
    holds: tuple[str, ...] = ()
    replaces: str = ""
    equal_to: tuple[str, ...] = ()
    near_equal: Mapping[str, str] = field(default_factory=dict)


def _linear(
    name: str,
    symbols: tuple[str, ...],
    units: tuple[str, ...],
    parts: Callable[[Shape], Sequence[tuple[Mapping[str, float], Mapping[str, float]]]],
    *,
    shape: tuple[str, ...] = (),
    shapes: Callable[[JointMotion], Sequence[Shape]] = lambda motion: [()],
    least: float = 0.0,
    check: Callable[[Array], bool] = lambda x: True,
    holds: tuple[str, ...] = (),
    replaces: str = "",
    equal_to: tuple[str, ...] = (),
    near_equal: Mapping[str, str] | None = None,
) -> ArmEffect:
    """An effect of the library on a joint, linear in its numbers but those of its shape."""
    strong = tuple(s for s in symbols if s not in shape)

    def columns(motion: JointMotion, form: Shape) -> Array:
        return np.stack([along(name, motion, values, uses) for values, uses in parts(form)], 1)

    law = LIBRARY[name]
    return ArmEffect(
        name,
        "joint",
        law.family,
        law.block,
        symbols,
        units,
        values=lambda x, form: {**dict(zip(strong, map(float, x), strict=True)), **dict(zip(shape, form, strict=True))},
        coefficients=lambda v: (np.array([float(v[s]) for s in strong]), tuple(float(v[s]) for s in shape)),
        equation=law.equation,
        source=law.source,
        columns=columns,
        shapes=shapes,
        least=(least,) * len(strong),
        check=check,
        holds=holds,
        replaces=replaces,
        equal_to=equal_to,
        near_equal=near_equal or {},
    )


def _speeds(*parts: float) -> Callable[[JointMotion], list[Shape]]:
    return lambda motion: [(part * motion.fastest,) for part in parts]


def _ripples(motion: JointMotion) -> list[Shape]:
    return [(period,) for period in motion.ripples]


def _ripple_values(x: Array, form: Shape) -> Numbers:
    return {"amplitude": math.hypot(x[0], x[1]), "period": form[0], "phase": math.atan2(x[1], x[0])}


def _ripple_coefficients(values: Numbers) -> tuple[Array, Shape]:
    amplitude, phase = float(values["amplitude"]), float(values["phase"])
    return np.array([amplitude * math.cos(phase), amplitude * math.sin(phase)]), (float(values["period"]),)


def _ripple_columns(motion: JointMotion, form: Shape) -> Array:
    numbers = [{"amplitude": 1.0, "period": form[0], "phase": phase} for phase in (0.0, 0.5 * math.pi)]
    return np.stack([along("torque_ripple", motion, values, {}) for values in numbers], 1)


def _dahl_columns(motion: JointMotion, form: Shape) -> Array:
    return along("dahl_friction", motion, {"Fc": 1.0, "sigma": 1.0 / form[0]}, {})[:, None]


def _one(symbol: str) -> tuple[Callable[[Array, Shape], Numbers], Callable[[Numbers], tuple[Array, Shape]]]:
    return lambda x, form: {symbol: float(x[0])}, lambda values: (np.array([float(values[symbol])]), ())


def _point(m: float, c: Sequence[float]) -> Array:
    """The ten inertial numbers of a point mass."""
    x, y, z = c
    return m * np.array([1.0, x, y, z, y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z])


def _own(
    name: str,
    symbol: str,
    unit: str,
    column: Callable[[JointMotion], Array],
    family: str,
    block: str,
    equation: str,
    source: str,
    least: float = -math.inf,
    equal_to: tuple[str, ...] = (),
    near_equal: Mapping[str, str] | None = None,
) -> ArmEffect:
    """An effect of one number on one joint, which the library has not or has for other structures."""
    values, coefficients = _one(symbol)
    return ArmEffect(
        name,
        "joint",
        family,
        block,
        (symbol,),
        (unit,),
        values=values,
        coefficients=coefficients,
        equation=equation,
        source=source,
        columns=lambda motion, form: column(motion)[:, None],
        least=(least,),
        equal_to=equal_to,
        near_equal=near_equal or {},
    )


_DRY, _VISCOUS = "dry friction", "viscous friction"
_STIFF_START = (0.015, 0.03, 0.06, 0.12, 0.2, 0.35)
_GAUTIER: Final = "Gautier and Khalil 1990, IEEE Trans. Robotics and Automation 6(3)"
_SICILIANO: Final = "Siciliano, Sciavicco, Villani and Oriolo 2009, Robotics, chapter 7"

ARM_EFFECTS: Final[dict[str, ArmEffect]] = {
    effect.name: effect
    for effect in (
        _linear("viscous_friction", ("b",), ("N m s/rad",), lambda form: [({"b": 1.0}, {})], replaces=_VISCOUS),
        _linear(
            "asymmetric_viscous_friction",
            ("b_plus", "b_minus"),
            ("N m s/rad", "N m s/rad"),
            lambda form: [({"b_plus": 1.0, "b_minus": 0.0}, {}), ({"b_plus": 0.0, "b_minus": 1.0}, {})],
            holds=("viscous_friction",),
            replaces=_VISCOUS,
        ),
        _linear("quadratic_drag", ("c",), ("N m s^2/rad^2",), lambda form: [({"c": 1.0}, {})]),
        _linear("coulomb_friction", ("Fc",), ("N m",), lambda form: [({"Fc": 1.0}, {})], replaces=_DRY),
        _linear(
            "smooth_coulomb_friction",
            ("Fc", "v_s"),
            ("N m", "rad/s"),
            lambda form: [({"Fc": 1.0, "v_s": form[0]}, {})],
            shape=("v_s",),
            shapes=_speeds(*_STIFF_START),
            holds=("coulomb_friction",),
            replaces=_DRY,
        ),
        _linear(
            "stribeck_friction",
            ("Fc", "Fs", "v_s"),
            ("N m", "N m", "rad/s"),
            lambda form: [({"Fs": 0.0, "v_s": form[0]}, {"Fc": 1.0}), ({"Fs": 1.0, "v_s": form[0]}, {"Fc": 0.0})],
            shape=("v_s",),
            shapes=_speeds(*_STIFF_START),
            check=lambda x: bool(x[1] >= x[0]),  # it falls with speed
            holds=("coulomb_friction",),
            replaces=_DRY,
        ),
        ArmEffect(
            "dahl_friction",
            "joint",
            "dry_friction",
            "friction",
            ("Fc", "sigma"),
            ("N m", "N m/rad"),
            values=lambda x, form: {"Fc": float(x[0]), "sigma": float(x[0]) / form[0]},
            coefficients=lambda v: (np.array([float(v["Fc"])]), (float(v["Fc"]) / (float(v["sigma"]) or 1.0),)),
            equation=LIBRARY["dahl_friction"].equation,
            source=LIBRARY["dahl_friction"].source,
            columns=_dahl_columns,
            shapes=lambda motion: [(part * motion.reach,) for part in (0.003, 0.006, 0.012, 0.025, 0.05, 0.1)],
            least=(0.0,),
            holds=("coulomb_friction",),
            replaces=_DRY,
        ),
        _linear("load_dependent_friction", ("mu",), ("1",), lambda form: [({"mu": 1.0}, {})]),
        _linear("constant_force", ("F",), ("N m",), lambda form: [({"F": 1.0}, {"gain": 1.0})], least=-math.inf),
        _linear("ground_spring", ("k",), ("N m/rad",), lambda form: [({"k": 1.0}, {})]),
        ArmEffect(
            "torque_ripple",
            "joint",
            "body_force",
            "body",
            ("amplitude", "period", "phase"),
            ("N m", "rad", "rad"),
            values=_ripple_values,
            coefficients=_ripple_coefficients,
            equation=LIBRARY["torque_ripple"].equation,
            source=LIBRARY["torque_ripple"].source,
            columns=_ripple_columns,
            shapes=_ripples,
            least=(-math.inf, -math.inf),
        ),
        _own(
            "rotor_inertia",
            "I",
            "kg m^2",
            lambda motion: motion.a,
            "inertia",
            "body",
            "I q'', I as seen from the joint",
            _SICILIANO,
            least=0.0,
            near_equal={"the link's own inertia about the axis": "always, on the first joint of a chain"},
        ),
        _own(
            "torque_gain",
            "gain",
            "1",
            lambda motion: motion.rigid,
            "sensor",
            "force_sensor",
            "the log tells gain times the torque that moves the links; the numbers tell gain - 1",
            _SICILIANO,
            near_equal={"inertias of all links scaled": "where it is the same on every joint"},
        ),
        ArmEffect(
            "time_delay",
            "arm",
            "timing",
            "channel",
            ("delay",),
            ("s",),
            values=lambda x, form: {"delay": float(x[0])},
            coefficients=lambda v: (np.array([float(v["delay"])]), ()),
            equation="the torque comes later than the position, by the same time on every joint; to first order",
            source=LIBRARY["time_delay"].source,
            columns=lambda motion, form: -motion.jerk[:, None],
        ),
        ArmEffect(
            "joint_coupling",
            "joint",
            "drive_train",
            "drive",
            ("joint", "gain"),
            ("", "1"),
            values=lambda x, form: {"joint": str(int(form[0])), "gain": float(x[0])},
            coefficients=lambda v: (np.array([float(v["gain"])]), (float(v["joint"]),)),
            equation="gain times the torque of another joint",
            source=_SICILIANO,
            columns=lambda motion, form: motion.others[:, int(form[0])][:, None],
            shapes=lambda motion: [
                (float(k),) for k in range(motion.others.shape[1]) if 0 < abs(k - motion.joint) <= _NEIGHBOURS
            ],
        ),
        ArmEffect(
            "payload",
            "link",
            "inertia",
            "body",
            ("m", "cx", "cy", "cz"),
            ("kg", "m", "m", "m"),
            values=lambda x, form: {
                "m": float(x[0]),
                **{f"c{axis}": float(x[1 + i] / x[0]) if x[0] else 0.0 for i, axis in enumerate("xyz")},
            },
            coefficients=lambda v: (_point(float(v["m"]), [float(v[f"c{axis}"]) for axis in "xyz"]), ()),
            equation="a mass m with its centre at c of a link's frame; fitted with an inertia of its own",
            source=_GAUTIER,
            least=(0.0, *[-math.inf] * 9),
            check=lambda x: bool(np.abs(x[1:4]).max() <= _FARTHEST * x[0]),
            near_equal={"inertial numbers of that link": "always: the file's may have been wrong"},
        ),
        ArmEffect(
            "gravity_offset",
            "arm",
            "body_force",
            "body",
            ("rx", "ry"),
            ("rad", "rad"),
            values=lambda x, form: {"rx": float(x[0]), "ry": float(x[1])},
            coefficients=lambda v: (np.array([float(v["rx"]), float(v["ry"])]), ()),
            equation="gravity turned by rx and ry about the axes of the robot's foot, to first order",
            source=_SICILIANO,
            least=(-math.inf, -math.inf),
        ),
    )
}
"""Name -> effect."""

DRY = ("coulomb_friction", "smooth_coulomb_friction", "stribeck_friction", "dahl_friction")
"""Laws of dry friction, of which a joint has one."""
VISCOUS = ("viscous_friction", "asymmetric_viscous_friction")
"""The same of viscous friction."""
OF_THE_LINKS = ("load_dependent_friction", "torque_gain")
"""Effects that are parts of the torque that moves the links."""
ARM_WIDE = ("gravity_offset", "time_delay")
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
