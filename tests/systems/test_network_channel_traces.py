"""Delays that were measured: each packet gets its own, and a broken file is told."""

import os

import numpy as np
import pytest
from channels import H, transmitted

from mmt_drake.errors import BadInput
from mmt_drake.network.config import ChannelConfig, load_trace
from mmt_drake.systems.network_channel import network_channel


def written(tmp_path, text):
    path = tmp_path / "trace.csv"
    path.write_text(text)
    return path


def test_trace_gives_each_packet_its_delay(tmp_path):
    path = written(tmp_path, "time,delay\n100.0,0.003\n100.010,nan\n100.015,0.001\n100.020,0.005\n")
    received = transmitted(ChannelConfig(trace=str(path)), 60)[:, 0]
    arrivals = {}
    for k in range(60):  # the trace lasts 25 ms and begins again
        phase = k % 25
        delay = 3 if phase < 10 else None if phase < 15 else 1 if phase < 20 else 5
        if delay is not None:
            arrivals.setdefault(k + delay, []).append(k)
    newest, expected = -1, []
    for k in range(60):
        newest = max([newest, *arrivals.get(k, [])])
        expected.append(newest + 1.0)
    np.testing.assert_array_equal(received, expected)


def test_trace_without_delay_passes_at_once(tmp_path):
    path = written(tmp_path, "time,delay\n0,0\n0.01,\n")
    received = transmitted(ChannelConfig(trace=str(path)), 40)[:, 0]
    expected = [k + 1 if k % 20 < 10 else k // 20 * 20 + 10 for k in range(40)]
    np.testing.assert_array_equal(received, expected)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "row 1: found nothing"),
        ("t,d\n0,1\n1,1\n", "header time,delay"),
        ("time,delay\n0,0.1\n", "1 rows"),
        ("time,delay\n0,0.1\n0,0.1\n", "row 3: found time 0"),
        ("time,delay\n0,0.1\n1,-0.1\n", "row 3: found delay -0.1"),
        ("time,delay\n0,0.1\n1,inf\n", "row 3: found delay inf"),
        ("time,delay\n0,0.1\n1,soon\n", "row 3: found 1,soon"),
        ("time,delay\n0,0.1\n1\n", "row 3"),
        ("time,delay\nnan,0.1\n1,0.1\n", "row 2: found time nan"),
        ("time,delay\n0,nan\n1,nan\n", "losses alone"),
        ("time,delay\n0,0.1\n" + "1" * 131_073 + ",0.1\n", "field larger than field limit"),
    ],
)
def test_bad_trace_is_bad_input(tmp_path, text, words):
    with pytest.raises(BadInput, match=words):
        load_trace(written(tmp_path, text))


def test_a_missing_endless_or_binary_trace_is_bad_input(tmp_path):
    with pytest.raises(BadInput, match=r"none\.csv"):
        network_channel(ChannelConfig(trace=str(tmp_path / "none.csv")), 1, H)
    path = written(tmp_path, "time,delay\n")
    os.truncate(path, 12 * 10**9)
    with pytest.raises(BadInput, match="more than 64 MiB"):
        load_trace(path)
    path = tmp_path / "binary.csv"
    path.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(BadInput, match=r"binary\.csv"):
        load_trace(path)
