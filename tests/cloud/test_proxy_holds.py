"""The proxy stays on its side of the surface, lets go when it should, and survives every degenerate place."""

import math
import time

import numpy as np
import pytest
from proxy_reference import followed

from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.cloud.proxy import (
    CLOUD,
    ENTRENCHED,
    FREE,
    NORMAL,
    POSITION,
    STATE,
    SURFACE,
    TOUCHING,
    new_memory,
    step_proxy,
)
from mmt_drake.errors import BadInput

SETTINGS = ProxySettings()
PACKED = SETTINGS.packed()


def offset_of(cloud):
    return SETTINGS.r2 - cloud.spacing**2 / (12.0 * SETTINGS.r2)


@pytest.mark.parametrize("speed", [0.01, 0.1, 0.5, 1.0, 2.0, 5.0])
@pytest.mark.parametrize("degrees", [0, 30, 60, 80])
@pytest.mark.parametrize(
    ("layout", "noise"), [("regular", 0.0), ("jittered", 3e-4), ("random", 2e-4), ("regular", 5e-4)]
)
def test_no_hand_gets_through(speed, degrees, layout, noise):
    """From 20 mm above to 50 mm below and more, straight and oblique; in contact all the way, without a gap."""
    cloud = plane(30_000, layout=layout, noise=noise, seed=11)
    random = np.random.default_rng(int(1000 * speed) + degrees)
    for _ in range(4):
        angle, turn = math.radians(degrees), random.uniform(0.0, 2.0 * math.pi)
        along = np.array([math.sin(angle) * math.cos(turn), math.sin(angle) * math.sin(turn), -math.cos(angle)])
        start = np.append(random.uniform(-0.03, 0.03, 2), 0.0) - 0.02 * along
        ticks = min(int(0.07 / (speed * 1e-3)), 3000)
        hands = start + along * speed * 1e-3 * (np.arange(ticks)[:, None] + random.uniform())
        hands = hands[np.abs(hands[:, :2]).max(axis=1) < 0.12]
        rows = followed(hands, lambda k: cloud)
        assert rows[:, POSITION + 2].min() + offset_of(cloud) > 0.0
        assert np.all(rows[hands[:, 2] < -1e-3, TOUCHING] == 1.0)


