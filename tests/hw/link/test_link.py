"""What one end sends the other shows, whatever the network does; what is not the peer's is never shown."""

import random
import struct
from dataclasses import replace

import numpy as np
import pytest
from link_samples import KEY, PERIOD, SIGNALS, Pair, status

from mmt_drake.errors import BadInput
from mmt_drake.hw.link import wire
from mmt_drake.hw.link.options import LARGEST_SIGNAL, OPERATOR, TELEROBOT, LinkOptions, LinkSignal

MS = 1_000_000


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


def test_a_vector_that_the_peer_would_refuse_is_not_sent(pair: Pair) -> None:
    with pytest.raises(ValueError, match="the link sends 6 numbers, not 7"):
        pair.operator.exchange(0.0, np.zeros(7), np.zeros(4))


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


# ----------------------------------------------------------------------------------------------------------- refusals
@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("taken", [False, True])
def test_a_source_that_may_jump_is_taken_by_an_end_that_says_so_alone(
    jumps: bool, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    pair = Pair()
    for role, flag in ((OPERATOR, jumps), (TELEROBOT, taken)):
        signals = {**SIGNALS, OPERATOR: replace(SIGNALS[OPERATOR], may_jump=flag)}
        monkeypatch.setattr("link_samples.SIGNALS", signals)
        setattr(pair, role, pair.start(role))
    pair.connect()
    assert status(pair.telerobot)["sessions"] == (taken or not jumps)
    motion = pair.tick()[1]
    assert motion.any() == (taken or not jumps)
    if jumps and not taken:

        def greet(seconds: float) -> None:
            pair.tick(telerobot=False)
            pair.now += round(seconds * 1e9)

        monkeypatch.setattr("mmt_drake.hw.link.link.time.sleep", greet)
        with pytest.raises(BadInput, match="a hand on sliders"):
            pair.telerobot.connect(5.0)


def test_a_peer_with_another_scenario_is_told_apart_and_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = Pair(scenario="another")
    pair.connect()
    for _ in range(50):
        pair.tick()
    assert status(pair.operator)["sessions"] == 0.0
    monkeypatch.setattr(
        "mmt_drake.hw.link.link.time.sleep", lambda seconds: setattr(pair, "now", pair.now + round(seconds * 1e9))
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
        LinkSignal("large", np.zeros(129))
    with pytest.raises(BadInput, match="velocities"):
        LinkSignal("odd", np.zeros(4), motion=3)
    with pytest.raises(BadInput, match="when_lost"):
        LinkSignal("short", np.zeros(3), when_lost=np.zeros(2))
