"""A planned motion keeps every limit, begins and ends at rest, keeps links apart, and tells more than the example."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.arm_file import ArmModel, JointEffect, load_arm_model
from mmt_drake.arms.base_parameters import BaseStructure
from mmt_drake.arms.believed import with_payloads
from mmt_drake.arms.excitation import NOISE, Excitation, PlannedMotion, fourier_bases, motion_told, period_of
from mmt_drake.arms.joint_limits import JointLimits
from mmt_drake.arms.joint_log import JointLog, load_joint_log
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.regressor import regressor
from mmt_drake.arms.self_collision import CLEARANCE_M, SelfCollision
from mmt_drake.cli.main import main
from mmt_drake.errors import BadInput

REACH, BALL = 0.4, 0.15
BALLS = '<collision><origin xyz="{} 0 0"/><geometry><sphere radius="0.15"/></geometry></collision></link>'


def two_links(folder: Path, *, balls: bool = False, effort: str = "200") -> ArmModel:
    """Two turning joints, level axes; with balls, one on the foot and one at the end, which meet where it folds."""
    far = small_arm.link("l1", 1.5, (0.2, 0.02, 0.0), (0.01, 0.02, 0.02))
    parts = [
        '<link name="foot"/>' if not balls else '<link name="foot">' + BALLS.format(0.0),
        small_arm.link("l0", 2.0, (0.2, 0.0, 0.01), (0.01, 0.03, 0.03)),
        far.replace("</link>", BALLS.format(REACH)) if balls else far,
        small_arm.joint("j0", "foot", "l0", "0 0 0", "0 1 0"),
        small_arm.joint("j1", "l0", "l1", f"{REACH} 0 0", "0 1 0"),
    ]
    path = folder / "two.urdf"
    path.write_text(small_arm.robot(*parts).replace('effort="200"', f'effort="{effort}"'))
    return ArmModel(path)


def planned(model: ArmModel, seed: int = 0) -> tuple[PlannedMotion, JointLimits, float]:
    arm = ArmPlant.of(model)
    limits = JointLimits.of(arm, model, acceleration=[10.0])
    structure = BaseStructure.of(arm, with_payloads(arm, model).ravel())
    collision = SelfCollision(model, arm) if "collision" in model.robot.read_text() else None
    search = Excitation(structure, limits, period_of(10.0, limits, 3, 8.0), 3, collision)
    course, size = search.admitted(search.best(seed), 10.0, 200.0)
    return course, limits, size


@pytest.fixture(scope="module")
def examples(checkout: Path) -> Path:
    return checkout / "examples"


@pytest.fixture(scope="module")
def motion(examples: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The motion that the command plans for the arm in `examples/`."""
    out = tmp_path_factory.mktemp("excite") / "motion.csv"
    arguments = ["excite", "--model", str(examples / "arm.yaml"), "--acceleration", "10", "--out", str(out)]
    assert main([*arguments, "--log", str(examples / "arm_log.csv")]) == 0
    return out


def course_of(path: Path) -> PlannedMotion:
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    return PlannedMotion(table[:, 0], table[:, 1:4], table[:, 4:7], table[:, 7:])


def test_the_file_keeps_every_limit_of_the_robot_s_file(motion: Path, examples: Path) -> None:
    """Between rows too: of the parabola through each row by its acceleration; torques by Drake's inverse dynamics."""
    course = course_of(motion)
    half = 0.5 * np.diff(course.time)[0]
    limits = np.array([3.0, 2.0, 2.5])
    assert (np.abs(course.q) + np.abs(course.v) * half < limits).all()
    assert (np.abs(course.v) + np.abs(course.a) * half < 4.0).all() and (np.abs(course.a) < 10.0).all()
    plant = small_arm.plant_of(examples / "arm.urdf")
    plant.Finalize()
    torque = small_arm.inverse_dynamics(plant, small_arm.Moves(course.time, course.q, course.v, course.a))
    assert (np.abs(torque) < np.array([60.0, 60.0, 30.0])).all()


def test_the_file_is_one_motion_from_rest_to_rest(motion: Path) -> None:
    course = course_of(motion)
    assert motion.read_text().startswith("t,q_0,q_1,q_2,v_0,v_1,v_2,a_0,a_1,a_2\n")
    assert (course.time[0], course.time[-1], len(course.time)) == (0.0, 20.0, 10001)
    for values in (course.v, course.a):
        np.testing.assert_allclose(values[[0, -1]], 0.0, atol=1e-8)
    np.testing.assert_allclose(course.q[0], course.q[-1], atol=1e-8)
    for values, rate in ((course.q, course.v), (course.v, course.a)):
        np.testing.assert_allclose(np.gradient(values, course.time, axis=0)[1:-1], rate[1:-1], atol=2e-3)


