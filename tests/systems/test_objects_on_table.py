"""Several objects on a table."""

import numpy as np
import pytest
from driven import driven
from pydrake.systems.framework import System

from mmt_drake.errors import BadInput
from mmt_drake.model import flexible_box as box
from mmt_drake.model import grasped_box, on_table
from mmt_drake.model.body import VELOCITY
from mmt_drake.model.energy import stored_energy
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model.structure import Friction
from mmt_drake.motion.analytic import AnalyticMotion, step
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.objects_on_table import ObjectsOnTable
from mmt_drake.systems.on_table import OnTable
from mmt_drake.systems.scripted_operator import ScriptedOperator

SMOOTH = FlexibleBoxModel(BoxParameters(m=1.0, k1=0.0, k2=500.0, b1=0.0, b2=60.0))
RUBBING = FlexibleBoxModel(
    BoxParameters(m=0.5, k1=0.0, k2=500.0, b1=2.0, b2=20.0), friction=Friction(Fs=0.6, Fd=0.5, v_d=0.002)
)


def one_way(origin: tuple[float, float, float], *ways: tuple[int, float, float, float]) -> AnalyticMotion:
    """Steps (axis, start, end, displacement); they are gone back after 8 s."""
    back = [step(axis, 8.0, 9.0, -displacement) for axis, _, _, displacement in ways]
    return AnalyticMotion(origin, steps=[*(step(*way) for way in ways), *back], cycle=10.0)


PUSH = one_way((0.0, 0.0, 0.01), (2, 0.0, 0.3, -0.015), (0, 0.4, 1.4, 0.1))


def thing(
    x: float, model: FlexibleBoxModel = SMOOTH, y: float = 0.0, top: float = 0.0, round_: bool = False
) -> OnTable:
    return OnTable(model, (x, y), (0.06, 0.06, 0.05), round_, top)


def logged(system: System, names: tuple[str, ...], motion: AnalyticMotion, seconds: float) -> dict[str, Array]:
    return driven(system, names, seconds, motion=ScriptedOperator(motion))[0]


def free(n: int) -> tuple[Array, Array, Array]:
    """States, rows and kernel vectors of cubes without friction on a line, 1 mm apart, nobody touching them."""
    things = [thing(0.061 * i) for i in range(n)]
    rows = np.array([each.row() for each in things])
    p = np.array([each.model.kernel_vector() for each in things])
    states = np.zeros((n, box.STATE_SIZE))
    on_table.begin(states, 0.0, np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), rows, p, np.zeros(6))
    return states, rows, p


def energy_of(states: Array, rows: Array, p: Array) -> float:
    """What all objects and their collisions hold in store [J]."""
    alone = sum(stored_energy(state, own) for state, own in zip(states, p, strict=True))
    deep = (on_table.overlap(states, rows, i, j)[0] for i in range(len(states)) for j in range(i))
    return alone + sum(0.5 * 4.5e4 * max(each, 0.0) ** 2 for each in deep)


def run_free(states: Array, rows: Array, p: Array, seconds: float, h: float = 1e-3) -> list[float]:
    energies = []
    for tick in range(1, round(seconds / h) + 1):
        motion, scratch = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), np.zeros((len(states), 2))
        grasp, hung = np.zeros(grasped_box.GRASP_SIZE), np.zeros((len(states), grasped_box.HUNG))
        given = states, grasp, on_table.NONE, tick * h, motion, 0.0, rows, p, hung, 4.5e4, np.zeros(6), scratch
        on_table.advance(*given)
        energies.append(energy_of(states, rows, p))
    return energies


def test_an_object_alone_is_that_of_flexible_box_bit_for_bit() -> None:
    names = ("measurement", "force", "in_contact", "body")
    alone = logged(FlexibleBox(RUBBING), names, PUSH, 2.0)
    among = logged(ObjectsOnTable([thing(0.0, RUBBING), thing(0.0, y=0.3)]), names, PUSH, 2.0)
    assert np.abs(alone["force"]).max() > 0.5
    for name in names:
        np.testing.assert_array_equal(alone[name], among[name])


def test_the_tip_touches_the_object_whose_top_it_is_below() -> None:
    motion = one_way((0.3, 0.0, 0.05), (2, 0.0, 0.5, -0.025))
    low, high = thing(0.0), thing(0.3, top=0.03)
    seen = logged(ObjectsOnTable([low, high]), ("touched", "force", "measurement"), motion, 1.0)
    below = seen["measurement"][:, 2] < 0.03
    np.testing.assert_array_equal(seen["touched"][:, 0], np.where(below, 2.0, 0.0))
    assert seen["force"][-1, 2] == pytest.approx(SMOOTH.normal.k * 0.005, rel=1e-3)  # at rest 5 mm below its own top


