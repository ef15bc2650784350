"""The plant of an arm: Drake's, with the links that the recorded joints carry."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, FixedOffsetFrame, RotationalInertia, SpatialInertia, UnitInertia

from mmt_drake.arms.arm_file import ArmModel, Held
from mmt_drake.errors import BadInput, one_line
from mmt_drake.numeric.arrays import Array
from mmt_drake.own_code import read_code

_OF_ONE_AXIS = ("revolute", "prismatic")


@dataclass(frozen=True)
class ArmPlant:
    """A plant, and which of its joints were recorded.

    Attributes:
        plant: finalized.
        joints: names, in the order of the log.
        links: the link that each of them moves.
    """

    plant: Any
    joints: tuple[str, ...]
    links: tuple[str, ...]

    @classmethod
    def of(cls, model: ArmModel, finalize: bool = True) -> ArmPlant:
        """The arm of a model; its effects and changed links are not in the plant.

        Args:
            model: of the arm.
            finalize: whether nothing is to be added to the plant.

        Raises:
            BadInput: the robot's file cannot be read, or has no such joints.
        """
        plant = _from_code(model) if model.function else MultibodyPlant(0.0)  # continuous
        if model.function:
            weld_held(plant, model.held, model.source)
        else:
            plant_from_file(model, plant)
        if finalize and not plant.is_finalized():
            plant.Finalize()
        moving = [plant.get_joint(index) for index in plant.GetJointIndices()]
        moving = [joint for joint in moving if joint.type_name() != "weld"]
        names = model.joints or tuple(joint.name() for joint in moving)
        known = {joint.name(): joint for joint in moving}
        for name in names:
            if name not in known:
                raise BadInput(model.source, at="joints", found=name, expected=f"one of {', '.join(known)}")
            if known[name].type_name() not in _OF_ONE_AXIS:
                raise BadInput(model.source, at="joints", found=f"{name}, of several axes", expected="joints of one")
        if len(set(names)) < len(names):
            raise BadInput(model.source, at="joints", found="one twice", expected="each once")
        return cls(plant, tuple(names), tuple(known[name].child_body().name() for name in names))

    @cached_property
    def _joints(self) -> list[Any]:
        return [self.plant.GetJointByName(name) for name in self.joints]

    @cached_property
    def position_index(self) -> list[int]:
        """Where each recorded joint stands in the plant's positions."""
        return [joint.position_start() for joint in self._joints]

    @cached_property
    def velocity_index(self) -> list[int]:
        """Where it stands in the plant's velocities."""
        return [joint.velocity_start() for joint in self._joints]

    @property
    def position_limits(self) -> tuple[Array, Array]:
        """Lowest and highest position of each recorded joint [rad] or [m], infinite where the file has none."""
        limits = [(j.position_lower_limits()[0], j.position_upper_limits()[0]) for j in self._joints]
        low, high = np.array(limits, dtype=np.float64).T
        return low, high

    @property
    def damping(self) -> Array:
        """Viscous friction of each recorded joint, as the robot's file says [N m s/rad] or [N s/m], (joints,)."""
        return np.array([float(joint.default_damping_vector()[0]) for joint in self._joints])

    @cached_property
    def slides(self) -> tuple[bool, ...]:
        """Whether a joint slides, and has m and N in the place of rad and N m."""
        return tuple(joint.type_name() == "prismatic" for joint in self._joints)

    @cached_property
    def bodies(self) -> list[Any]:
        """The body that each recorded joint moves; what hangs on it rigidly moves with it."""
        return [joint.child_body() for joint in self._joints]

    @cached_property
    def _carried(self) -> list[list[Any]]:
        """Indices of the bodies that move with each of `bodies`, joints that were not recorded held where they are."""
        plant, own = self.plant, {int(body.index()): i for i, body in enumerate(self.bodies)}
        parent = {}
        for index in plant.GetJointIndices():
            joint = plant.get_joint(index)
            parent[int(joint.child_body().index())] = int(joint.parent_body().index())
        carried: list[list[Any]] = [[] for _ in self.bodies]
        for number in range(plant.num_bodies()):
            up: int | None = number
            while up is not None and up not in own:
                up = parent.get(up)
            if up is not None:
                carried[own[up]].append(BodyIndex(number))
        return carried

    def hung_on(self, link: str) -> list[str]:
        """Bodies that move with a link and are not it."""
        own = self._carried[self.links.index(link)]
        names = [self.plant.get_body(index).name() for index in own]
        return [name for name in names if name != link]

    def inertias(self) -> Array:
        """Inertial numbers of the links of the recorded joints, with what hangs on them, (links, 10); see `INERTIA`."""
        context = self.plant.CreateDefaultContext()
        rows = []
        for body, carried in zip(self.bodies, self._carried, strict=True):
            whole = self.plant.CalcSpatialInertia(context, body.body_frame(), carried)
            mass, inertia = whole.get_mass(), whole.CalcRotationalInertia().CopyToFullMatrix3()
            moments = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
            rows.append([mass, *(mass * whole.get_com()), *moments])
        return np.array(rows)


