"""The delay that a direction of the network has most of the time, in whole ticks."""

from pathlib import Path

import pytest

from mmt_drake.errors import BadInput
from mmt_drake.network.config import ChannelConfig
from mmt_drake.network.parameters import usual_delay


def trace(folder: Path) -> str:
    path = folder / "trace.csv"
    path.write_text("time,delay\n0,0.1\n1,0.25\n2,nan\n3,0.9\n")
    return str(path)


@pytest.mark.parametrize(
    ("config", "expected"),
    [
        (ChannelConfig(), 0.0),
        (ChannelConfig(delay=0.4), 0.4),
        (ChannelConfig(delay=0.0102), 0.011),  # the first tick after it
        (ChannelConfig(delay=0.06, jitter=0.02, playout=0.12), 0.12),
    ],
)
def test_it_is_the_play_out_buffer_s_or_the_constant_one(config: ChannelConfig, expected: float) -> None:
    assert usual_delay(config, 1e-3) == pytest.approx(expected, abs=1e-12)


def test_of_a_trace_it_is_the_median_of_what_arrives_unless_a_buffer_evens_it_out(tmp_path: Path) -> None:
    assert usual_delay(ChannelConfig(trace=trace(tmp_path)), 1e-3) == pytest.approx(0.25, abs=1e-12)
    assert usual_delay(ChannelConfig(trace=trace(tmp_path), playout=1.0), 1e-3) == pytest.approx(1.0, abs=1e-12)


def test_a_trace_that_is_gone_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"gone\.csv"):
        usual_delay(ChannelConfig(trace=str(tmp_path / "gone.csv")), 1e-3)