def test_the_file_with_torques_beside_it_is_a_log(motion: Path, examples: Path, tmp_path: Path) -> None:
    header, *rows = motion.read_text().splitlines()
    lines = [f"{header},tau_0,tau_1,tau_2", *(f"{row},1,2,3" for row in rows)]
    (tmp_path / "log.csv").write_text("\n".join(lines))
    model = load_arm_model(examples / "arm.yaml")
    log = load_joint_log(tmp_path / "log.csv", model, ("base", "shoulder", "elbow"))
    np.testing.assert_array_equal(log.q, course_of(motion).q)


def test_it_is_better_conditioned_than_the_example_and_tells_every_inertia_better(motion: Path, examples: Path) -> None:
    model = load_arm_model(examples / "arm.yaml")
    arm = ArmPlant.of(model)
    structure = BaseStructure.of(arm, arm.inertias().ravel())
    recorded = motion_told(structure, load_joint_log(examples / "arm_log.csv", model, arm.joints), 8.0)
    found = motion_told(structure, course_of(motion), 8.0)
    assert found.condition < 0.7 * recorded.condition
    pairs = [(a.deviation, b.deviation) for a, b in zip(found.structural, recorded.structural, strict=True)]
    better = [a is not None and b is not None and a < b for a, b in pairs]
    assert sum(better) >= 12 and all(found is not None for found, _ in pairs)


def test_a_log_of_it_tells_inertias_that_the_example_s_motion_does_not(motion: Path, examples: Path) -> None:
    """A forearm whose Ixx is another by twice the example's deviation: simulated by Drake, rubbing, with noise.

    Told is what is off by more than three standard deviations; all numbers are fitted beside friction.
    """
    model = load_arm_model(examples / "arm.yaml")
    arm = ArmPlant.of(model)
    structure = BaseStructure.of(arm, arm.inertias().ravel())
    log = load_joint_log(examples / "arm_log.csv", model, arm.joints)
    (which,) = [i for i, p in enumerate(motion_told(structure, log, 8.0).structural) if "forearm.Ixx" in p.terms]
    (deviation,) = [motion_told(structure, log, 8.0).structural[which].deviation]
    assert deviation is not None
    off = {}
    for name, one in (("planned", course_of(motion)), ("example", log)):
        blank = JointLog(name, one.time, one.q, np.zeros_like(one.q), "")
        asked = ArmMotion.of(blank, 8.0)
        plant = small_arm.plant_of(examples / "arm.urdf")
        plant.Finalize()
        rigid = small_arm.inverse_dynamics(plant, small_arm.Moves(asked.time, asked.q, asked.v, asked.a))
        more = np.zeros(30)
        more[24] = 2.0 * deviation  # Ixx of the third link
        extra = regressor(arm, asked.q, asked.v, asked.a).inertial @ more
        white = asked.filtered(np.random.default_rng(3).standard_normal(rigid.shape))
        noise = NOISE * structure.torque
        torque = rigid + extra + 1.5 * np.sign(asked.v) + 0.8 * asked.v + noise * white / white.std(axis=0)
        part = asked.thinning
        rows = structure.regressor(asked.q[part], asked.v[part], asked.a[part])
        counted = np.abs(asked.v[part]) >= 0.01 * np.abs(asked.v[part]).max(axis=0)
        columns = np.column_stack([rows.base, rows.friction])
        found = np.linalg.lstsq(columns, (torque[part] / structure.torque)[counted], rcond=None)[0]
        step = float(found[which] * structure.size[which] - (structure.combinations @ structure.nominal)[which])
        attained = motion_told(structure, one, 8.0).structural[which].deviation
        assert attained is not None and abs(step - more[24]) < 3.5 * attained
        off[name] = abs(step) > 3.0 * attained and 3.0 * attained < more[24]
    assert off == {"planned": True, "example": False}


def test_links_are_kept_apart(tmp_path: Path) -> None:
    """The balls' centres are 2 L |cos(q1 / 2)| apart, by two sides of one length."""
    course, limits, _ = planned(two_links(tmp_path, balls=True))
    apart = 2.0 * REACH * np.abs(np.cos(0.5 * course.q[:, 1]))
    assert 2.0 * REACH * np.cos(0.5 * limits.high[1]) < 2.0 * BALL
    assert apart.min() >= 2.0 * BALL + CLEARANCE_M - 1e-9
    free, _, _ = planned(two_links(tmp_path))
    assert (2.0 * REACH * np.abs(np.cos(0.5 * free.q[:, 1]))).min() < 2.0 * BALL


