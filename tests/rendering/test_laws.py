"""Named laws in the rendered object: the force that they make, and how they enter, change and leave."""

import numpy as np
import pytest
from test_updates import STEP, moving, wandering

from mmt_drake.model import flexible_box as box
from mmt_drake.model.body import AXIS_SIZE
from mmt_drake.model.body import MEMORY as OF_BODY
from mmt_drake.model.held_body import HELD_ANCHOR, HELD_ENTRY, HELD_SEEN, HELD_SIZE, NO_REPORT
from mmt_drake.model.law_table import ENTRY, HEAD, MEMORY, SHARE, VALUES
from mmt_drake.model.message_layout import EFFECTS
from mmt_drake.model.parameters import KERNEL_SIZE, LAWS, BoxParameters, FlexibleBoxModel
from mmt_drake.model.theta import write_theta
from mmt_drake.model_files import with_effects
from mmt_drake.model_message import UNKNOWN_THETA, VERSION, ModelMessage, ToldEffect
from mmt_drake.numeric.vectors import UP
from mmt_drake.rendering.impedance import MEMORY_SIZE, NO_PLANE, PORT_SIZES, READOUT_SIZES, drop_laws, render_on
from mmt_drake.rendering.laws import align, felt_by_bytes
from mmt_drake.rendering.status import APPROACHING, NOT_FELT, RENDERING, TOO_FAST, UNKNOWN_MODEL
from mmt_drake.rendering.updates import AtOnce, Blended, EnergyPermitting, RateLimited, rule
from mmt_drake.told_laws import NO_LAWS, VECTOR_SIZE, put_laws, told_by

BOX = FlexibleBoxModel(BoxParameters(m=0.8, k1=20.0, b1=9.0, Fc=0.2))
AT = sum(PORT_SIZES.values())
CUBIC = ("nonlinear_stiffness", {"k3": 3e6})
LOOP = ("hysteresis", {"alpha": 300.0, "beta": 150.0})
LATE = ("viscoelastic_relaxation", {"k_maxwell": 300.0, "tau": 0.1})
PRESSED = ("normal_nonlinear_stiffness", {"k3": 2e7})
YIELDS = ("normal_viscoelastic_relaxation", {"k_maxwell": 300.0, "tau": 0.1})
SQUEEZED = ("normal_hunt_crossley_damping", {"lambda": 4000.0})
ROUND = ("normal_hysteresis", {"alpha": 300.0, "beta": 150.0})
WALL = ("end_stop", {"position": 0.003, "stiffness": 900.0})
BRISTLES = ("presliding_friction", {"sigma0": 600.0, "sigma1": 0.0, "Fs": 0.5, "v_s": 0.01})
SLACK = ("contact_gap", {"gap": 0.004})
ONE_WAY = ("asymmetric_friction", {"Fc_plus": 0.6, "Fc_minus": 0.1})
BALL = ("power_law_stiffness", {"k": 8000.0, "p": 1.5})


def told(number, *effects):
    """(TOLD_SIZE,) of a message of this number."""
    return told_by(ModelMessage(UNKNOWN_THETA, effects=tuple(ToldEffect(*effect) for effect in effects), number=number))


def pushed(n, along=0.01):
    """(n, 6) pressed in, moved along y within 0.2 s [m], and held there."""
    hold = np.tile([0.0, along, -0.004, 0.0, 0.0, 0.0], (n, 1))
    hold[:200, 1], hold[:200, 4] = np.linspace(0.0, along, 200), along / 199 / STEP
    return hold


