"""What is random in a network: laws, chances and seeds."""

import dataclasses
import math

import numpy as np
import pytest
from channels import WILD, H, transmitted
from scipy import stats

from mmt_drake.network.config import ChannelConfig
from mmt_drake.network.parameters import channel_parameters
from mmt_drake.network.transit import transit
from mmt_drake.random import splitmix64


def test_delays_follow_their_laws():
    def drawn(law):
        p, trace = channel_parameters(ChannelConfig(delay=0.2, jitter=0.03, jitter_law=law), H)
        return np.array([transit(k, 0, p, trace) for k in range(20000)]) * H

    uniform, normal, gamma = (drawn(law) for law in ("uniform", "normal", "gamma"))
    for sample, law in (
        (uniform, stats.uniform(0.17, 0.06)),
        (normal, stats.norm(0.2, 0.03)),
        (gamma, stats.gamma(2.0, loc=0.2, scale=0.03 / math.sqrt(2.0))),
    ):
        assert stats.kstest(sample, law.cdf).pvalue > 0.01
        assert abs(np.corrcoef(sample[1:], sample[:-1])[0, 1]) < 0.02
    assert gamma.std() == pytest.approx(0.03, rel=0.03)


@pytest.mark.parametrize("field", ["loss", "duplication", "reordering"])
def test_chances_come_out_as_asked(field):
    config = ChannelConfig(delay=0.005, reordering_delay=0.05, seed=3, **{field: 0.2})
    ticks = 8000
    _, counts = transmitted(config, ticks, counts=True)
    happened = {
        "loss": counts["lost"],
        "duplication": counts["duplicated"],
        # Held back by 50 ms, a packet is overtaken unless all of the next 50 are held back, too.
        "reordering": counts["stale"],
    }[field]
    assert abs(happened - 0.2 * ticks) < 4.0 * math.sqrt(0.16 * ticks) + 60


@pytest.mark.filterwarnings("ignore:overflow")  # numpy warns of the wrap-around that is meant
def test_random_words_are_those_of_the_published_generator():
    found = [int(splitmix64.py_func(np.uint64(1234567), np.uint64(k))) for k in range(5)]
    assert found == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


def test_same_seed_same_network_other_seed_other_network():
    first, again = transmitted(WILD, 300), transmitted(WILD, 300)
    np.testing.assert_array_equal(first, again)
    other = transmitted(dataclasses.replace(WILD, seed=8), 300)
    assert np.mean(first == other) < 0.5
