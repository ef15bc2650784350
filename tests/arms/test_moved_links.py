"""What acts on the torque of the links acts on the links as they were found, with what they carry."""

from pathlib import Path

import numpy as np
import pytest
import small_arm
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from mmt_drake.arms.arm_file import ArmModel, JointEffect
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.deliver import write_urdf
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.plant import ArmPlant

MASS, GAIN, CENTRE = 2.0, 0.2, (0.3, 0.03, -0.02)


def loaded(folder: Path, seed: int) -> np.ndarray:
    """Torques of the small arm with a heavy payload, by Drake alone."""
    moves, _ = small_arm.rigid(seed, folder)
    plant = small_arm.with_point(small_arm.plant_of(small_arm.written(folder)), "fore", MASS, CENTRE)
    plant.Finalize()
    return small_arm.inverse_dynamics(plant, moves)


def test_a_gain_beside_a_heavy_payload_is_found_with_its_number(tmp_path: Path) -> None:
    moves, _ = small_arm.rigid(7, tmp_path)
    log = small_arm.noisy(moves, loaded(tmp_path, 7) * np.array([1.0, 1.0 + GAIN, 1.0]), 7)
    found = diagnose_arm([log], small_arm.model(tmp_path))
    assert small_arm.named(found) == {("payload", "fore"), ("torque_gain", "lift")}
    assert small_arm.values(found, "payload", "fore")["m"] == pytest.approx(MASS, rel=0.01)
    assert small_arm.values(found, "torque_gain", "lift")["gain"] == pytest.approx(GAIN, rel=0.01)
    assert predicted(ArmPlant.of(found.model), found.model, log).nrmse.max() < 0.02


def test_a_model_with_payload_and_gain_predicts_the_product_of_both(tmp_path: Path) -> None:
    moves, _ = small_arm.rigid(6, tmp_path)
    torque = loaded(tmp_path, 6)
    torque[:, 2] *= 1.0 + GAIN
    payload = dict(zip(("m", "cx", "cy", "cz"), (MASS, *CENTRE), strict=True))
    effects = (JointEffect("payload", "fore", payload), JointEffect("torque_gain", "bend", {"gain": GAIN}))
    model = small_arm.model(tmp_path, effects=effects)
    told = predicted(ArmPlant.of(model), model, small_arm.noisy(moves, torque, 6, part=0.0))
    assert told.nrmse.max() < 2e-3


def test_the_robot_s_file_that_is_written_has_the_payload_and_finds_its_meshes(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    corners, sides = ("0 0 0", "1 0 0", "0 1 0", "0 0 1"), ("1 3 2", "1 2 4", "2 3 4", "3 1 4")
    lines = [*(f"v {at}" for at in corners), *(f"f {at}" for at in sides), ""]
    (tmp_path / "meshes" / "cube.obj").write_text("\n".join(lines))
    shape = '<visual><geometry><mesh filename="meshes/cube.obj"/></geometry></visual></link>'
    (tmp_path / "arm.urdf").write_text(small_arm.URDF.replace("</link>", shape, 1))
    payload = dict(zip(("m", "cx", "cy", "cz"), (MASS, *CENTRE), strict=True))
    model = ArmModel(tmp_path / "arm.urdf", effects=(JointEffect("payload", "fore", payload),))
    (tmp_path / "out").mkdir()
    written = write_urdf(model, tmp_path / "out" / "robot.urdf")
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModels(str(written))
    before, after = ArmPlant.of(ArmModel(tmp_path / "arm.urdf")), ArmPlant.of(ArmModel(written))
    np.testing.assert_allclose(after.inertias()[:2], before.inertias()[:2], atol=1e-9)
    added = after.inertias()[2] - before.inertias()[2]
    np.testing.assert_allclose(added[:4], MASS * np.array([1.0, *CENTRE]), rtol=1e-6)