@pytest.mark.parametrize("load_kg", [0.0, 1.0])
def test_efforts_are_kept(load_kg: float, tmp_path: Path) -> None:
    """Held straight the arm would need 2.0 * 9.81 * 0.2 + 1.5 * 9.81 * 0.6 = 12.8 N m and more, a payload apart."""
    bare = two_links(tmp_path, effort="12")
    effect = JointEffect("payload", "l1", {"m": load_kg, "cx": 0.35, "cy": 0.0, "cz": 0.0})
    model = replace(bare, effects=(effect,)) if load_kg else bare
    course, limits, _ = planned(model)
    assert (limits.effort == 12.0).all()
    plant = small_arm.plant_of(model.robot)
    if load_kg:
        small_arm.with_point(plant, "l1", load_kg, (0.35, 0.0, 0.0))
    plant.Finalize()
    torque = small_arm.inverse_dynamics(plant, small_arm.Moves(course.time, course.q, course.v, course.a))
    assert np.abs(torque).max() <= 9.0 + 1e-6


def test_the_same_seed_plans_the_same_motion(tmp_path: Path) -> None:
    model = two_links(tmp_path)
    (first, _, _), (again, _, _), (other, _, _) = planned(model), planned(model), planned(model, seed=1)
    np.testing.assert_array_equal(first.q, again.q)
    assert np.abs(first.q - other.q).max() > 0.1


def test_bases_are_derivatives_of_one_another_and_rest_at_both_ends() -> None:
    time = np.linspace(0.0, 7.0, 7001)
    q, v, a = fourier_bases(time, 7.0, 4)
    assert q.shape == (7001, 6)
    np.testing.assert_allclose(np.gradient(q, time, axis=0)[1:-1], v[1:-1], atol=1e-4)
    np.testing.assert_allclose(np.gradient(v, time, axis=0)[1:-1], a[1:-1], atol=1e-4)
    for values in (q, v, a):
        np.testing.assert_allclose(values[[0, -1]], 0.0, atol=1e-9)


def test_a_limit_that_is_nowhere_is_asked_for(tmp_path: Path) -> None:
    model = two_links(tmp_path)
    arm = ArmPlant.of(model)
    with pytest.raises(BadInput, match=r"no acceleration limit of j0, expected one, or the option --acceleration"):
        JointLimits.of(arm, model)
    with pytest.raises(BadInput, match=r"--velocity: found 3 numbers, expected 1, or 2"):
        JointLimits.of(arm, model, velocity=[1.0, 2.0, 3.0], acceleration=[1.0])
    with pytest.raises(BadInput, match=r"--acceleration: found -1, expected finite numbers above 0"):
        JointLimits.of(arm, model, acceleration=[-1.0])
    stricter = JointLimits.of(arm, model, position=[1.0, 9.0], velocity=[2.0], acceleration=[5.0, 6.0])
    np.testing.assert_array_equal(stricter.high, [1.0, 3.0])
    np.testing.assert_array_equal((stricter.speed, stricter.acceleration), [[2.0, 2.0], [5.0, 6.0]])


REFUSED = {
    "an ending": (("--out", "motion.npz"), "found the ending '.npz', expected .csv"),
    "one harmonic": (("--out", "m.csv", "--harmonics", "1"), "--harmonics: found 1, expected 2 or more"),
    "no rate": (("--out", "m.csv", "--rate", "nan"), "--rate: found nan Hz, expected 32 Hz or more"),
    "too many rows": (("--out", "m.csv", "--seconds", "1e9"), "found 5e+11 rows, expected 3e+06 at most"),
    "another model": (
        ("--out", "m.csv", "--model", "{examples}/servo.yaml"),
        "found no model of an arm, expected struc",
    ),
    "no model": (("--out", "m.csv", "--model", "none.yaml"), "none.yaml: found no such file"),
    "no acceleration": (("--out", "m.csv"), "found no acceleration limit of base"),
    "too short": (
        ("--out", "m.csv", "--acceleration", "9", "--seconds", "1"),
        "--seconds: found 1, expected 1.25 or more",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_planned_is_told_in_one_line(
    what: str, examples: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    options, told = REFUSED[what]
    monkeypatch.chdir(tmp_path)
    arguments = ["--model", str(examples / "arm.yaml"), *(option.format(examples=examples) for option in options)]
    assert main(["excite", *arguments]) == 2
    error = capfd.readouterr().err
    assert told in error and error.count("\n") == 1 and not list(tmp_path.iterdir())


def test_an_arm_that_cannot_hold_itself_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="more effort than the drives have"):
        planned(two_links(tmp_path, effort="0.01"))