@pytest.mark.parametrize("speed", [0.2, 1.0, 2.0])
@pytest.mark.parametrize("how", ["unknown, every tick", "known, every tick", "known, at 30 Hz"])
@pytest.mark.parametrize("noise", [0.0, 3e-4])
def test_no_cloud_passes_a_waiting_hand(speed, how, noise):
    base = plane(8100, (0.09, 0.09), layout="jittered", noise=noise, seed=12)
    ticks = int(0.06 / speed * 1e3) + 70
    every = 33 if how.endswith("30 Hz") else 1
    heights = -0.03 + speed * 1e-3 * (np.arange(ticks) // every * every)

    def cloud_at(k):
        if how.startswith("known"):
            return base.moved((0.0, 0.0, heights[k]), k * 1e-3)
        return Cloud(
            plane(8100, (0.09, 0.09), layout="jittered", noise=noise, seed=k).points() + np.array([0, 0, heights[k]])
        )

    rows = followed(np.tile([0.002, 0.001, 0.0], (ticks, 1)), cloud_at)
    assert np.all(rows[:, POSITION + 2] - heights + offset_of(base) > 0.5e-3)
    assert np.all(rows[heights > 1e-3, TOUCHING] == 1.0)
    assert np.all(rows[heights < -1e-3, TOUCHING] == 0.0)
    np.testing.assert_allclose(rows[-1, SURFACE + 2], heights[-1], atol=0.6 * noise + 1e-4)


@pytest.mark.parametrize("speed", [0.05, 0.3, 2.0])
def test_an_object_that_slides_under_the_hand_leaves_the_proxy_alone(speed):
    """30 Hz steps of up to 67 mm along the surface; the hand rests 3 mm deep."""
    cloud = plane(30_000, (0.6, 0.15))
    hands = np.vstack([[[0.0, 0.0, 0.01]], np.tile([0.0, 0.0, -0.003], (600, 1))])
    rows = followed(hands, lambda k: cloud.moved((0.2 * math.sin(speed / 0.2 * 1e-3 * (k // 33 * 33)), 0.0, 0.0), 0.0))
    assert np.all(rows[1:, TOUCHING] == 1.0)
    assert np.abs(rows[1:, POSITION : POSITION + 2]).max() < 1e-4
    np.testing.assert_allclose(rows[1:, SURFACE + 2], 0.0, atol=1e-5)


@pytest.mark.parametrize(
    ("r1", "r2", "zeta"), [(3e-3, 5e-3, 0.5), (1e-3, 8e-3, 0.5), (2e-3, 9e-3, 0.9), (1e-3, 2e-3, 0.3)]
)
def test_leaving_takes_the_steps_of_eq_23(r1, r2, zeta):
    """From the r1 shell to the r2 shell, the hand far off: n = ceil((r2 - r1)/(zeta r1))."""
    settings = ProxySettings(r1=r1, r2=r2, r3=2 * r2, zeta=zeta, surface_offset=0.0)
    cloud = Cloud([[0.0, 0.0, 0.0]])
    memory = new_memory()
    memory[CLOUD] = cloud.kernel_arrays[3][3]
    memory[POSITION + 2] = r1 * (1.0 + 1e-9)
    steps = 0
    while steps == 0 or memory[TOUCHING]:
        step_proxy(memory, np.array([0.0, 0.0, 1.0]), cloud, settings.packed())
        steps += 1
    assert steps == math.ceil((r2 - r1) / (zeta * r1))
    assert memory[POSITION + 2] == 1.0  # and is back at the hand in the very tick


def test_the_hand_s_share_gamma_is_taken_when_it_is_near():
    settings = ProxySettings(gamma=0.7, surface_offset=0.0)
    cloud = Cloud([[0.0, 0.0, 0.0]])
    memory = new_memory()
    memory[CLOUD] = cloud.kernel_arrays[3][3]
    memory[POSITION + 2] = 3.5e-3
    step_proxy(memory, np.array([0.0, 0.0, 4.5e-3]), cloud, settings.packed())
    assert memory[POSITION + 2] == pytest.approx(3.5e-3 + 0.7e-3)


def test_a_proxy_away_from_everything_is_the_hand():
    cloud = plane(1000)
    hands = np.random.default_rng(0).uniform(0.01, 0.3, (50, 3))
    rows = followed(hands, lambda k: cloud)
    np.testing.assert_array_equal(rows[:, POSITION : POSITION + 3], hands)
    assert not rows[:, TOUCHING].any()


@pytest.mark.parametrize("cloud", [None, Cloud.empty()])
def test_without_a_cloud_there_is_no_contact(cloud):
    rows = followed(np.array([[0.0, 0.0, 0.1], [0.0, 0.0, -0.1]]), lambda k: cloud)
    assert not rows[:, TOUCHING].any()
    np.testing.assert_array_equal(rows[-1, POSITION : POSITION + 3], [0.0, 0.0, -0.1])


@pytest.mark.parametrize("depth", [0.004, 0.05])
def test_a_first_cloud_above_the_hand_is_contact_at_once(depth):
    cloud = plane(30_000)
    rows = followed(np.tile([0.01, 0.02, -depth], (5, 1)), lambda k: None if k < 3 else cloud)
    np.testing.assert_array_equal(rows[:, TOUCHING], [0, 0, 0, 1, 1])
    np.testing.assert_allclose(rows[3, SURFACE : SURFACE + 3], [0.01, 0.02, 0.0], atol=1e-4)


def test_a_hand_that_rests_on_the_proxy_moves_nothing():
    cloud = Cloud([[0.0, 0.0, 0.0]])
    settings = ProxySettings(surface_offset=0.0)
    rows = followed(np.tile([0.0, 0.0, 4e-3], (5, 1)), lambda k: cloud, settings)
    np.testing.assert_array_equal(rows[-1, POSITION : POSITION + 3], [0.0, 0.0, 4e-3])
    assert rows[-1, TOUCHING] == 1.0


def placed(points, at, hand, ticks=1, normal=(0.0, 0.0, 0.0)):
    settings = ProxySettings(surface_offset=0.0)
    cloud = Cloud(points)
    memory = new_memory()
    memory[CLOUD] = cloud.kernel_arrays[3][3]
    memory[POSITION : POSITION + 3] = at
    memory[NORMAL : NORMAL + 3] = normal
    for _ in range(ticks):
        step_proxy(memory, np.array(hand, float), cloud, settings.packed())
    assert np.isfinite(memory).all()
    return memory


def test_a_point_exactly_at_the_centre_sends_the_proxy_up():
    memory = placed([[0.0, 0.0, 0.0]], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0])
    assert memory[STATE] == ENTRENCHED
    np.testing.assert_allclose(memory[POSITION : POSITION + 3], [0.0, 0.0, 4e-3])


@pytest.mark.parametrize(("last", "used"), [((0.0, 0.6, -0.8), (0.0, 0.6, -0.8)), ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))])
def test_points_that_cancel_each_other_leave_the_last_normal_or_the_table_s(last, used):
    pair = [[-2e-3, 0.0, 0.0], [2e-3, 0.0, 0.0]]
    memory = placed(pair, [0.0, 0.0, 0.0], [0.0, 0.0, -1.0], normal=last)
    np.testing.assert_array_equal(memory[NORMAL : NORMAL + 3], used)
    np.testing.assert_allclose(memory[POSITION : POSITION + 3], math.sqrt(4e-3**2 - 2e-3**2) * np.array(used))


def test_in_a_corner_the_proxy_rests_on_both_walls():
    t = np.arange(0.0, 0.04, 5e-4)
    u, v = (g.ravel() for g in np.meshgrid(t, np.arange(-0.02, 0.02, 5e-4)))
    corner = np.vstack([np.column_stack([u, v, 0 * u]), np.column_stack([0 * u, v, u])])
    memory = placed(corner, [0.02, 0.0, 0.02], [-0.05, 0.0, -0.05], ticks=200)
    x, _, z = memory[POSITION : POSITION + 3]
    assert 2.5e-3 < x < 5e-3
    assert 2.5e-3 < z < 5e-3
    assert memory[TOUCHING] == 1.0


def test_the_proxy_goes_over_the_edge_of_the_object():
    cloud = plane(30_000, (0.1, 0.1))
    x = np.linspace(0.0, 0.08, 400)
    hands = np.column_stack([x, 0 * x, np.where(x > 0, -0.01, 0.02)])
    rows = followed(hands, lambda k: cloud)
    assert rows[200, TOUCHING] == 1.0
    assert rows[-1, STATE] == FREE
    np.testing.assert_array_equal(rows[-1, POSITION : POSITION + 3], hands[-1])


@pytest.mark.parametrize("hand", [[math.nan, 0.0, 0.0], [0.0, math.inf, 0.0]])
def test_a_hand_that_is_nowhere_is_refused(hand):
    with pytest.raises(BadInput, match="finite"):
        step_proxy(new_memory(), np.array(hand), plane(10), PACKED)


def test_something_else_than_a_cloud_is_refused():
    with pytest.raises(BadInput, match="ndarray"):
        step_proxy(new_memory(), np.zeros(3), np.zeros((5, 3)), PACKED)


@pytest.mark.parametrize(
    "bad",
    [
        {"r1": 0.0},
        {"r1": 6e-3},
        {"r3": 4e-3},
        {"gamma": 1.0},
        {"zeta": 0.0},
        {"period": 0.0},
        {"r2": math.nan},
        {"surface_offset": math.inf},
    ],
)
def test_settings_that_cannot_be_are_refused(bad):
    with pytest.raises(BadInput):
        ProxySettings(**bad)


def median_tick(cloud):
    """Median wall time [s] of a tick while the hand slides 20 mm, pressed in by 4 mm."""
    memory = new_memory()
    step_proxy(memory, np.array([-0.01, 0.0, 0.02]), cloud, PACKED)
    times = []
    for x in np.linspace(-0.01, 0.01, 500):
        hand = np.array([x, 0.0, -0.004])
        begin = time.perf_counter()
        step_proxy(memory, hand, cloud, PACKED)
        times.append(time.perf_counter() - begin)
    assert memory[TOUCHING] == 1.0
    return np.median(times)


def test_what_a_tick_costs_depends_on_how_dense_the_points_are_and_not_on_how_many():
    """A hundred times as many points, as dense; a pass over all of them would take a hundred times as long."""
    few, many = (plane(n, (side, side), layout="jittered", noise=1e-4) for n, side in ((3000, 0.03), (300_000, 0.3)))
    assert many.spacing == pytest.approx(few.spacing, rel=0.05)
    assert median_tick(many) < 10.0 * median_tick(few)


@pytest.mark.parametrize(("share", "holds"), [(0.98, True), (1.02, False)])
def test_a_press_comes_through_a_lattice_from_the_widest_spacing_on(share, holds):
    """Pressed 12 mm deep between four points, then slid over them."""
    spacing = share * SETTINGS.widest_spacing
    along = spacing * np.arange(-12, 13)
    cloud = Cloud(np.column_stack([np.array(np.meshgrid(along, along)).reshape(2, -1).T, np.zeros(25 * 25)]))
    t = np.arange(2500) * 1e-3
    slide = 0.03 * np.column_stack([np.sin(3.0 * (t - 0.5)), 0.5 * np.sin(4.3 * (t - 0.5))]) * (t > 0.5)[:, None]
    hands = np.column_stack([slide + 0.5 * spacing, 0.008 - 0.02 * np.minimum(t / 0.4, 1.0)])
    touching = followed(hands, lambda k: cloud)[hands[:, 2] < -0.006, TOUCHING]
    assert touching.all() == holds
