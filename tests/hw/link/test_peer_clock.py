"""The peer's clock in ours: the quickest of the latest packets, drift followed, steps seen and outliers not."""

import random

import pytest

from mmt_drake.hw.link.peer_clock import PeerClock

MS = 1_000_000


def packets(count: int, drift: float = 0.0, seed: int = 1) -> list[tuple[int, int]]:
    """(sent, arrived) [ns]: 1 ms apart, on their way for 5 ms and up to 20 ms more, the clocks 3 s apart."""
    draw = random.Random(seed)
    return [
        (k * MS, 3_000 * MS + round(k * MS * (1.0 + drift)) + 5 * MS + draw.randrange(20 * MS)) for k in range(count)
    ]


@pytest.mark.parametrize("drift", [0.0, 1e-3, -1e-3])
def test_the_offset_is_that_of_the_quickest_packet_and_follows_drift(drift: float) -> None:
    clock = PeerClock()
    for sent, arrived in packets(20_000, drift):
        assert not clock.note(sent, arrived)
        true = 3_005 * MS + drift * sent
        # Within what the clocks part by in the 4 s that are looked back on at most.
        assert sent < 1000 * MS or -4.1e9 * abs(drift) - MS < clock.offset - true < 0.5 * MS + 1e9 * abs(drift)
    assert clock.steps == 0


def test_a_clock_that_was_set_is_seen_once_and_a_few_packets_that_are_off_are_not() -> None:
    clock = PeerClock()
    told = []
    for k, (sent, arrived) in enumerate(packets(3000)):
        outlier = 1000 <= k < 1015
        step = 500 * MS if k >= 2000 else 0
        told.append(clock.note(sent, arrived + step + (900 * MS if outlier else 0)))
    assert [k for k, seen in enumerate(told) if seen] == [2019]
    assert clock.steps == 1
    assert clock.offset == pytest.approx(3_505 * MS, abs=MS)


def test_nothing_is_known_before_the_first_packet() -> None:
    assert PeerClock().offset == 0 and PeerClock().steps == 0
