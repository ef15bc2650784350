"""What is delivered: the robot's file with the numbers found, and a diagram that simulates it with its effects."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder

from mmt_drake.arms.arm_file import ArmModel, Held
from mmt_drake.arms.believed import inertias, with_damping, with_payloads
from mmt_drake.arms.joint_effects import JointEffects
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.plant import ArmPlant, give_links, weld_held
from mmt_drake.arms.regressor import tilted_gravity
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.atomic import replacing


def write_urdf(model: ArmModel, path: str | Path) -> Path:
    """The robot's URDF with the inertial numbers of a model, its payloads among them.

    A link's numbers hold what hangs on it rigidly as well: it has them alone, and what hangs on it has no mass. Files
    that it names as seen from its own folder, such as meshes, are named as seen from that of the new one.

    Args:
        model: of a robot whose file is a URDF.
        path: of the file that is written.

    Raises:
        BadInput: the robot is no URDF, or the file cannot be written.
    """
    if model.robot.suffix != ".urdf":
        raise BadInput(model.source, at="robot", found=model.robot.name, expected="a URDF, to write one")
    tree = ET.parse(model.robot)
    links = {link.get("name"): link for link in tree.getroot().iter("link")}
    arm = ArmPlant.of(replace(model, held=()))
    payloads = {effect.where for effect in model.effects if ARM_EFFECTS[effect.name].place == "link"}
    numbers_of = dict(zip(arm.links, with_payloads(arm, replace(model, held=())), strict=True))
    for name in dict.fromkeys((*model.links, *(link for link in arm.links if link in payloads))):
        numbers = numbers_of[name]
        for hung in arm.hung_on(name):
            if (inertial := links[hung].find("inertial")) is not None:
                links[hung].remove(inertial)
        _set_inertial(links[name], np.asarray(numbers))
    for named in tree.getroot().iter():
        file = named.get("filename", "")
        if file and "://" not in file and not Path(file).is_absolute():
            named.set("filename", os.path.relpath(model.robot.parent / file, Path(path).parent))
    with replacing(Path(path)) as partial:
        tree.write(partial, encoding="utf-8", xml_declaration=True)
    return Path(path)


def _set_inertial(link: ET.Element, numbers: Array) -> None:
    mass, c = numbers[0], numbers[1:4] / numbers[0]
    xx, yy, zz, xy, xz, yz = numbers[4:]
    about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    about = about - mass * (c @ c * np.eye(3) - np.outer(c, c))  # Steiner: URDF has it about the centre
    for old in link.findall("inertial"):
        link.remove(old)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=" ".join(f"{v:.9g}" for v in c), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=f"{mass:.9g}")
    moments = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
    ET.SubElement(inertial, "inertia", {key: f"{about[at]:.9g}" for key, at in moments.items()})


def arm_diagram(model: ArmModel) -> tuple[Diagram, Any]:
    """A diagram of an arm with its effects, and the plant in it.

    .. pydrake_system::

        name: ArmDiagram
        input_ports:
        - torque
        output_ports:
        - state

    `torque` (joints,) [N m] is what the drives give to the recorded joints, `state` the plant's: positions, velocities.
    Friction, springs, ripples, offsets and drag act as in the model; inertias of rotors are the plant's own; gains and
    delays of the log, which no arm feels, do not. What is held, and payloads, are welded to their links; gravity
    is turned as the model says.

    Args:
        model: of an arm.
    """
    builder = DiagramBuilder()
    arm = ArmPlant.of(model, finalize=False)
    model = with_damping(arm, model)  # which its effects have then, and its plant has not
    for joint in [] if arm.plant.is_finalized() else [arm.plant.GetJointByName(name) for name in arm.joints]:
        joint.set_default_damping_vector(np.zeros(1))
    plant = builder.AddNamedSystem("plant", arm.plant)
    weld_held(plant, _payloads(model), model.source, "payload")
    gravity = plant.mutable_gravity_field()
    for effect in model.effects:
        if effect.name == "rotor_inertia":
            joint = plant.GetJointByName(effect.where)
            actuator = plant.AddJointActuator(f"rotor_{effect.where}", joint)
            actuator.set_default_rotor_inertia(float(effect.parameters["I"]))
        if effect.name == "gravity_offset":
            turn = float(effect.parameters["rx"]), float(effect.parameters["ry"])
            gravity.set_gravity_vector(tilted_gravity(np.asarray(gravity.gravity_vector()), *turn))
    plant.Finalize()
    arm = ArmPlant(plant, arm.joints, arm.links)
    effects = builder.AddNamedSystem("effects", JointEffects(arm, model))
    builder.Connect(plant.get_state_output_port(), effects.GetInputPort("state"))
    builder.Connect(effects.GetOutputPort("force"), plant.get_applied_generalized_force_input_port())
    builder.ExportInput(effects.GetInputPort("torque"), "torque")
    builder.ExportOutput(plant.get_state_output_port(), "state")
    return builder.Build(), plant


def _payloads(model: ArmModel) -> tuple[Held, ...]:
    """Payloads among the effects of a model, as bodies."""
    bodies = []
    for effect in model.effects:
        if effect.name == "payload":
            law = ARM_EFFECTS[effect.name]
            m, x, y, z = (float(effect.parameters[symbol]) for symbol in ("m", "cx", "cy", "cz"))
            moments = tuple(float(effect.parameters.get(symbol, 0.0)) for symbol in law.optional)
            bodies.append(Held(effect.where, m, (x, y, z), moments))
    return tuple(bodies)


def set_links(model: ArmModel, plant: Any, context: Any) -> None:
    """Give the links of a plant the inertial numbers of its model.

    These hold what hangs on a link rigidly, and what is held, which have next to none then; payloads keep theirs.

    Args:
        model: of the arm.
        plant: of `arm_diagram`.
        context: the plant's own.
    """
    arm = ArmPlant.of(model)
    inertias(arm, model)  # refuses links that are not there
    give_links(arm, plant, context, model.links)
