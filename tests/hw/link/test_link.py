"""What one end sends the other shows, whatever the network does; what is not the peer's is never shown."""

from __future__ import annotations

import os
import random
import struct
from dataclasses import replace

import numpy as np
import pytest
from link_samples import KEY, PERIOD, SIGNALS, Pair, status

from hw.link import OPERATOR, TELEROBOT, Link, LinkOptions, Signal, wire
from hw.link.options import LARGEST_SIGNAL
from hw.link.samples import Samples
from hw.link.trial.wires import End, Wire
from mmt_drake.errors import BadInput

MS = 1_000_000


@pytest.fixture(scope="module", autouse=True)
def _needs_cryptography() -> None:
    pytest.importorskip("cryptography", reason="the extra `link` is not installed")


@pytest.fixture
def pair() -> Pair:
    made = Pair()
    made.connect()
    return made


def of_the_peer(shown: np.ndarray, ticks: range) -> bool:
    """Whether a motion is, to the bit, one of those sent at these ticks."""
    for tick in ticks:
        t = tick * 1e-3
        sent = np.concatenate([np.sin(20.0 * t + np.arange(3)), 20.0 * np.cos(20.0 * t + np.arange(3))])
        if np.array_equal(sent, shown):
            return True
    return False


# --------------------------------------------------------------------------------------------------- a calm network
def test_what_arrives_is_what_was_sent_to_the_bit_in_both_directions(pair: Pair) -> None:
    for _ in range(50):
        sent_motion, sent_model = pair.motion(), pair.model()
        _, motion = pair.tick()
        assert motion.tobytes() == sent_motion.tobytes()  # the operator ticks first
        pair.now -= PERIOD
        model, _ = pair.tick(telerobot=False)
        assert model.tobytes() == sent_model.tobytes()  # NaN, 'not known yet', too


def test_nothing_of_what_is_said_can_be_read_on_the_way(pair: Pair) -> None:
    pair.tick()
    motion = pair.motion()
    pair.tick()
    on_the_way = b"".join(pair.there.sent)
    assert not any(struct.pack("<d", number) in on_the_way for number in motion)
    assert KEY not in on_the_way


def test_no_two_packets_share_a_sequence_number_under_one_key_and_all_fit_a_frame(pair: Pair) -> None:
    for _ in range(200):
        pair.tick()
    for sent in (pair.there.sent, pair.back.sent):
        of_session = [p for p in sent if wire.read_header(p) and wire.read_header(p)[0] != wire.HELLO]  # type: ignore[index]
        assert len({p[8:16] for p in of_session}) == len(of_session)
        assert max(len(p) for p in sent) <= wire.LARGEST_SIZE
    largest = wire.HEADER_SIZE + wire.TIMES_SIZE + wire.TIME.size + 8 * LARGEST_SIGNAL + wire.TAG_SIZE
    assert largest <= wire.LARGEST_SIZE


def test_age_and_round_trip_are_those_of_the_network(pair: Pair) -> None:
    pair.there.fault = lambda p, now: [(now + 7 * MS, p)]
    pair.back.fault = lambda p, now: [(now + 4 * MS, p)]
    for _ in range(50):
        pair.tick()
    assert status(pair.operator)["round_trip"] == pytest.approx(0.011, abs=1.001e-3)  # read once a tick
    pair.there.fault = lambda p, now: []
    for _ in range(30):
        pair.tick()
    assert status(pair.telerobot)["age"] == pytest.approx(0.030 - 0.007, abs=1.001e-3)


