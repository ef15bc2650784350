"""The compiled proxy takes the same steps as a plain one over all points."""

import numpy as np
import pytest
from proxy_reference import ReferenceProxy

from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.cloud.proxy import NORMAL, POSITION, SPEED, STATE, TOUCHING, new_memory, step_proxy


def wavy(seed):
    random = np.random.default_rng(seed)
    xy = random.uniform(-0.04, 0.04, (2500, 2))
    z = 0.01 * np.sin(60.0 * xy[:, 0]) * np.cos(50.0 * xy[:, 1]) + random.normal(0.0, 2e-4, 2500)
    return np.column_stack([xy, z])


SURFACES = {
    "flat": plane(2500, (0.08, 0.08)).points(),
    "rough": plane(2500, (0.08, 0.08), layout="jittered", noise=4e-4, seed=2).points(),
    "wavy": wavy(3),
}


def a_restless_hand(seed, ticks=600):
    """Free flight, presses, slides up to 3 m/s, lifts and jumps."""
    random = np.random.default_rng(seed)
    t = np.arange(ticks) * 1e-3
    hand = np.column_stack(
        [
            0.02 * np.sin(40.0 * t + seed),
            0.02 * np.cos(31.0 * t),
            0.012 * np.cos(90.0 * t) + random.normal(0, 1e-4, ticks),
        ]
    )
    jumps = random.integers(0, ticks, 6)
    hand[jumps] += random.normal(0.0, 0.02, (6, 3))
    hand[0, 2] = 0.05
    return hand


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("rise", [0.0, 5e-5])
def test_every_tick_equals_the_reference(surface, rise):
    settings = ProxySettings(surface_offset=0.0)
    packed = settings.packed()
    hand = a_restless_hand(7)
    memory = new_memory()
    reference = ReferenceProxy(settings, hand[0])
    states = set()
    for k, at in enumerate(hand):
        # A fresh cloud every tick, so that nothing but eq. 12 can know that the surface rises.
        points = SURFACES[surface] + [0.0, 0.0, rise * k]
        step_proxy(memory, at, Cloud(points), packed)
        reference.tick(at, points)
        states.add(reference.state)
        np.testing.assert_allclose(memory[POSITION : POSITION + 3], reference.position, atol=1e-9, err_msg=f"tick {k}")
        np.testing.assert_allclose(memory[SPEED], reference.speed, atol=1e-6)
        assert memory[STATE] == reference.state
        assert memory[TOUCHING] == reference.touching
        if reference.touching:
            np.testing.assert_allclose(memory[NORMAL : NORMAL + 3], reference.normal, atol=1e-6)
    assert {0, 1} <= states
    assert 2 in states or (surface == "flat" and rise == 0.0)
