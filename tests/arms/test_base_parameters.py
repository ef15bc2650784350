"""Base parameters: their number and regrouping in closed form, the torque they ask for, and what a motion attains."""

from pathlib import Path

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.base_parameters import BaseParameters, BaseStructure, grouped
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.regressor import regressor

DOWN = (0.0, 0.0, -9.81)
PLANAR = ("0 0 1", "0 0 1")
UR = ("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "0 1 0")
PANDA = ("0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
REACH = 0.4


def chain(folder: Path, axes: tuple[str, ...], gravity: tuple[float, float, float] = DOWN) -> ArmPlant:
    """Turning joints, each `REACH` along x and a bit aside from the one before; links of some shape."""
    rng, parts, before = np.random.default_rng(5), ['<link name="foot"/>'], "foot"
    for i, axis in enumerate(axes):
        centre = tuple(float(x) for x in rng.uniform(-0.1, 0.2, 3))
        parts.append(small_arm.link(f"l{i}", float(rng.uniform(1, 4)), centre, (0.03, 0.04, 0.05, 0.001, 0.002, 0.003)))
        at = "0 0 0" if i == 0 else f"{REACH} 0 0" if axes == PLANAR else f"{REACH} {0.1 * (i % 2)} 0.12"
        parts.append(small_arm.joint(f"j{i}", before, f"l{i}", at, axis))
        before = f"l{i}"
    path = folder / "chain.urdf"
    path.write_text(small_arm.robot(*parts))
    return ArmPlant.of(ArmModel(path, gravity=gravity))


def structure(arm: ArmPlant) -> BaseStructure:
    return BaseStructure.of(arm, arm.inertias().ravel())


def told(arm: ArmPlant, moves: small_arm.Moves, noise: float = 0.01) -> BaseParameters:
    log = JointLog("log", moves.time, moves.q, np.zeros_like(moves.q), "tau")
    return structure(arm).told([ArmMotion.of(log, 8.0)], np.full(moves.q.shape[1], noise))


@pytest.mark.parametrize(
    ("axes", "gravity", "number"),
    [
        (PLANAR, DOWN, 4),
        (PLANAR, (0.0, -9.81, 0.0), 6),
        (UR[:3], DOWN, 15),
        (UR, DOWN, 36),
        (UR, (3.0, 0.0, -9.0), 38),
        (PANDA, DOWN, 43),
    ],
)
def test_there_are_as_many_as_the_literature_counts(
    axes: tuple[str, ...], gravity: tuple[float, float, float], number: int, tmp_path: Path
) -> None:
    """7 N - 4 b, and 2 less where the first axis is upright: of N turning joints, whose axes are parallel or across, b
    are parallel to the first. Mayeda, Yoshida and Osuka 1990, IEEE Trans. Robotics and Automation 6(3). 36 is also
    the count of Gautier and Khalil 1990 (same issue) for arms of six joints, 43 that of Gaz et al. 2019, IEEE Robotics
    and Automation Letters 4(4), for the Panda.
    """
    parallel = next((i for i, axis in enumerate(axes) if axis != axes[0]), len(axes))
    upright = gravity == DOWN
    assert number == 7 * len(axes) - 4 * parallel - 2 * upright
    assert len(structure(chain(tmp_path, axes, gravity)).combinations) == number


def test_two_parallel_joints_have_the_base_parameters_of_the_closed_form(tmp_path: Path) -> None:
    """Without gravity: Izz of both, of the near one with what the far one adds, and mc of the far one."""
    arm = chain(tmp_path, PLANAR)
    (izz, x, y, far) = structure(arm).named(structure(arm).combinations)
    near_numbers, far_numbers = arm.inertias()
    assert izz.terms == pytest.approx({"l0.Izz": 1.0, "l1.m": REACH**2}, rel=1e-6)
    assert [set(one.terms) for one in (x, y, far)] == [{"l1.mcx"}, {"l1.mcy"}, {"l1.Izz"}]
    assert izz.value == pytest.approx(near_numbers[6] + REACH**2 * far_numbers[0], rel=1e-9)
    assert izz.name == "Izz of l0 + 0.16 m of l1" and izz.said(1) == "Izz of l0 and 1 more"


@pytest.mark.parametrize("axes", [PLANAR, UR, PANDA], ids=["two", "six", "seven"])
def test_base_parameters_ask_for_the_torque_of_all_numbers(axes: tuple[str, ...], tmp_path: Path) -> None:
    arm = chain(tmp_path, axes)
    rng = np.random.default_rng(8)
    q, v, a = (size * rng.uniform(-1.0, 1.0, (50, len(axes))) for size in (3.0, 2.0, 5.0))
    whole, own = regressor(arm, q, v, a).inertial, structure(arm)
    numbers = arm.inertias().ravel() + rng.uniform(-1.0, 1.0, 10 * len(axes))
    np.testing.assert_allclose(
        whole[:, :, list(own.independent)] @ (own.combinations @ numbers), whole @ numbers, atol=1e-9
    )


def test_columns_that_are_sums_of_others_are_regrouped() -> None:
    rng = np.random.default_rng(0)
    first = rng.standard_normal((30, 3))
    matrix = np.column_stack([first[:, 0], first[:, 1], 2.0 * first[:, 0] - 3.0 * first[:, 1], first[:, 2]])
    combinations, independent = grouped(matrix, 1e-9, np.array([1.0, 1.0, 0.01, 1.0]))
    assert independent == [0, 1, 3]
    np.testing.assert_allclose(combinations, [[1, 0, 2, 0], [0, 1, -3, 0], [0, 0, 0, 1]], atol=1e-12)


def test_a_joint_that_stands_still_leaves_base_parameters_to_another_motion(tmp_path: Path) -> None:
    """Of two parallel joints the first moves alone: one number remains, the whole inertia about it."""
    arm, moves = chain(tmp_path, PLANAR), small_arm.sines(2, 1)
    held = small_arm.Moves(moves.time, np.where([True, False], moves.q, 0.3), moves.v * [1, 0], moves.a * [1, 0])
    found = told(arm, held)
    assert (len(found.parameters), len(found.structural), found.condition) == (1, 4, np.inf)
    assert found.untold == found.structural and found.well_told == ()
    (whole,) = found.parameters
    expected = {"l0.Izz": 1, "l1.Izz": 1, "l1.m": REACH**2}
    expected |= {"l1.mcx": 2 * REACH * np.cos(0.3), "l1.mcy": -2 * REACH * np.sin(0.3)}
    assert whole.terms == pytest.approx(expected, rel=1e-3)
    both = told(arm, moves)
    assert len(both.parameters) == 4 and not both.untold and np.isfinite(both.condition)


def test_what_a_slow_motion_tells_barely_is_said(tmp_path: Path) -> None:
    arm, moves = chain(tmp_path, UR[:3]), small_arm.sines(3, 2)
    assert not any(one.barely for one in told(arm, moves).structural)
    slow = small_arm.Moves(moves.time, 0.02 * moves.q, 0.02 * moves.v, 0.02 * moves.a)
    found = told(arm, slow, noise=0.1)
    assert any(one.barely for one in found.parameters) and len(found.parameters) < len(found.structural)


def test_deviations_are_those_that_repeated_fits_show(tmp_path: Path) -> None:
    """Noise within the band, drawn again and again; fitted by least squares beside friction of every joint."""
    arm, moves, rng = chain(tmp_path, UR[:3]), small_arm.sines(3, 4), np.random.default_rng(6)
    own, noise = structure(arm), 0.05
    log = JointLog("log", moves.time, moves.q, np.zeros_like(moves.q), "tau")
    motion = ArmMotion.of(log, 8.0)
    expected = [one.deviation for one in own.told([motion], np.full(3, noise)).structural]
    q, v, a = (x[motion.thinning] for x in (motion.q, motion.v, motion.a))
    rows = own.regressor(q, v, a)
    columns = np.column_stack([rows.base, rows.friction]) * own.torque[rows.joint][:, None]
    inverse = np.linalg.pinv(columns)[: len(expected)]
    counted = np.abs(v) >= 0.01 * np.abs(motion.v).max(axis=0)
    fits = []
    for _ in range(200):
        white = motion.filtered(rng.standard_normal(motion.q.shape))
        drawn = (noise * white / white.std(axis=0))[motion.thinning]
        fits.append(inverse @ drawn[counted] * own.size)
    np.testing.assert_allclose(np.std(fits, axis=0), np.array(expected), rtol=0.2)