class Felt:
    """(n, ...) of every tick: force, status, jump, stored energy; `laws`: of each tick what is told."""

    def __init__(self, policy, motion, laws, theta=None, contact=None, plane=None, world=1.0, held=None):
        n = len(motion)
        theta = np.broadcast_to(BOX.theta() if theta is None else theta, (n, 10))
        contact = (motion[:, 2] < 0.0).astype(float) if contact is None else contact
        held = np.broadcast_to(NO_REPORT, (n, HELD_SIZE)) if held is None else held
        out, memory = np.zeros((n, sum(READOUT_SIZES))), np.zeros(MEMORY_SIZE)
        fixed = rule(policy, STEP, STEP * (1 + 1e-9))
        for k in range(n):
            where = NO_PLANE if plane is None else plane[k]
            seen = motion[k].copy(), motion[k].copy(), theta[k].copy()
            given = (*seen, 1.0, contact[k], fixed, False, held[k].copy(), where, world, np.inf)
            render_on(memory, k * STEP, *given, laws if isinstance(laws, np.ndarray) else laws[k], out[k])
            memory = out[k, AT:].copy()
        self.position, self.memory = motion[:, :3], memory
        self.force, self.status, self.jump, self.stored = out[:, :3], out[:, 3], out[:, 4:7], out[:, 7]

    def balance(self):
        """What the hand has put in less what is stored [J], each force being held until the next."""
        steps = -np.sum(self.force[:-1] * np.diff(self.position, axis=0), axis=1)
        return np.append(0.0, np.cumsum(steps)) - self.stored


@pytest.mark.parametrize(
    "effects",
    [
        *((CUBIC,), (LOOP, CUBIC), (LATE, WALL), (BRISTLES,)),
        *((PRESSED,), (YIELDS, LATE), (SQUEEZED, CUBIC), (ROUND, LOOP), (PRESSED, ROUND)),
        *((SLACK,), (CUBIC, SLACK), (SLACK, PRESSED), (ONE_WAY,), (BALL,), (BALL, CUBIC)),
    ],
)
def test_the_rendered_force_is_that_of_the_object_with_these_laws(effects):
    motion = moving(3000)
    model = with_effects(BOX, [{"name": name, "parameters": values} for name, values in effects], "test")
    force, body = np.empty((3000, 3)), np.empty((3000, 4))
    contact = (motion[:, 2] < 0.0).astype(float)
    time, position, velocity = np.arange(3000) * STEP, motion[:, :3].copy(), motion[:, 3:].copy()
    box.replay(time, position, velocity, contact, model.kernel_vector(), force, body)
    found = Felt(AtOnce(), motion, told(1, *effects))
    bare = Felt(AtOnce(), motion, NO_LAWS)
    # In the first tick the laws act as soon as they are told; what they would have remembered of it they have not.
    np.testing.assert_allclose(found.force, force, atol=1e-6 * np.abs(force).max())
    assert np.abs(bare.force - force).max() > 5e-3 * np.abs(force).max()
    assert np.all(found.status[1:] == RENDERING)


def test_a_message_without_laws_changes_no_bit():
    motion, theta = moving(1500), wandering(1500)
    for policy in (AtOnce(), EnergyPermitting(), Blended()):
        bare, empty = (Felt(policy, motion, laws, theta) for laws in (NO_LAWS, told(1)))
        assert np.array_equal(bare.force, empty.force) and np.array_equal(bare.stored, empty.stored)


