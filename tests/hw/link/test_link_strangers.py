"""What is not the peer's, or was its own before, is never applied."""

import os
import random
import struct

import numpy as np
import pytest
from link_samples import KEY, Pair, status

from mmt_drake.hw.link import wire
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions

MS = 1_000_000


def test_a_corrupted_packet_is_never_applied_whichever_bit_fell(pair: Pair) -> None:
    for _ in range(5):
        pair.tick()
    draw = random.Random(1)
    refused = status(pair.telerobot)["refused"]
    flips = 0

    def corrupt(packet: bytes, now: int) -> list[tuple[int, bytes]]:
        nonlocal flips
        spoiled = bytearray(packet)
        spoiled[flips % len(packet)] ^= 1 << draw.randrange(8)
        flips += 1
        return [(now, bytes(spoiled))]

    _, before = pair.tick()
    pair.there.fault = corrupt
    for _ in range(90):  # within the timeout, so that what is shown stays
        _, motion = pair.tick()
        assert motion.tobytes() == before.tobytes()
    assert status(pair.telerobot)["refused"] - refused == flips >= 90


def test_a_packet_cut_short_made_longer_or_made_up_is_never_applied(pair: Pair) -> None:
    pair.tick()
    _, before = pair.tick()
    sample = pair.there.sent[-1]
    noise = random.Random(2)
    made_up = [sample[:n] for n in range(len(sample))] + [sample + b"\0", sample * 2, b"", b"MMTL", bytes(5000)]
    made_up += [noise.randbytes(len(sample)) for _ in range(200)]
    made_up += [sample[:8] + struct.pack("<Q", 10**6 + n) + sample[16:] for n in range(50)]  # another number on it
    pair.there.fault = lambda p, now: []
    for n, packet in enumerate(made_up):
        pair.there.inject(packet)
        if n % 20 == 19:
            pair.telerobot.poll()
    _, motion = pair.tick()
    assert motion[:3].tobytes() == before[:3].tobytes()
    told = status(pair.telerobot)
    assert told["refused"] + told["repeated"] == len(made_up)  # some bear a number that has been taken
    assert told["refused"] > 300
    pair.there.fault = lambda p, now: [(now, p)]
    sent = pair.motion()
    assert pair.tick()[1].tobytes() == sent.tobytes()  # and the peer is heard as before


def test_a_stranger_with_another_key_is_never_heard() -> None:
    pair = Pair(key=bytes(reversed(KEY)))
    pair.connect()
    for _ in range(200):
        model, motion = pair.tick()
        assert not motion.any() and not model.any()  # the initial values
    for link in (pair.operator, pair.telerobot):
        told = status(link)
        assert told["alive"] == told["received"] == told["sessions"] == 0.0
        assert told["refused"] > 0


def test_our_own_packets_reflected_are_refused(pair: Pair) -> None:
    pair.there.fault = lambda p, now: [(pair.back.inject(p), (now, p))[1]]  # type: ignore[func-returns-value]
    for _ in range(50):
        model, _ = pair.tick()
        assert model[2] == 1.0
    told = status(pair.operator)
    assert told["refused"] + told["repeated"] > 45
    alone = Pair()

    def mirror(packet: bytes, now: int) -> list[tuple[int, bytes]]:
        alone.back.inject(packet)
        return []

    alone.there.fault, alone.back.fault = mirror, lambda p, now: []
    for _ in range(100):
        alone.tick()
    assert status(alone.operator)["sessions"] == 0.0


def test_a_replayed_packet_is_never_applied_again(pair: Pair) -> None:
    start = len(pair.there.sent)
    for _ in range(30):
        pair.tick()
    old = pair.there.sent[start:]
    for n in range(2000):
        pair.there.inject(old[n % len(old)])
        sent = pair.motion()
        _, motion = pair.tick()
        assert motion.tobytes() == sent.tobytes()
    told = status(pair.telerobot)
    assert told["repeated"] == 2000 and told["sessions"] == 1.0


def test_a_whole_session_replayed_to_a_new_start_is_never_applied(pair: Pair) -> None:
    for _ in range(100):
        pair.tick()
    everything = list(pair.there.sent)
    pair.telerobot = pair.start(TELEROBOT)
    pair.there.fault = lambda p, now: []  # the true operator is gone
    for _ in range(3):
        for packet in everything:
            pair.there.inject(packet)
        for _ in range(10):
            _, motion = pair.tick(operator=False)
            assert not motion.any()
            pair.now += 15 * MS
    told = status(pair.telerobot)
    assert told["alive"] == told["sessions"] == told["received"] == 0.0
    # And the true one gets through as if nothing had been.
    pair.there.fault = lambda p, now: [(now, p)]
    for _ in range(200):  # an old packet was under way to it, so it waits for the timeout
        pair.tick()
    sent = pair.motion()
    assert pair.tick()[1].tobytes() == sent.tobytes()