# --------------------------------------------------------------------------------------------------- a rough network
class Rough:
    """Delay, jitter, loss, duplicates and reordering, seeded."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.lost = 0

    def __call__(self, packet: bytes, now: int) -> list[tuple[int, bytes]]:
        draw = self.random
        if draw.random() < 0.1:
            self.lost += 1
            return []
        copies = 2 if draw.random() < 0.1 else 1
        return [(now + 20 * MS + draw.randrange(10 * MS), packet) for _ in range(copies)]


@pytest.mark.parametrize("seed", range(5))
def test_through_jitter_loss_duplicates_and_reordering_the_newest_is_shown_and_never_an_older_one(seed: int) -> None:
    pair = Pair()
    pair.connect()
    rough = pair.there.fault = Rough(seed)
    first, before = pair.ticks[OPERATOR], -1
    newest = 0
    for n in range(1000):
        _, motion = pair.tick()
        if n < 40:
            continue
        candidates = [k for k in range(first + n - 40, first + n) if of_the_peer(motion, range(k, k + 1))]
        assert len(candidates) == 1, "what is shown was never sent, or is too old"
        assert candidates[0] >= before, "an older sample after a newer one"
        before = candidates[0]
        newest += first + n - before <= 27  # of the packets sent 20 to 27 ms ago one has come in 97 % of ticks
    assert newest > 900
    told = status(pair.telerobot)
    assert told["alive"] == 1.0 and told["refused"] == 0.0 and told["stale"] == 0.0
    assert 30 < told["repeated"] < 170
    assert told["overtaken"] > 300
    assert abs(told["lost"] - rough.lost) <= 45  # some are still on their way


@pytest.mark.parametrize("seed", range(3))
def test_a_play_out_buffer_shows_the_motion_at_a_constant_delay(seed: int) -> None:
    pair = Pair(LinkOptions(playout=0.015))
    pair.there.fault = lambda p, now: [(now + 20 * MS, p)]
    for _ in range(200):
        pair.tick()
    pair.there.fault = Rough(seed)
    first, error = pair.ticks[OPERATOR], []
    for n in range(1000):
        _, motion = pair.tick()
        if n > 50:  # the quickest packet took 20 ms, so what was due 35 ms ago is on show
            t = (first + n - 35) * 1e-3
            error.append(np.abs(motion[:3] - np.sin(20.0 * t + np.arange(3))).max())
    # Read at ticks, the quickest packet seems to take up to one tick more. The cubic adds 1e-6 in gaps of a few ms.
    assert np.max(error) < 20.0 * 1.001e-3
    assert np.std(error) < 20.0 * 0.5e-3


def test_samples_late_by_their_sender_s_own_ticks_are_put_right_by_the_buffer() -> None:
    pair = Pair(LinkOptions(playout=0.02))
    pair.connect()
    steps = []
    last = None
    for n in range(1500):
        # The operator's loop stalls for 10 ms now and then, and makes up for it at once.
        burst = 0 if n % 50 in range(40, 50) else (11 if n % 50 == 0 and n else 1)
        for _ in range(burst):
            pair.tick(telerobot=False)
            pair.now -= PERIOD
        _, motion = pair.tick(operator=False)
        if last is not None and n > 300:
            steps.append(motion[0] - last)
        last = motion[0]
    assert np.max(np.abs(steps)) < 20.0 * 1e-3 * 1.01  # one tick's way at the sine's top speed, never ten


# --------------------------------------------------------------------------------------------------------- strangers
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


def test_our_own_packets_reflected_are_refused() -> None:
    pair = Pair()
    pair.connect()
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


def test_greetings_that_are_made_up_cost_a_bounded_time(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at = []
    monkeypatch.setattr("hw.link.endpoint.derive", lambda *a: looked_at.append(a) or bytes(32))
    for _ in range(100):
        for _ in range(20):
            pair.there.inject(wire.header(wire.HELLO, 0, 0) + os.urandom(wire.HELLO_SIZE - wire.HEADER_SIZE))
        sent = pair.motion()
        assert pair.tick()[1].tobytes() == sent.tobytes()
    assert 15 <= len(looked_at) <= 25  # one in 5 ms


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


# ------------------------------------------------------------------------------------------------------ a lost peer
@pytest.mark.parametrize("cut", ["both", "there", "back"])
def test_a_cut_cable_is_told_by_both_ends_and_what_is_shown_falls_to_where_it_is_safe(cut: str) -> None:
    pair = Pair(LinkOptions(timeout=0.05))
    pair.connect()
    for _ in range(20):
        model, motion = pair.tick()
    assert model[2:].tolist() == [1.0, 1.0] and motion[3:].any()
    for name in ("there", "back"):
        if cut in (name, "both"):
            getattr(pair, name).fault = lambda p, now: []
    for _ in range(50):
        pair.tick()
    for _ in range(60):  # the end that still hears learns it from the other one, a timeout later at most
        model, motion = pair.tick()
    assert status(pair.operator)["alive"] == status(pair.telerobot)["alive"] == 0.0
    assert model[2:].tolist() == [0.0, 0.0] and model[1] > 500.0  # no contact, the parameters kept
    assert not motion[3:].any() and motion[:3].any()  # standing still where it was
    assert max(pair.operator.age, pair.telerobot.age) > 0.05
    pair.there.fault = pair.back.fault = lambda p, now: [(now, p)]
    for _ in range(40):
        model, motion = pair.tick()
    assert status(pair.operator)["alive"] == status(pair.telerobot)["alive"] == 1.0
    assert status(pair.operator)["sessions"] == 1.0  # the same session goes on
    assert model[2] == 1.0 and motion[3:].any()


def test_the_peer_counts_as_lost_at_the_first_tick_after_the_timeout() -> None:
    pair = Pair(LinkOptions(timeout=0.05))
    pair.connect()
    pair.tick()
    pair.tick()
    alive = []
    for _ in range(60):
        pair.tick(operator=False)
        alive.append(pair.telerobot.alive)
    assert alive.index(False) == 50  # the last sample came 1 ms before the first of these ticks


def test_a_goodbye_is_heard_at_once(pair: Pair) -> None:
    pair.tick()
    pair.operator.close()
    _, motion = pair.tick(operator=False)
    assert pair.telerobot.ended and not pair.telerobot.alive and pair.telerobot.age == np.inf
    assert not motion[3:].any()


def test_a_peer_that_starts_again_is_taken_once_its_old_self_is_silent(pair: Pair) -> None:
    for _ in range(10):
        pair.tick()
    pair.operator = pair.start(OPERATOR)
    sessions = [(pair.tick(), status(pair.telerobot)["sessions"])[1] for _ in range(300)]
    assert sessions[:95] == [1.0] * 95 and sessions[150:] == [2.0] * 150  # the timeout is 100 ms
    assert pair.telerobot.alive
    sent = pair.motion()
    assert pair.tick()[1].tobytes() == sent.tobytes()


def test_a_second_operator_does_not_take_over_from_one_that_is_there(pair: Pair) -> None:
    copies = Wire(lambda: pair.now)
    pair.back.fault = lambda p, now: [(copies.inject(p), (now, p))[1]]  # type: ignore[func-returns-value]
    second = Link(OPERATOR, SIGNALS, KEY, End(pair.there, copies), clock=lambda: pair.now)
    other = np.full(6, 9.0)
    for _ in range(300):
        second.exchange(0.0, other, np.zeros(4))
        sent = pair.motion()
        _, motion = pair.tick()
        assert motion.tobytes() == sent.tobytes()
    assert status(pair.telerobot)["sessions"] == 1.0


def test_a_flood_costs_a_tick_a_bounded_number_of_packets(pair: Pair) -> None:
    for _ in range(5000):
        pair.there.inject(os.urandom(100))
    before = len(pair.there.flying)
    pair.tick(operator=False)
    assert before - len(pair.there.flying) == 64


# ------------------------------------------------------------------------------------------------------------ clocks
def test_what_stands_behind_a_motion_is_held_between_samples_while_the_motion_goes_on() -> None:
    samples = Samples(np.zeros(3), 10, motion=2)
    for sequence, (due, place, rate, other) in enumerate([(0, 0.0, 1.0, 5.0), (2_000_000_000, 2.0, 1.0, 7.0)]):
        samples.add(sequence, due, np.array([place, rate, other]))
    np.testing.assert_allclose(samples.show(1_500_000_010), [1.5, 1.0, 5.0], atol=1e-12)
    np.testing.assert_allclose(samples.show(2_000_000_010), [2.0, 1.0, 7.0], atol=1e-12)


@pytest.mark.parametrize("playout", [0.0, 0.02])
@pytest.mark.parametrize("step_s", [3600.0, -3600.0, 0.4, -0.4])
def test_a_clock_that_is_set_is_survived(playout: float, step_s: float) -> None:
    pair = Pair(LinkOptions(playout=playout))
    pair.shift[OPERATOR] = pair.shift[TELEROBOT] = 10**13
    pair.connect()
    for _ in range(100):
        pair.tick()
    pair.shift[OPERATOR] += round(step_s * 1e9)
    for _ in range(150):
        pair.tick()
    told = status(pair.telerobot)
    assert told["alive"] == 1.0 and told["sessions"] == 1.0
    assert told["clock_steps"] == 1.0
    if playout == 0.0:
        sent = pair.motion()
        assert pair.tick()[1].tobytes() == sent.tobytes()
        return
    for _ in range(50):
        t = pair.ticks[OPERATOR] * 1e-3 - playout
        _, motion = pair.tick()
        assert np.abs(motion[:3] - np.sin(20.0 * t + np.arange(3))).max() < 20.0 * 1.1e-3  # a tick's way


def test_clocks_that_drift_stay_in_step() -> None:
    pair = Pair(LinkOptions(playout=0.01))
    pair.connect()
    errors = []
    for n in range(8000):
        pair.shift[TELEROBOT] += 100  # 1e-4, ten times what quartz does
        tick = pair.ticks[OPERATOR]
        _, motion = pair.tick()
        if n > 1000:
            t = tick * 1e-3 - 0.010
            errors.append(np.abs(motion[:3] - np.sin(20.0 * t + np.arange(3))).max())
    assert status(pair.telerobot)["clock_steps"] == 0.0
    assert np.max(errors) < 20.0 * 2e-3


# ----------------------------------------------------------------------------------------------------------- refusals
def test_a_peer_with_another_scenario_is_told_apart_and_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = Pair(scenario="another")
    pair.connect()
    for _ in range(50):
        pair.tick()
    assert status(pair.operator)["sessions"] == 0.0
    monkeypatch.setattr(
        "hw.link.link.time.sleep", lambda seconds: setattr(pair, "now", pair.now + round(seconds * 1e9))
    )
    with pytest.raises(BadInput, match="another scenario"):
        pair.operator.connect(3.0)


@pytest.mark.parametrize(
    "bad", [{"timeout": 0.0}, {"timeout": np.nan}, {"oldest": 100.0}, {"playout": -1.0}, {"cloud_points": 0}]
)
def test_limits_that_make_no_sense_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(BadInput, match=next(iter(bad))):
        replace(LinkOptions(), **bad)


def test_signals_that_do_not_fit_a_packet_or_their_masks_are_refused() -> None:
    with pytest.raises(BadInput, match="1 to 128"):
        Signal("large", np.zeros(129))
    with pytest.raises(BadInput, match="velocities"):
        Signal("odd", np.zeros(4), motion=3)
    with pytest.raises(BadInput, match="when_lost"):
        Signal("short", np.zeros(3), when_lost=np.zeros(2))