def test_rate_limited_laws_enter_change_and_leave_no_faster_and_arrive():
    stages = [told(1), told(2, CUBIC), told(3, ("nonlinear_stiffness", {"k3": 1e6})), told(4, WALL), told(5)]
    laws = [stages[min(k // 600, 4)] for k in range(3000)]
    stiff = FlexibleBoxModel(BoxParameters(m=1.0, k1=3000.0, b1=50.0)).theta()
    found = Felt(RateLimited(rate=20.0), pushed(3000), laws, stiff)
    assert np.linalg.norm(found.jump, axis=1).max() <= 20.0 * STEP * (1 + 1e-9)
    ends = [found.force[600 * (i + 1) - 1, 1] for i in range(5)]
    assert ends[1] < ends[2] - 0.1 and ends[2] < ends[0] - 0.1  # it pushes back harder with more of it
    assert ends[4] == pytest.approx(ends[0], abs=1e-6)
    assert found.status[601] == APPROACHING and np.all(found.status[[1199, 1799, 2399, 2999]] == RENDERING)


@pytest.mark.parametrize("policy", [RateLimited(20.0), EnergyPermitting(rate=20.0)], ids=["rate", "energy"])
def test_a_law_that_gets_other_numbers_while_it_enters_changes_the_force_no_faster(policy):
    # Its share grows and its number falls: what they make together first grows, and then falls.
    stages = [NO_LAWS, told(1, CUBIC), told(2, ("nonlinear_stiffness", {"k3": 2e5}))]
    laws = [stages[(k >= 1500) + (k >= 1510)] for k in range(3000)]
    firm = FlexibleBoxModel(BoxParameters(m=1.0, k1=3000.0, k2=300.0, b1=50.0)).theta()
    found = Felt(policy, pushed(3000), laws, firm)
    assert np.linalg.norm(found.jump, axis=1).max() <= 20.0 * STEP * (1 + 1e-8)
    assert found.force[1509, 1] < found.force[1499, 1] - 0.1 and found.status[2999] == RENDERING
    assert found.force[2999, 1] == pytest.approx(Felt(AtOnce(), pushed(3000), stages[2], firm).force[2999, 1], abs=1e-6)
    assert isinstance(policy, RateLimited) or found.balance().min() > -1e-5


@pytest.mark.parametrize("across", [0.0, 0.01])
@pytest.mark.parametrize("policy", [RateLimited(20.0), EnergyPermitting(rate=20.0)], ids=["rate", "energy"])
def test_a_body_that_is_brought_back_under_a_law_that_bends_changes_the_force_no_faster(policy, across):
    sticky = FlexibleBoxModel(BoxParameters(m=1.0, k1=0.0, k2=100.0, b1=20.0, Fc=50.0)).theta()
    motion, held = pushed(3000), np.zeros((3000, HELD_SIZE))
    motion[:, [0, 3]] = across / 0.01 * motion[:, [1, 4]]  # the law knows both axes
    held[1500:, 3], held[1500:, 5] = 0.01, 1.5  # all of the way along y, from where the cubic spring is steepest
    found = Felt(policy, motion, told(1, CUBIC), sticky, held=held)
    assert found.force[1499, 1] < -3.0 and abs(found.force[-1, 1]) < 0.05
    assert np.linalg.norm(found.jump, axis=1).max() <= 20.0 * STEP * (1 + 1e-8)


@pytest.mark.parametrize("policy", [AtOnce(), EnergyPermitting(rate=20.0)], ids=["at once", "energy"])
def test_a_wall_is_met_where_the_report_counts_it_though_the_body_slides(policy):
    loose = FlexibleBoxModel(BoxParameters(m=1.0, k1=0.0, k2=500.0, b1=20.0, Fc=0.2)).theta()
    motion, held, off = pushed(3000, along=0.02), np.zeros((3000, HELD_SIZE)), 0.002
    name, wall = WALL
    held[50:, HELD_ENTRY + HELD_ANCHOR], held[50:, HELD_SEEN] = -off, 9.0
    nearer = name, {**wall, "position": wall["position"] - off}
    found, there = Felt(policy, motion, told(1, WALL), loose, held=held), Felt(policy, motion, told(1, nearer), loose)
    plain = Felt(policy, motion, told(1, WALL), loose)
    assert np.abs(plain.force[-1] - there.force[-1]).max() > 0.1
    np.testing.assert_allclose(found.force[-1], there.force[-1], atol=1e-3)
    assert isinstance(policy, AtOnce) or found.balance().min() > -1e-5
    held[50:, HELD_SEEN] = 0.0  # of a contact before
    np.testing.assert_array_equal(Felt(policy, motion, told(1, WALL), loose, held=held).force, plain.force)


@pytest.mark.parametrize("seed", range(4))
def test_as_energy_permits_laws_that_come_and_go_give_nothing_that_was_not_put_in(seed):
    motion, random = moving(6000, seed), np.random.default_rng(seed)
    sets = [(CUBIC,), (LOOP, CUBIC), (WALL,), (LATE,), (), (BRISTLES, CUBIC), (("nonlinear_stiffness", {"k3": 2e7}),)]
    sets += [(PRESSED,), (YIELDS, LATE), (SQUEEZED, CUBIC), (ROUND,), (CUBIC, PRESSED), (YIELDS, ROUND)]
    sets += [(SLACK,), (SLACK, CUBIC), (PRESSED, SLACK), (ONE_WAY, SLACK), (BALL, CUBIC), (BALL,)]
    stages = [told(i + 1, *sets[random.integers(len(sets))]) for i in range(60)]
    laws = [stages[k // 100] for k in range(6000)]
    contact = (motion[:, 2] < 0.0).astype(float)
    for flag in (contact, np.append(np.zeros(200), contact[:-200])):
        found = Felt(EnergyPermitting(0.02), motion, laws, wandering(6000, seed), contact=flag)
        assert np.abs(found.force).max() > 1.0 and np.isfinite(found.force).all()
        assert found.balance().min() > -1e-5


@pytest.mark.parametrize("policy", [RateLimited(20.0), EnergyPermitting(rate=20.0)], ids=["rate", "energy"])
def test_a_clearance_opens_and_closes_no_faster_than_a_law_enters(policy):
    stages = [NO_LAWS, told(1, SLACK), told(2, ("contact_gap", {"gap": 0.009})), told(3)]
    laws = [stages[min(k // 600, 3)] for k in range(2400)]
    stiff = FlexibleBoxModel(BoxParameters(m=1.0, k1=3000.0, b1=50.0)).theta()
    found = Felt(policy, pushed(2400), laws, stiff)
    assert np.linalg.norm(found.jump, axis=1).max() <= 20.0 * STEP * (1 + 1e-9)
    ends = [found.force[600 * (i + 1) - 1, 1] for i in range(4)]
    assert ends[0] < ends[1] - 0.05 and ends[1] < ends[2] - 0.05  # it pushes back less with more of it
    if isinstance(policy, RateLimited):
        assert ends[3] == pytest.approx(ends[0], abs=1e-6)
    else:
        assert found.balance().min() > -1e-5


def test_off_a_level_surface_a_message_with_a_clearance_is_not_felt():
    vector = ModelMessage(UNKNOWN_THETA, effects=(ToldEffect(*SLACK), ToldEffect(*CUBIC)), number=2).vector().tobytes()
    good, refused = told(1, CUBIC), felt_by_bytes(vector, level=False)
    found = Felt(AtOnce(), pushed(500), [good if k < 100 else refused for k in range(500)])
    assert np.array_equal(found.force, Felt(AtOnce(), pushed(500), good).force)
    assert np.all(found.status[100:] == NOT_FELT)


@pytest.mark.parametrize("policy", [RateLimited(20.0), EnergyPermitting(rate=20.0)], ids=["rate", "energy"])
def test_a_body_that_is_brought_back_across_a_clearance_changes_the_force_no_faster(policy):
    sticky = FlexibleBoxModel(BoxParameters(m=1.0, k1=0.0, k2=1000.0, b1=20.0, Fc=50.0)).theta()
    motion, held = pushed(3000), np.zeros((3000, HELD_SIZE))
    motion[1500:, 1] += 0.002 * np.sin(40.0 * STEP * np.arange(1500))  # so that the damper acts at the edge
    motion[1500:, 4] = 0.08 * np.cos(40.0 * STEP * np.arange(1500))
    held[1500:, 3], held[1500:, 5] = 0.0125, 1.5
    found = Felt(policy, motion, told(1, SLACK), sticky, held=held)
    assert found.force[1499, 1] < -7.0 and found.force[-200:, 1].mean() > -3.0
    assert np.linalg.norm(found.jump, axis=1).max() <= 20.0 * STEP * (1 + 1e-8)


@pytest.mark.parametrize("policy", [RateLimited(20.0), EnergyPermitting(rate=20.0)], ids=["rate", "energy"])
def test_a_spring_whose_place_a_law_takes_goes_when_that_enters_and_not_before(policy):
    motion = pushed(3000)
    found = Felt(policy, motion, [told(1, CUBIC) if k < 1000 else told(2, BALL) for k in range(3000)])
    alone = Felt(AtOnce(), motion, told(1, BALL))
    ends = found.force[999, 2], alone.force[-1, 2]
    assert found.force[1000:, 2].min() > 0.95 * min(ends) and found.force[1000:, 2].max() < 1.05 * max(ends)
    assert found.force[-1, 2] == pytest.approx(ends[1], rel=0.01 if isinstance(policy, RateLimited) else 0.3)


def test_friction_that_a_law_takes_the_place_of_holds_while_energy_is_short():
    same = ("asymmetric_friction", {"Fc_plus": 3.0, "Fc_minus": 3.0})
    sticky, stiff = (FlexibleBoxModel(BoxParameters(m=1.0, k2=k2, b1=1.0, Fc=3.0)).theta() for k2 in (500.0, 3000.0))
    theta = np.where(np.arange(3000)[:, np.newaxis] < 1000, sticky, stiff)
    plain, found = (
        Felt(
            EnergyPermitting(0.02),
            pushed(3000, along=0.003),
            [NO_LAWS if k < 1000 else laws for k in range(3000)],
            theta,
        )
        for laws in (NO_LAWS, told(1, same))
    )
    np.testing.assert_allclose(found.force[1000:, 1], plain.force[1000:, 1], rtol=0.02)


def test_blended_laws_that_are_told_no_more_are_gone_in_the_end_and_make_room():
    stages = [told(1, CUBIC, SLACK), told(2, LOOP)]
    found = Felt(Blended(0.1), pushed(6000), [stages[k >= 1000] for k in range(6000)])
    alone = Felt(Blended(0.1), pushed(6000), told(1, LOOP))
    assert found.status[-1] == RENDERING
    np.testing.assert_allclose(found.force[-1], alone.force[-1], rtol=0.05)


def test_a_message_that_is_refused_leaves_the_last_good_one_and_says_why():
    motion, good = moving(500), told(7, CUBIC)
    vector = ModelMessage(UNKNOWN_THETA, effects=(ToldEffect(*CUBIC),), number=8).vector()
    active, unknown, newer = vector.copy(), vector.copy(), vector.copy()
    active[EFFECTS + 1], unknown[EFFECTS], newer[0] = -1e5, 12.0, VERSION + 1.0
    cases = [(active, NOT_FELT), (unknown, UNKNOWN_MODEL), (newer, UNKNOWN_MODEL)]
    cases = [(felt_by_bytes(bad.tobytes()), status) for bad, status in cases]
    cases += [(told(6), UNKNOWN_MODEL), (told(7, LOOP), UNKNOWN_MODEL)]  # older, and another of the same number
    steady = Felt(AtOnce(), motion, good)
    for bad, status in cases:
        found = Felt(AtOnce(), motion, [good if k < 100 else bad for k in range(500)])
        assert np.array_equal(found.force, steady.force)
        assert np.all(found.status[1:100] == RENDERING) and np.all(found.status[100:] == status)


def test_a_law_that_stays_keeps_its_share_its_memory_and_its_numbers_when_another_one_enters():
    p, target, state = np.zeros(VECTOR_SIZE), np.zeros(VECTOR_SIZE), np.zeros(box.STATE_SIZE)
    bodies = box.BODY + np.array([0, AXIS_SIZE])
    laws = {name: with_effects(BOX, [{"name": n, "parameters": v} for n, v in some], "test").kernel_vector()
            for name, some in (("one", [LOOP]), ("two", [LATE, LOOP]))}  # fmt: skip
    for vector, name in ((p, "one"), (target, "two")):
        vector[: len(laws[name])] = laws[name]
    entry = KERNEL_SIZE + HEAD
    p[entry + SHARE], p[entry + VALUES] = 0.6, 250.0

    state[bodies + OF_BODY], state[bodies + OF_BODY + 1] = (0.01, -0.02), (0.03, 0.04)
    align(state, p, target)
    other = entry + ENTRY
    assert p[LAWS] == 2.0 and p[entry + SHARE] == 0.0  # the new one, first in the table
    assert p[other + SHARE] == 0.6 and p[other + VALUES] == 250.0 and p[other + MEMORY] == 2.0
    assert np.array_equal(state[bodies + OF_BODY + 2], [0.01, -0.02])
    assert np.array_equal(state[bodies + OF_BODY + 3], [0.03, 0.04])
    assert np.all(state[bodies + OF_BODY] == 0.0) and np.all(state[bodies + OF_BODY + 1] == 0.0)


def test_a_law_along_the_surface_and_the_same_along_the_normal_are_two():
    motion = moving(3000)
    along, normal = told(1, LATE), told(2, ("normal_viscoelastic_relaxation", LATE[1]))
    laws = [along if k < 1000 else normal for k in range(3000)]
    found, alone = Felt(AtOnce(), motion, laws), Felt(AtOnce(), motion, normal)
    np.testing.assert_allclose(found.force[1500:, 2], alone.force[1500:, 2], atol=1e-9 * np.abs(alone.force).max())
    bare = Felt(AtOnce(), motion, [along if k < 1000 else told(2) for k in range(3000)])
    np.testing.assert_allclose(found.force[1500:, :2], bare.force[1500:, :2], atol=1e-9 * np.abs(alone.force).max())
    assert np.abs(found.force[1500:, 2] - bare.force[1500:, 2]).max() > 0.1


def test_a_law_along_the_normal_keeps_its_share_and_memory_when_one_along_the_surface_enters():
    p, target, state = np.zeros(VECTOR_SIZE), np.zeros(VECTOR_SIZE), np.zeros(box.STATE_SIZE)
    for vector, effects in ((p, (YIELDS,)), (target, (YIELDS, LATE))):
        write_theta(BOX.theta(), STEP, 0.0, vector)
        put_laws(told(1, *effects), vector)
    entry, normal = KERNEL_SIZE + HEAD, box.NORMAL + OF_BODY
    p[entry + SHARE], state[normal] = 0.6, 0.003
    align(state, p, target)
    assert p[LAWS] == 2.0 and p[entry + SHARE] == 0.0 and p[entry + ENTRY + SHARE] == 0.6
    assert p[entry + ENTRY + MEMORY] == 2.0 and state[normal] == 0.0 and state[normal + 2] == 0.003


def test_on_a_slope_a_law_along_its_normal_makes_the_force_of_its_formula_and_gives_no_energy():
    motion, n = moving(3000), np.array([np.sin(0.2), 0.0, np.cos(0.2)])
    above, rate = motion[:, :3] @ n, motion[:, 3:] @ n
    plane, contact = np.tile([*n, 0.0], (3000, 1)), (above < 0.0).astype(float)
    found = Felt(AtOnce(), motion, told(1, PRESSED, CUBIC), contact=contact, plane=plane)
    theta = BOX.theta()
    normal = -(theta[6] * above + 2e7 * above**3 + theta[7] * rate) * contact
    np.testing.assert_allclose(found.force[1:] @ n, normal[1:], atol=1e-9 * np.abs(normal).max())
    for effects in ((PRESSED, CUBIC), (YIELDS, ROUND)):
        felt = Felt(EnergyPermitting(0.02), motion, told(1, *effects), contact=contact, plane=plane)
        assert np.abs(felt.force).max() > 1.0 and felt.balance().min() > -1e-5


def test_a_law_that_would_need_too_short_steps_is_passed_over():
    found = Felt(AtOnce(), moving(300), told(1, ("end_stop", {"position": 0.0, "stiffness": 1e12})))
    assert np.all(found.status[1:] == TOO_FAST)
    assert np.array_equal(found.force, Felt(AtOnce(), moving(300), NO_LAWS).force)


def test_on_a_plane_that_is_next_to_level_laws_are_what_they_are_on_a_level_surface():
    motion = moving(2000)
    slope = np.tile([0.0, np.sin(1e-7), np.cos(1e-7), 1e-9], (2000, 1))
    for effects in ((CUBIC,), (LOOP, LATE), (PRESSED, ROUND), (YIELDS, CUBIC)):
        level, tilted = (Felt(AtOnce(), motion, told(1, *effects), plane=plane) for plane in (None, slope))
        np.testing.assert_allclose(tilted.force, level.force, atol=1e-4 * np.abs(level.force).max())
        np.testing.assert_allclose(tilted.stored, level.stored, atol=1e-4 * level.stored.max())


def test_on_a_surface_that_the_body_carries_laws_are_left_out():
    motion = moving(300)
    found = Felt(AtOnce(), motion, told(1, CUBIC), world=0.0)
    assert np.all(found.status[1:] == NOT_FELT)
    assert np.array_equal(found.force, Felt(AtOnce(), motion, NO_LAWS, world=0.0).force)


def test_laws_that_are_dropped_stay_so_until_a_later_message():
    memory = Felt(AtOnce(), moving(50), told(3, CUBIC)).memory
    assert drop_laws(memory, 3.0) and not drop_laws(memory, 3.0)
    motion, out = np.array([*UP, 0.0, 0.0, 0.0]), np.zeros(sum(READOUT_SIZES))
    fixed = rule(AtOnce(), STEP, STEP)
    for number, status in ((3, TOO_FAST), (4, RENDERING)):
        given = (motion, motion, BOX.theta(), 1.0, 1.0, fixed, False, NO_REPORT, NO_PLANE, 1.0, np.inf)
        render_on(memory, 0.06, *given, told(number, CUBIC), out)
        assert out[3] == status