def test_a_session_that_was_given_up_is_not_brought_back_by_what_was_recorded_of_it(pair: Pair) -> None:
    for _ in range(50):
        pair.tick()
    recorded = list(pair.there.sent)
    pair.operator = pair.start(OPERATOR)
    for _ in range(300):
        pair.tick()
    assert status(pair.telerobot)["sessions"] == 2.0
    pair.there.fault = lambda p, now: []  # the second operator is gone too; only the recording speaks
    _, before = pair.tick()
    for _ in range(10):
        for packet in recorded:
            pair.there.inject(packet)
        for _ in range(20):
            _, motion = pair.tick(operator=False)
            assert motion[:3].tobytes() == before[:3].tobytes()
    told = status(pair.telerobot)
    assert told["sessions"] == 2.0 and told["alive"] == 0.0


def made_up_hello() -> bytes:
    return wire.header(wire.HELLO, 0, 0) + os.urandom(wire.HELLO_SIZE - wire.HEADER_SIZE)


def test_greetings_that_are_made_up_cost_no_cipher(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at = []
    monkeypatch.setattr("mmt_drake.hw.link.endpoint.derive", lambda *a: looked_at.append(a) or bytes(32))
    for _ in range(100):
        for _ in range(20):
            pair.there.inject(made_up_hello())
        sent = pair.motion()
        assert pair.tick()[1].tobytes() == sent.tobytes()
    assert not looked_at


def test_a_peer_gets_through_a_hundred_made_up_greetings_a_millisecond() -> None:
    pair = Pair()
    for _ in range(60):
        for wire_ in (pair.there, pair.back):
            for _ in range(100):
                wire_.inject(made_up_hello())
        pair.tick()
    assert status(pair.operator)["alive"] == status(pair.telerobot)["alive"] == 1.0
    assert status(pair.telerobot)["refused"] >= 5000


def test_what_is_suddenly_held_back_counts_as_not_come_until_the_way_has_become_longer(pair: Pair) -> None:
    pair.there.fault = lambda p, now: [(now + 300 * MS, p)]
    alive = []
    for _ in range(600):
        pair.tick()
        alive.append(status(pair.telerobot)["alive"])
    told = status(pair.telerobot)
    assert alive[:95] == [1.0] * 95 and alive[102:318] == [0.0] * 216  # the first that came late were not applied
    assert told["alive"] == told["clock_steps"] == 1.0 and told["stale"] == 19 and told["round_trip"] > 0.3


def test_no_packet_is_applied_where_all_are_held_back_for_most_of_a_second(pair: Pair) -> None:
    pair.there.fault = lambda p, now: [(now + 900 * MS, p)]
    for _ in range(2):
        _, before = pair.tick()
    for _ in range(3000):
        _, motion = pair.tick()
    assert status(pair.telerobot)["alive"] == 0.0 and motion[:3].tobytes() == before[:3].tobytes()


def test_a_packet_held_back_for_longer_than_allowed_is_not_applied() -> None:
    pair = Pair(LinkOptions(oldest=0.2, timeout=0.1))
    pair.connect()
    pair.there.fault = lambda p, now: [(now + 300 * MS, p)]
    pair.tick()
    at_cut = pair.ticks[OPERATOR]
    t = (at_cut - 2) * 1e-3  # of the last one that came in time
    for n in range(1000):
        _, motion = pair.tick()
        if n > 101:
            assert not motion[3:].any() and motion[:3].tobytes() == np.sin(20.0 * t + np.arange(3)).tobytes()
    told = status(pair.telerobot)
    assert told["alive"] == 0.0 and told["stale"] > 500


def test_numbers_that_are_none_are_refused_though_the_peer_says_them(pair: Pair) -> None:
    _, before = pair.tick()
    for bad in (np.nan, np.inf, -np.inf):
        pair.operator.exchange(1.0, np.array([0.0, bad, 0, 0, 0, 0]), np.zeros(4))
        shown = np.zeros(6)
        pair.telerobot.exchange(1.0, pair.model(), shown)
        assert shown.tobytes() == before.tobytes()
    assert status(pair.telerobot)["refused"] == 3.0
    shown = np.zeros(4)
    pair.telerobot.exchange(1.001, np.array([np.nan, 1.0, np.nan, 1.0]), np.zeros(6))  # a flag is never unknown
    pair.operator.exchange(1.001, pair.motion(), shown)
    assert np.isfinite(shown[2:]).all()
