"""How parameters are taken up: the jumps that each policy makes, where it ends, and what energy it adds."""

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.model import flexible_box as box
from mmt_drake.model.energy import stored_energy
from mmt_drake.model.held_body import NO_REPORT
from mmt_drake.model.parameters import K2, NORMAL_K, FlexibleBoxModel
from mmt_drake.rendering import updates
from mmt_drake.rendering.impedance import MEMORY_SIZE, NO_PLANE, PORT_SIZES, READOUT_SIZES, render_on
from mmt_drake.rendering.status import APPROACHING, NO_MODEL, RENDERING, TOO_STIFF, UNSTABLE, WAITING
from mmt_drake.rendering.updates import AtOnce, Blended, EnergyPermitting, RateLimited, rule
from mmt_drake.told_laws import NO_LAWS

STEP = 1e-3
MEMORY = sum(PORT_SIZES.values())
THETA = FlexibleBoxModel().theta()
PRESSED = np.array([0.0, 0.0, -0.004, 0.0, 0.0, 0.0])


class Rendered:
    """(n, ...) of every tick: force, status, jump, stored energy, and the motion, which need not be what is seen."""

    def __init__(
        self, policy, motion, theta, stable=1.0, contact=1.0, held=NO_REPORT, placed=False, seen=None, plane=NO_PLANE
    ):
        n = len(motion)
        theta = np.broadcast_to(theta, (n, 10))
        stable, contact = np.broadcast_to(stable, n), np.broadcast_to(contact, n)
        held, plane = np.broadcast_to(held, (n, len(NO_REPORT))), np.broadcast_to(plane, (n, len(NO_PLANE)))
        out, memory = np.zeros((n, sum(READOUT_SIZES))), np.zeros(MEMORY_SIZE)
        fixed = rule(policy, STEP, STEP * (1 + 1e-9))
        seen = motion if seen is None else seen
        for k in range(n):
            render_on(
                memory,
                k * STEP,
                seen[k],
                seen[k],
                theta[k].copy(),
                stable[k],
                contact[k],
                fixed,
                placed,
                held[k].copy(),
                plane[k].copy(),
                1.0,
                np.inf,
                NO_LAWS,
                out[k],
            )
            memory = out[k, MEMORY:].copy()
        self.position, self.state = motion[:, :3], out[:, MEMORY:]
        self.force, self.status, self.jump, self.stored = out[:, :3], out[:, 3], out[:, 4:7], out[:, 7]

    def balance(self):
        """What the hand has put in less what is stored [J], each force being held until the next."""
        steps = -np.sum(self.force[:-1] * np.diff(self.position, axis=0), axis=1)
        return np.append(0.0, np.cumsum(steps)) - self.stored


def still(n):
    return np.tile(PRESSED, (n, 1))


def moving(n, seed=0):
    """(n, 6) strokes and presses of three sines on each axis, in and out of contact."""
    random = np.random.default_rng(seed)
    t = np.arange(n) * STEP
    motion = np.zeros((n, 6))
    for axis, size in enumerate((0.01, 0.02, 0.004)):
        for w in random.uniform(2.0, 20.0, 3):
            phase = random.uniform(0.0, 6.0)
            motion[:, axis] += size / 2 * np.sin(w * t + phase)
            motion[:, 3 + axis] += size / 2 * w * np.cos(w * t + phase)
    motion[:, 2] -= 0.002
    return motion