def _from_code(model: ArmModel) -> Any:
    expected = f"{model.function}() -> MultibodyPlant"
    module = read_code(model.robot, expected)
    make = getattr(module, model.function, None)
    if not callable(make):
        raise BadInput(model.robot, found=f"no {model.function}", expected=expected)
    try:
        plant = make()
    except Exception as error:
        raise BadInput(model.robot, at=model.function, found=one_line(error), expected=expected) from error
    if not isinstance(plant, MultibodyPlant):
        raise BadInput(model.robot, at=model.function, found=type(plant).__name__, expected="a MultibodyPlant")
    return plant


def plant_from_file(model: ArmModel, plant: Any) -> None:
    """Put a robot's file into a plant, with what is held, its first body welded to the world unless the file does that.

    Drake's warnings about what it leaves out of a file (friction, gears) are not repeated: what the joints have is
    what the model file says.

    Args:
        model: of the arm.
        plant: empty, not finalized.

    Raises:
        BadInput: the file cannot be read.
    """
    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        (robot,) = Parser(plant).AddModels(str(model.robot))
    except (RuntimeError, ValueError) as error:
        raise BadInput(model.robot, found=one_line(error), expected="one robot, as URDF, SDF or MJCF") from error
    finally:
        log.setLevel(level)
    welded = {int(plant.get_joint(i).child_body().index()) for i in plant.GetJointIndices()}
    roots = [i for i in plant.GetBodyIndices(robot) if int(i) not in welded]
    for root in roots:
        plant.WeldFrames(plant.world_frame(), plant.get_body(root).body_frame())
    plant.mutable_gravity_field().set_gravity_vector(model.gravity)
    weld_held(plant, model.held, model.source)


def spatial_inertia(numbers: Array) -> Any:
    """Drake's spatial inertia of a link's ten numbers (10,)."""
    mass = float(numbers[0])
    rotational = RotationalInertia(*(float(n) / mass for n in numbers[4:]))
    unit = UnitInertia(rotational)
    return SpatialInertia(mass, np.asarray(numbers[1:4]) / mass, unit)


def give_links(arm: ArmPlant, plant: Any, context: Any, links: Mapping[str, Sequence[float] | Array]) -> None:
    """Give links their inertial numbers; what hangs on them rigidly, which these hold, has next to none then.

    Args:
        arm: whose links.
        plant: its own, or one like it.
        context: the plant's.
        links: name -> (10,).
    """
    nothing = SpatialInertia(1e-9, np.zeros(3), UnitInertia.SolidSphere(1e-3))
    for name, numbers in links.items():
        for hung in arm.hung_on(name):
            plant.GetBodyByName(hung).SetSpatialInertiaInBodyFrame(context, nothing)
        plant.GetBodyByName(name).SetSpatialInertiaInBodyFrame(context, spatial_inertia(np.asarray(numbers)))


def weld_held(plant: Any, held: tuple[Held, ...], source: str, name: str = "held") -> None:
    """Weld what is held to its links, as bodies or as points.

    Args:
        plant: not finalized.
        held: what it is.
        source: the model file, for messages.
        name: of the bodies that are added, before their numbers.

    Raises:
        BadInput: there is no such link, or no body has such moments.
    """
    for number, one in enumerate(held):
        if not plant.HasBodyNamed(one.link):
            raise BadInput(source, at=f"held[{number}].link", found=one.link, expected="a link of the robot")
        body = plant.GetBodyByName(one.link)
        try:
            unit = UnitInertia(*(n / one.m for n in one.moments)) if any(one.moments) else UnitInertia.SolidSphere(1e-3)
            inertia = SpatialInertia(one.m, np.zeros(3), unit)
        except (RuntimeError, ZeroDivisionError) as error:
            found = f"moments {', '.join(f'{n:g}' for n in one.moments)} of {one.m:g} kg at {one.link}"
            raise BadInput(source, at=name, found=found, expected="moments that a body can have") from error
        added = plant.AddRigidBody(f"{name}_{number}", body.model_instance(), inertia)
        frame = plant.AddFrame(
            FixedOffsetFrame(f"{name}_{number}_on_{one.link}", body, RigidTransform(np.array(one.c)))
        )
        plant.WeldFrames(frame, added.body_frame())
