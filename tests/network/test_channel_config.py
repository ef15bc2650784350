"""A network in numbers: what it may be, and how it is read."""

import pytest

from mmt_drake.errors import BadInput
from mmt_drake.network.config import ChannelConfig
from mmt_drake.typed_yaml import fill, parse


@pytest.mark.parametrize(
    "change",
    [
        {"delay": -0.1},
        {"delay": float("nan")},
        {"delay": float("inf")},
        {"delay": "0.4"},
        {"delay": True},
        {"delay": None},
        {"jitter": -1.0},
        {"jitter_law": "cauchy"},
        {"loss": 1.5},
        {"loss": -0.1},
        {"duplication": 2.0},
        {"reordering": float("nan")},
        {"reordering_delay": -1.0},
        {"rate_limit": 0.0},
        {"rate_limit": "fast"},
        {"queue": -1},
        {"queue": 1.5},
        {"seed": -1},
        {"seed": 1.0},
        {"trace": 5},
        {"trace": "delays.csv", "delay": 0.1},
        {"playout": -1.0},
    ],
    ids=str,
)
def test_impossible_networks_are_bad_input(change):
    with pytest.raises(BadInput, match=f"network channel: {next(iter(change))}"):
        ChannelConfig(**change)


def test_config_is_read_from_yaml():
    data = parse("{delay: 0.4, jitter: 0.02, jitter_law: gamma, rate_limit: 500, seed: 3}", "net.yaml")
    config = fill(ChannelConfig, data, "net.yaml")
    assert config == ChannelConfig(delay=0.4, jitter=0.02, jitter_law="gamma", rate_limit=500.0, seed=3)
    with pytest.raises(BadInput, match=r"net\.yaml: loss: found 3"):
        fill(ChannelConfig, {"loss": 3.0}, "net.yaml")
