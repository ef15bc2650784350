"""The files in `examples/`, on which the commands of README and docs run: recordings by the trial's own plants.

    python scripts/examples.py

contact.csv: a hand strokes a box on a table, which has Coulomb friction; contact.yaml is the model without it.
tensile.csv: a spring and a damper pulled, as a testing machine writes it: mm, ms, decimal commas, the machine's sign.
servo.csv: a servo that follows a reference; servo.yaml is the model without its friction.
arm_log.csv: an arm of three joints, arm.urdf, that rubs in each of them; arm.yaml is the model without that.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession, MaterialSession
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.recording import Recording

FOLDER = Path(__file__).resolve().parents[1] / "examples"
BOX = {"m": 0.5, "k1": 0.0, "k2": 450.0, "b1": 20.0, "b2": 25.0, "Fc": 0.0, "normal_k": 400.0, "normal_b": 8.0}
FRICTION = Concealed("coulomb_friction", {"Fc": 0.4})
STRIP = {"k": 1200.0, "b": 35.0, "x0": 0.0, "F0": 0.8}
SERVO = {"m": 2.0, "b": 10.0, "k": 80.0, "Fc": 0.5, "offset": 0.0, "gravity": 0.0, "pendulum": 0.0}

CONTACT_MODEL = """\
# What is believed of the box: its friction is missing.
structure: flexible_box
parameters: {m: 0.5, k1: 0.0, k2: 450.0, b1: 20.0, b2: 25.0, Fc: 0.0}
normal: {k: 400.0, b: 8.0}
"""
SERVO_MODEL = """\
# What is believed of the servo: its friction is missing.
structure: driven_body
parameters: {m: 2.0, b: 10.0, k: 80.0}
"""

ARM_MODEL = """\
# What is believed of the arm: its robot file alone.
structure: multibody
robot: arm.urdf
torque: {column: tau}
"""
ARM = """\
<?xml version="1.0"?>
<robot name="arm">
  <link name="foot"/>
  <link name="column">
    <inertial>
      <origin xyz="0 0.01 0.15"/>
      <mass value="6.0"/>
      <inertia ixx="0.06" iyy="0.06" izz="0.02" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <link name="upper_arm">
    <inertial>
      <origin xyz="0.2 0 0.02"/>
      <mass value="4.0"/>
      <inertia ixx="0.01" iyy="0.07" izz="0.07" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <link name="forearm">
    <inertial>
      <origin xyz="0.15 0 0"/>
      <mass value="2.0"/>
      <inertia ixx="0.003" iyy="0.025" izz="0.025" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="base" type="revolute">
    <parent link="foot"/>
    <child link="column"/>
    <origin xyz="0 0 0.1"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="60" velocity="4"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <parent link="column"/>
    <child link="upper_arm"/>
    <origin xyz="0 0.06 0.3"/>
    <axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="60" velocity="4"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper_arm"/>
    <child link="forearm"/>
    <origin xyz="0.42 0 0"/>
    <axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" effort="30" velocity="4"/>
  </joint>
</robot>
"""
ARM_COULOMB, ARM_VISCOUS = np.array([2.4, 3.1, 1.2]), np.array([0.9, 1.6, 0.0])
"""Friction of its joints [N m], [N m s/rad]."""


def contact() -> Recording:
    """12 s of strokes at 500 Hz."""
    session = ContactSession(seed=3, noise=0.015, duration=12.0, rate_hz=500.0, velocity=False)
    return session.record(BOX, (FRICTION,))


def tensile() -> Recording:
    """10 s at 250 Hz."""
    return thinned(MaterialSession(4).record(STRIP, ()), 4, 10.0)


def servo() -> Recording:
    """15 s at 250 Hz."""
    return thinned(DrivenSession(5, noise=2e-5).record(SERVO, ()), 4, 15.0)


def arm() -> dict[str, np.ndarray]:
    """25 s at 100 Hz: sums of sines in each joint, and the torques of Drake's inverse dynamics with friction."""
    rng = np.random.default_rng(7)
    time = np.arange(0.0, 25.0, 0.01)
    w, phase = 2.0 * np.pi * rng.uniform(0.1, 0.9, (3, 5)), rng.uniform(0.0, 2.0 * np.pi, (3, 5))
    size, angle = rng.uniform(0.3, 0.7, (3, 5)) / w, w * time[:, None, None] + phase
    q, v, a = ((size * w**k * f).sum(2) for k, f in enumerate((np.sin(angle), np.cos(angle), -np.sin(angle))))
    plant = MultibodyPlant(0.0)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "arm.urdf").write_text(ARM)
        Parser(plant).AddModels(str(Path(folder) / "arm.urdf"))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("foot"))
    plant.Finalize()
    context, forces, torque = plant.CreateDefaultContext(), MultibodyForces(plant), np.empty_like(q)
    for i in range(len(time)):
        plant.SetPositionsAndVelocities(context, [*q[i], *v[i]])
        plant.CalcForceElementsContribution(context, forces)
        torque[i] = plant.CalcInverseDynamics(context, a[i], forces)
    torque += ARM_COULOMB * np.sign(v) + ARM_VISCOUS * v
    torque += 0.02 * torque.std(axis=0) * rng.standard_normal(torque.shape)
    columns = {f"{name}_{j}": values[:, j] for name, values in (("q", q), ("tau", torque)) for j in range(3)}
    return {"time": time, **columns}


def thinned(recording: Recording, every: int, seconds: float) -> Recording:
    """Every so manieth sample of its beginning."""
    kept = slice(0, int(np.searchsorted(recording.time, recording.time[0] + seconds)), every)
    columns = {name: values[kept] for name, values in recording.columns.items()}
    return replace(recording, time=recording.time[kept], columns=columns)


def table(columns: dict[str, np.ndarray], digits: dict[str, int], separator: str = ",", mark: str = ".") -> str:
    """Columns as text, each number to so many decimals."""
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [separator.join(columns)]
    for row in rows:
        cells = (f"{value:.{digits[name]}f}" for name, value in zip(columns, row, strict=True))
        lines.append(separator.join(cell.replace(".", mark) for cell in cells))
    return "\n".join(lines) + "\n"


def files() -> dict[str, str]:
    """Every example by its name."""
    box, strip, driven, joints = contact(), tensile(), servo(), arm()
    wanted = {"time": 3, **{f"position_{a}": 6 for a in "xyz"}, **{f"force_{a}": 4 for a in "xyz"}, "in_contact": 0}
    contact_columns = {name: box.time if name == "time" else box[name] for name in wanted}
    machine = {"t [ms]": 1e3 * strip.time, "Weg [mm]": 1e3 * strip["position"], "Kraft [N]": -strip["force"]}
    servo_columns = {"time": driven.time, "input": driven["input"], "output": driven["output"]}
    return {
        "contact.csv": table(contact_columns, wanted),
        "contact.yaml": CONTACT_MODEL,
        "tensile.csv": table(machine, {"t [ms]": 0, "Weg [mm]": 3, "Kraft [N]": 3}, ";", ","),
        "servo.csv": table(servo_columns, {"time": 3, "input": 5, "output": 6}),
        "servo.yaml": SERVO_MODEL,
        "arm_log.csv": table(joints, {name: 2 if name == "time" else 5 for name in joints}),
        "arm.urdf": ARM,
        "arm.yaml": ARM_MODEL,
    }


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, text in files().items():
        (FOLDER / name).write_text(text, encoding="utf-8")
