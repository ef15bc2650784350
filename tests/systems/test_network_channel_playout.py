"""A play-out buffer: a constant delay in the place of jitter, and losses bridged."""

import dataclasses
import math

import numpy as np
import pytest
from channels import H, transmitted

from mmt_drake.errors import BadInput
from mmt_drake.network.config import ChannelConfig
from mmt_drake.network.parameters import channel_parameters
from mmt_drake.network.transit import transit

JITTERY = ChannelConfig(delay=0.12, jitter=0.04, playout=0.16, seed=5)


def sine(t):
    w = 2.0 * math.pi * 1.5
    return [0.03 * math.sin(w * t), 0.03 * w * math.cos(w * t)]


def test_playout_turns_jitter_into_a_constant_delay():
    received = transmitted(JITTERY, 500)[:, 0]
    np.testing.assert_array_equal(received, [0.0] * 160 + list(range(1, 341)))


def test_jitter_hurts_without_a_playout_buffer_and_not_with_one():
    sent = np.array([sine(k * H) for k in range(1500)])
    errors = {}
    for playout, delay in ((0.0, 120), (0.16, 160)):
        config = dataclasses.replace(JITTERY, playout=playout)
        received = transmitted(config, 1500, source=sine, size=2, interpolation="motion")
        error = received[500:] - sent[500 - delay : 1500 - delay]
        errors[playout] = error.std(axis=0) / sent.std(axis=0)
    assert errors[0.0].min() > 0.03
    assert errors[0.16].max() < 1e-12


def test_playout_bridges_losses_as_asked():
    def cubic(t):
        return [5.0 * t**3 - t + 1.0, 15.0 * t**2 - 1.0]

    config = dataclasses.replace(JITTERY, loss=0.4)
    times = np.arange(600) * H
    for interpolation, source, size in (("linear", lambda t: [3.0 * t - 1.0, 2.0 - t], 2), ("motion", cubic, 2)):
        received = transmitted(config, 600, source=source, size=size, interpolation=interpolation)
        expected = np.array([source(t - 0.16) for t in times])
        np.testing.assert_allclose(received[200:], expected[200:], atol=1e-9)
    held = transmitted(config, 600)[:, 0]
    behind = np.arange(1, 601) - 160 - held
    assert np.all(behind[200:] >= 0) and behind[200:].max() >= 2
    p, trace = channel_parameters(config, H)
    arrived = np.array([transit(k, 0, p, trace) >= 0.0 for k in range(600)])
    np.testing.assert_array_equal(behind[200:] == 0, arrived[40:440])


def test_packets_too_late_for_playout_never_turn_it_back():
    config = ChannelConfig(delay=0.02, jitter=0.02, jitter_law="gamma", loss=0.2, playout=0.03, seed=2)
    received, counts = transmitted(config, 3000, counts=True)
    assert np.all(np.diff(received[:, 0]) >= 0.0)
    assert counts["stale"] > 100
    assert np.all(received[:, 0] <= np.maximum(np.arange(3000) - 30 + 1, 0))


def test_playout_shorter_than_the_delay_is_bad_input():
    with pytest.raises(BadInput, match="playout"):
        ChannelConfig(delay=0.1, playout=0.05)