def wandering(n, seed=0):
    """(n, 10) parameters that are redrawn every 50 ms."""
    random = np.random.default_rng(seed)
    scale = np.array([1.0, 60.0, 500.0, 60.0, 60.0, 0.3, 500.0, 60.0, 0.5, 0.002])
    return np.repeat(random.uniform(0.3, 2.0, (n // 50 + 1, 10)) * scale, 50, axis=0)[:n]


def test_at_once_the_jump_is_the_difference_of_the_two_models_forces():
    theta = np.tile(THETA, (20, 1))
    theta[10:, 6] = 700.0
    found = Rendered(AtOnce(), still(20), theta)
    assert found.jump[0] == pytest.approx([0.0, 0.0, 2.0])  # the first set makes a force where there was none
    assert found.jump[10] == pytest.approx([0.0, 0.0, 0.8])
    assert np.all(found.jump[[*range(1, 10), *range(11, 20)]] == 0.0)
    assert np.all(found.status == RENDERING)


def test_rate_limited_no_update_changes_the_force_faster_and_it_arrives():
    found = Rendered(RateLimited(rate=20.0), moving(6000), wandering(6000))
    assert np.linalg.norm(found.jump, axis=1).max() <= 20.0 * STEP * (1 + 1e-9)
    calm = Rendered(RateLimited(rate=20.0), still(200), THETA)
    np.testing.assert_allclose(calm.force[:100, 2], 0.02 * np.arange(1, 101), rtol=1e-9)
    assert np.all(calm.status[:99] == APPROACHING) and np.all(calm.status[100:] == RENDERING)
    assert calm.force[-1, 2] == 2.0


def test_blended_the_force_follows_exponentially_until_nobody_could_tell():
    found = Rendered(Blended(time=0.05), still(800), THETA)
    np.testing.assert_allclose(found.force[:300, 2], 2.0 * -np.expm1(-np.arange(1, 301) * STEP / 0.05), rtol=1e-9)
    arrived = round(0.05 * np.log(1e6) / STEP)
    assert (found.status[: arrived - 1] == APPROACHING).all() and (found.status[arrived + 1 :] == RENDERING).all()
    assert found.force[-1, 2] == 2.0 and np.abs(found.jump[arrived - 1 :]).max() < 1e-5


@pytest.mark.parametrize("seed", range(5))
def test_as_energy_permits_nothing_can_be_got_back_that_was_not_put_in(seed):
    motion, theta = moving(8000, seed), wandering(8000, seed)
    contact = (motion[:, 2] < 0.0).astype(float)
    late = np.append(np.zeros(200), contact[:-200])
    least = []
    for flag in (contact, late):
        kept, free = (Rendered(way, motion, theta, contact=flag) for way in (EnergyPermitting(0.02), AtOnce()))
        assert np.abs(kept.force).max() > 1.0
        assert kept.balance().min() > -1e-7  # what the body took up within its first tick
        least.append(free.balance().min())
    assert min(least) < -1e-3


LOSSLESS = THETA.copy()
LOSSLESS[[4, 7]] = 0.0


def pressed(*turns):
    """Motion (n, 6) 4 mm down and then along z as told, straight from one (time [s], height [m]) to the next.

    And a set of parameters (n, 10) that burns some energy on the way down and none afterwards.
    """
    at, height = zip((0.0, 0.0), (0.1, -0.004), *turns, strict=True)
    motion = np.zeros((round(at[-1] / STEP) + 1, 6))
    motion[:, 2] = np.interp(np.arange(len(motion)) * STEP, at, height)
    motion[:, 5] = np.gradient(motion[:, 2], STEP)
    return motion, np.where(np.arange(len(motion))[:, np.newaxis] < 100, THETA, LOSSLESS)


LAPSES = 0.2 + 0.4 * np.arange(4)
LAPSE = np.concatenate([np.arange(round(start / STEP) + 1, round((start + 0.2) / STEP)) for start in LAPSES])


def test_as_energy_permits_what_the_hand_does_unseen_is_not_put_to_its_credit():
    turns = []
    for start in LAPSES:  # deeper once the force is let go, and back against the spring
        turns += [(start + 0.13, -0.004), (start + 0.2, -0.008), (start + 0.4, -0.004)]
    motion, theta = pressed(*turns)
    seen = motion.copy()
    seen[LAPSE] = np.nan
    assert Rendered(EnergyPermitting(), motion, theta, seen=seen).balance().min() > -1e-9
    assert Rendered(AtOnce(), motion, theta, seen=seen).balance().min() < -0.01


def test_as_energy_permits_what_the_hand_is_seen_to_take_while_the_force_is_let_go_counts():
    turns = []
    for start in LAPSES:  # with the force while that is held, and back when there is none
        turns += [(start, -0.004), (start + 0.015, -0.001), (start + 0.13, -0.001), (start + 0.2, -0.004)]
    motion, theta = pressed(*turns)
    contact = np.where(np.isin(np.arange(len(motion)), LAPSE), np.nan, 1.0)
    one_lapse = 2.0 * 0.003  # a force that is held gives this, whatever the account says, but only once
    assert Rendered(EnergyPermitting(), motion, theta, contact=contact).balance().min() > -one_lapse
    assert Rendered(AtOnce(), motion, theta, contact=contact).balance().min() < -2.0 * one_lapse


def test_as_energy_permits_a_probe_that_is_placed_puts_in_what_it_was_held_against():
    motion, theta = pressed((0.4, -0.004), (0.6, 0.0))
    motion[:, 3:] = 0.0
    theta[300:, 6] *= 2.0
    assert Rendered(EnergyPermitting(), motion, theta, placed=True).balance().min() > -1e-9


@pytest.mark.parametrize("speed", [1e-3, 1.0], ids=["slowly", "at once"])
def test_as_energy_permits_a_surface_that_rises_under_the_hand_gives_nothing(speed):
    n, cycle = 20, 1600  # it comes down, is lifted by 1 mm, goes up; the first time the model burns some energy
    t, motion = np.arange(n * cycle) % cycle * STEP, np.zeros((n * cycle, 6))
    motion[:, 2] = np.interp(t, [0.0, 0.1, 1.4, 1.5], [0.001, -0.004, -0.004, 0.001])
    motion[:, 5] = np.gradient(motion[:, 2], STEP)
    plane = np.column_stack(
        [np.zeros((len(t), 2)), np.ones(len(t)), np.clip(speed * (t - 0.2), 0.0, 1e-3) * (t < 1.55)]
    )
    given = {"contact": (motion[:, 2] < plane[:, 3]).astype(float), "plane": plane}
    theta = np.where(np.arange(len(t))[:, np.newaxis] < cycle, THETA, LOSSLESS)
    kept, free = (Rendered(way, motion, theta, **given) for way in (EnergyPermitting(), AtOnce()))
    assert kept.force[:cycle, 2].max() > 1.0
    assert kept.balance().min() > -1e-7
    assert free.balance().min() < -0.02


def test_as_energy_permits_a_set_is_rendered_whole_once_the_model_has_burnt_enough():
    theta = np.tile(THETA, (4000, 1))
    theta[2000:, 6] = 700.0
    motion = moving(4000)
    found = Rendered(EnergyPermitting(rate=1e6), motion, theta)
    plain = Rendered(AtOnce(), motion, theta)
    np.testing.assert_allclose(found.force[-1000:], plain.force[-1000:], atol=1e-6)
    assert found.status[-1] == RENDERING


def test_as_energy_permits_negative_stiffness_and_damping_count_as_none():
    negative = THETA.copy()
    negative[[1, 3]] = -5.0, -3.0
    zero = THETA.copy()
    zero[[1, 3]] = 0.0
    motion = moving(2000)
    np.testing.assert_array_equal(
        Rendered(EnergyPermitting(), motion, negative).force, Rendered(EnergyPermitting(), motion, zero).force
    )


def test_as_energy_permits_no_update_changes_the_force_faster_either_and_a_model_that_stays_is_felt_whole():
    found = Rendered(EnergyPermitting(rate=20.0), moving(6000), wandering(6000))
    assert np.linalg.norm(found.jump, axis=1).max() <= 20.0 * STEP * (1 + 1e-9)
    same = [Rendered(way, moving(6000), THETA).force for way in (EnergyPermitting(), AtOnce())]
    np.testing.assert_allclose(same[0][5700:], same[1][5700:], atol=1e-9)  # how it began dies away


@pytest.mark.parametrize("late", [0, 200], ids=["contact in time", "contact late"])
@pytest.mark.parametrize("velocity", ["dead", "frozen", "noisy", "reversed"])
def test_as_energy_permits_a_wrong_velocity_gets_no_energy_out_that_was_not_put_in(velocity, late):
    given = []
    for seed in range(3):
        random = np.random.default_rng(seed)
        motion = moving(4000, seed)
        motion -= motion[0] * [1, 1, 0, 0, 0, 0]
        seen, theta = motion.copy(), wandering(4000, seed)
        theta[:, 4] *= 3.0  # a strong damper at the probe
        seen[:, 3:] = {
            "dead": np.zeros((4000, 3)),
            "frozen": np.repeat(motion[::500, 3:], 500, axis=0),
            "noisy": motion[:, 3:] + random.normal(0.0, 0.3, (4000, 3)),
            "reversed": -motion[:, 3:],
        }[velocity]
        contact = np.roll(motion[:, 2] < 0.0, late).astype(float)
        for way in (EnergyPermitting(), AtOnce()):
            found = Rendered(way, motion, theta, contact=contact, seen=seen)
            given.append(-np.min(found.balance() + found.stored))
    assert max(given[::2]) < 1e-5 < 1e-3 < max(given[1::2])


@pytest.mark.parametrize("policy", [AtOnce(), RateLimited(), Blended(), EnergyPermitting()], ids=str)
def test_what_is_passed_over_is_told_and_the_latest_good_set_goes_on(policy):
    n = 3000
    motion, theta, stable = moving(n), np.tile(THETA, (n, 1)), np.ones(n)
    expected = Rendered(policy, motion, theta)
    stable[:100] = 0.0
    late = Rendered(policy, motion, theta, stable)
    assert np.all(late.status[:100] == WAITING) and np.all(late.force[:100] == 0.0)
    stable[:100] = 1.0
    stable[500:800] = 0.0
    theta[500:800] = -1.0
    theta[1000:1300, 0] = 1e-7
    theta[1500:1800] = np.nan
    found = Rendered(policy, motion, theta, stable)
    for places, status in ((slice(500, 800), UNSTABLE), (slice(1000, 1300), TOO_STIFF), (slice(1500, 1800), NO_MODEL)):
        assert np.all(found.status[places] == status)
    np.testing.assert_array_equal(found.force, expected.force)


@pytest.mark.parametrize(
    "make",
    [
        lambda: RateLimited(rate=0.0),
        lambda: RateLimited(rate=np.inf),
        lambda: Blended(time=-1.0),
        lambda: EnergyPermitting(reserve=np.nan),
    ],
)
def test_a_policy_without_meaning_is_refused(make):
    with pytest.raises(BadInput, match="updates"):
        make()


@pytest.mark.parametrize("substeps", [1, 4, 7])
def test_a_tick_is_made_in_as_many_steps_as_asked(substeps):
    longest = updates.renderer_rule(None, STEP, substeps)[updates.LONGEST_STEP]
    assert np.ceil(STEP / longest) == substeps and longest == pytest.approx(STEP / substeps, rel=1e-6)


@pytest.mark.parametrize(  # 500 N/m store 4 mJ over 4 mm; off contact there is no spring to soften
    ("contact", "reserve", "softer", "left"),
    [(1.0, 0.01, 1.0, 0.01), (1.0, -0.001, 0.75, 0.0), (1.0, -0.005, 0.0, -0.001), (0.0, -0.001, 1.0, -0.001)],
)
def test_as_energy_permits_springs_are_softened_by_what_the_reserve_does_not_cover(contact, reserve, softer, left):
    p, state, fixed = FlexibleBoxModel().kernel_vector(), np.zeros(box.STATE_SIZE), rule(EnergyPermitting(), STEP, STEP)
    box.begin(state, 0.0, PRESSED, contact, p)
    given = p.copy()
    found = updates.account(state, p, stored_energy(state, p), reserve, fixed)
    given[[K2, NORMAL_K]] *= softer
    assert [found, *p] == pytest.approx([left, *given], rel=1e-12, abs=1e-15)
