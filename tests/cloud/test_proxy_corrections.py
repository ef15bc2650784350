"""Where appendix C is corrected: what the printed form does, and that the corrected one does what is promised."""

import numpy as np
import pytest
from proxy_reference import ReferenceProxy, followed

from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.cloud.proxy import ENTRENCHED, NORMAL, POSITION, SPEED, STATE, TOUCHING, new_memory, step_proxy

SETTINGS = ProxySettings(surface_offset=0.0)
FLAT = plane(3600, (0.06, 0.06)).points()
REST = 0.5 * (SETTINGS.r1 + SETTINGS.r2)


def follow(hands, clouds):
    return followed(hands, clouds.__getitem__, SETTINGS)


def follow_printed(printed, hands, points):
    """Heights of the reference proxy's centre with some of the printed forms left in."""
    proxy = ReferenceProxy(SETTINGS, hands[0], printed)
    heights = []
    for hand, at in zip(hands, points, strict=True):
        proxy.tick(np.asarray(hand, float), at)
        heights.append(proxy.position[2])
    return np.array(heights), proxy


def test_eq_29_as_printed_lets_a_fast_hand_through():
    hands = [[0.001, 0.001, 0.02], [0.001, 0.001, -0.02]]
    heights, _ = follow_printed(["eq29"], hands, [FLAT] * 2)
    assert heights[-1] == -0.02
    ours = follow(hands, [Cloud(FLAT)] * 2)
    assert ours[-1, POSITION + 2] == pytest.approx(REST, abs=1e-4)


def test_eq_22_as_printed_pushes_into_the_surface():
    hands = [[0.0, 0.0, 0.02]] + [[0.0, 0.0, -0.02]] * 30
    heights, _ = follow_printed(["eq22"], hands, [FLAT] * 31)
    assert heights[1:].min() < SETTINGS.r1  # presses itself into entrenchment again and again
    ours = follow(hands, [Cloud(FLAT)] * 31)
    assert ours[1:, POSITION + 2].min() > SETTINGS.r1
    assert not (ours[:, STATE] == ENTRENCHED).any()


def test_eq_22_as_printed_never_lets_go():
    hands = [[0.0, 0.0, 0.02], [0.0, 0.0, -0.02]] + [[0.0, 0.0, 0.02]] * 200
    _, proxy = follow_printed(["eq22"], hands, [FLAT] * 202)
    assert proxy.touching
    ours = follow(hands, [Cloud(FLAT)] * 202)
    assert np.flatnonzero(ours[2:, TOUCHING] == 0.0)[0] < (SETTINGS.r2 - SETTINGS.r1) / (SETTINGS.zeta * SETTINGS.r1)


def test_eq_12_as_printed_never_knows_a_velocity():
    """With s_k from eq. 13 in eq. 12, v_k = v_{k-1} + v_k: v is 0, and every tick of a cloud at 2 m/s entrenches."""
    rising = [Cloud(FLAT + np.array([0.0, 0.0, -0.02 + 2e-3 * k])) for k in range(60)]
    hands = [[0.0, 0.0, 0.0]] * 60
    ours = follow(hands, rising)
    proxy = ReferenceProxy(SETTINGS, hands[0], ["eq12"])
    printed = []
    for hand, cloud in zip(hands, rising, strict=True):
        proxy.tick(np.array(hand), cloud.points())
        printed.append(proxy.state == ENTRENCHED)
    assert sum(printed) > 40
    assert (ours[:, STATE] == ENTRENCHED).sum() <= 2
    assert ours[-1, SPEED] == pytest.approx(2.0, rel=1e-6)


def test_counting_the_hand_s_own_steps_in_eq_12_lets_a_fast_hand_through():
    # 3 m/s from where the steps end 3 mm short of the surface, with a normal to count along since 9 mm.
    hands = [[0.001, 0.001, 0.018 - 3e-3 * k] for k in range(20)]
    heights, _ = follow_printed(["all_steps"], hands, [FLAT] * 20)
    assert heights[-1] == hands[-1][2]
    ours = follow(hands, [Cloud(FLAT)] * 20)
    assert ours[:, POSITION + 2].min() > SETTINGS.r1


def test_one_period_for_a_correction_that_took_many_makes_the_proxy_chatter():
    speed = 0.1
    points = [FLAT + np.array([0.0, 0.0, -0.01 + speed * 1e-3 * k]) for k in range(400)]
    hands = [[0.0, 0.0, -0.02 if k else 0.02] for k in range(400)]
    heights, _ = follow_printed(["one_period"], hands, points)
    above = heights - np.array([at[0, 2] for at in points])
    ours = follow(hands, [Cloud(at) for at in points])
    ours_above = ours[:, POSITION + 2] - np.array([at[0, 2] for at in points])
    assert np.std(above[200:]) > 4e-4
    assert np.std(ours_above[200:]) < 1e-4
    assert ours[-1, SPEED] == pytest.approx(speed, rel=0.02)


def test_a_step_along_the_surface_without_limit_swings_about_the_hand():
    hands = [[0.0, 0.0, 0.02]] + [[2e-4, 0.0, -0.02]] * 40
    proxy = ReferenceProxy(SETTINGS, hands[0], ["length"])
    swings = []
    for hand in hands:
        proxy.tick(np.array(hand), FLAT)
        swings.append(proxy.position[0])
    assert np.ptp(swings[20:]) > 1e-3
    ours = follow(hands, [Cloud(FLAT)] * 41)
    assert np.ptp(ours[20:, POSITION]) < 1e-6


def test_a_cloud_that_passed_the_centre_is_left_on_the_old_side():
    """3 mm in a tick from 2.9 mm away, with no known motion: the centre is 0.1 mm behind the points."""
    memory, packed = new_memory(), SETTINGS.packed()
    hand = np.array([0.0, 0.0, -0.02])
    for height in (-0.02, -0.02, -0.02):
        step_proxy(memory, hand, Cloud(FLAT + np.array([0.0, 0.0, height])), packed)
    above = memory[POSITION + 2] + 0.02
    step_proxy(memory, hand, Cloud(FLAT + np.array([0.0, 0.0, -0.02 + above + 1e-4])), packed)
    assert memory[STATE] == ENTRENCHED
    assert memory[NORMAL + 2] > 0.99
    assert memory[POSITION + 2] - (-0.02 + above + 1e-4) == pytest.approx(REST, abs=2e-4)