def test_a_tip_that_comes_from_beside_below_the_top_touches_nothing() -> None:
    motion = one_way((0.1, 0.0, -0.01), (0, 0.0, 0.5, -0.1))
    seen = logged(ObjectsOnTable([thing(0.0)]), ("touched", "force"), motion, 1.0)
    assert not seen["touched"].any() and not seen["force"].any()


def test_a_collision_keeps_momentum_and_never_makes_energy() -> None:
    states, rows, p = free(2)
    states[0, box.BODY + VELOCITY] = 0.3
    before = energy_of(states, rows, p)
    energies = run_free(states, rows, p, 0.3)
    velocity = states[:, box.BODY + VELOCITY]
    assert velocity.sum() == pytest.approx(0.3, abs=1e-9)
    assert velocity[1] > 0.1 and velocity[0] <= velocity[1]
    assert max(energies) <= before + 1e-9
    assert energies[-1] < 0.9 * before


@pytest.mark.parametrize("speed", [0.02, 0.3, 2.0])
def test_a_row_of_bodies_never_gains_energy_whatever_hits_it(speed: float) -> None:
    states, rows, p = free(4)
    p[1, 0] *= 0.1  # of another mass
    states[0, box.BODY + VELOCITY] = speed
    states[3, box.BODY + VELOCITY] = -0.5 * speed
    first = energy_of(states, rows, p)
    energies = run_free(states, rows, p, 0.5)
    assert max(energies) <= first * (1.0 + 1e-9)


def test_cylinders_push_each_other_along_the_line_of_their_axes() -> None:
    things = [thing(0.0, round_=True), thing(0.03, y=0.045, round_=True)]
    rows = np.array([each.row() for each in things])
    deep, x, y = on_table.overlap(np.zeros((2, box.STATE_SIZE)), rows, 0, 1)
    assert deep == pytest.approx(0.06 - np.hypot(0.03, 0.045))
    np.testing.assert_allclose((x, y), np.array([0.03, 0.045]) / np.hypot(0.03, 0.045))


def test_a_box_pushes_a_cylinder_from_its_nearest_point_and_both_alike() -> None:
    rows = np.array([thing(0.0).row(), thing(0.05, y=0.05, round_=True).row()])
    states = np.zeros((2, box.STATE_SIZE))
    deep, x, y = on_table.overlap(states, rows, 0, 1)
    assert deep == pytest.approx(0.03 - np.hypot(0.02, 0.02))  # from the box's corner
    assert on_table.overlap(states, rows, 1, 0) == pytest.approx((deep, -x, -y))


def test_a_pushed_object_pushes_another_and_friction_holds_that_until_the_push_exceeds_it() -> None:
    system = ObjectsOnTable([thing(0.0, RUBBING), thing(0.1, RUBBING)])
    seen = logged(system, ("bodies", "force"), PUSH, 3.0)
    first, second = seen["bodies"][:, 0], seen["bodies"][:, 5]
    assert second[np.searchsorted(first, 0.039)] == 0.0  # 40 mm are between them
    assert second[-1] == pytest.approx(first[-1] - 0.04, abs=2e-3)
    assert seen["bodies"][-1, [2, 7]] == pytest.approx(0.0, abs=1e-6)


def test_the_work_of_the_tip_covers_all_that_the_objects_hold() -> None:
    things = [thing(0.0), thing(0.07), thing(0.14, RUBBING)]
    seen = logged(ObjectsOnTable(things), ("bodies", "force", "measurement"), PUSH, 3.0)
    force, velocity = seen["force"], seen["measurement"][:, 3:6]
    power = -(force * velocity).sum(axis=1)
    work = np.concatenate([[0.0], np.cumsum(0.5e-3 * (power[1:] + power[:-1]))])
    masses = np.array([each.model.parameters.m for each in things])
    moving = 0.5 * sum(m * (seen["bodies"][:, 5 * i + 2 : 5 * i + 4] ** 2).sum(axis=1) for i, m in enumerate(masses))
    assert (moving - work).max() <= 1e-5


def test_objects_in_one_place_and_none_at_all_are_refused() -> None:
    with pytest.raises(BadInput, match="in one place"):
        ObjectsOnTable([thing(0.0), thing(0.03)])
    with pytest.raises(BadInput, match="none"):
        ObjectsOnTable([])
