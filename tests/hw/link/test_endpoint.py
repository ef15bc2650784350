"""Whose packets an end takes, one packet at a time."""

import pytest
from link_samples import KEY

from mmt_drake.hw.link import wire
from mmt_drake.hw.link.endpoint import HELLO_INTERVAL, Endpoint
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, Role

MS = 1_000_000
DIGEST = bytes(16)


def end(role: Role) -> Endpoint:
    return Endpoint(role, KEY, DIGEST, timeout=100 * MS, oldest=1.0)


def pour(packets: list[bytes], into: Endpoint, now: int) -> list[bytes]:
    """What an end answers to packets."""
    return [answer for packet in packets for answer in into.receive(packet, now)[1]]


def greet(one: Endpoint, two: Endpoint, now: int) -> None:
    """Let both ends meet: greetings and answers until nobody has more to say."""
    said = one.due(now)
    for _ in range(4):
        said = pour(said, two, now)
        said = pour(said, one, now)
    assert one.has_session or two.has_session


@pytest.fixture
def ends() -> tuple[Endpoint, Endpoint]:
    made = end(OPERATOR), end(TELEROBOT)
    greet(*made, 10 * MS)
    for k in range(3):
        for mine, theirs in (made, made[::-1]):
            packet = mine.pack(wire.ALIVE, b"", (20 + k) * MS)
            if packet is not None:
                theirs.receive(packet, (20 + k) * MS)
    assert all(item.has_session and item.heard for item in made)
    return made


def test_a_sample_is_taken_once_with_its_body_and_times(ends: tuple[Endpoint, Endpoint]) -> None:
    sender, receiver = ends
    datagram = sender.pack(wire.DATA, b"body", 30 * MS, surface=7)
    assert datagram is not None
    packet, answers = receiver.receive(datagram, 34 * MS)
    assert packet is not None and not answers
    assert (packet.kind, packet.body, packet.times.sent, packet.times.surface) == (wire.DATA, b"body", 30 * MS, 7)
    assert packet.round_trip == pytest.approx(34e-3 - 22e-3 - packet.times.held * 1e-9)
    assert receiver.receive(datagram, 35 * MS) == (None, [])
    assert receiver.counts.repeated == 1


def test_what_an_end_has_sent_itself_it_never_takes_whatever_the_number(ends: tuple[Endpoint, Endpoint]) -> None:
    for each in ends:
        refused = each.counts.refused
        for _ in range(50):  # numbers that the peer has never used
            datagram = each.pack(wire.DATA, b"", 30 * MS)
            assert datagram is not None and each.receive(datagram, 30 * MS) == (None, [])
        assert each.counts.refused + each.counts.repeated >= refused + 45


def test_a_sample_that_echoes_nothing_is_not_taken(ends: tuple[Endpoint, Endpoint]) -> None:
    sender, receiver = ends
    sender._echo = 0  # a peer that has never heard us, and so may have made this at any time
    datagram = sender.pack(wire.DATA, b"", 30 * MS)
    assert datagram is not None and receiver.receive(datagram, 30 * MS)[0] is None
    assert receiver.counts.stale == 1
    greeting = sender.pack(wire.ALIVE, b"", 31 * MS)
    assert greeting is not None and receiver.receive(greeting, 31 * MS)[0] is not None


def test_an_end_of_the_same_side_is_not_met() -> None:
    one, two = end(OPERATOR), end(OPERATOR)
    assert not pour(one.due(MS), two, MS)
    assert two.counts.refused == 1 and not two.has_session


def test_greetings_go_out_at_their_interval_and_only_while_the_peer_is_not_heard(
    ends: tuple[Endpoint, Endpoint],
) -> None:
    each = ends[0]
    assert each.due(30 * MS) == []
    silent = 300 * MS
    said = [now for now in range(silent, silent + 100 * MS, MS) if each.due(now)]
    assert said == list(range(silent, silent + 100 * MS, HELLO_INTERVAL))


def test_all_numbers_under_all_keys_of_one_start_are_different(ends: tuple[Endpoint, Endpoint]) -> None:
    each = ends[0]
    sent = []
    for k in range(6):  # the peer starts over and over, and each start is greeted
        now = (1000 + 300 * k) * MS
        peer = end(TELEROBOT)
        answers = pour(peer.due(now), each, now)
        sent += answers + each.due(now)
        pour(answers, peer, now)
        greeting = peer.pack(wire.ALIVE, b"", now)
        if greeting is not None:
            each.receive(greeting, now)
        sent += [datagram for _ in range(5) if (datagram := each.pack(wire.DATA, b"", now)) is not None]
    numbers = [wire.read_header(datagram) for datagram in sent]
    of_sessions = [head[2] for head in numbers if head is not None and head[0] != wire.HELLO]
    greetings = [head[2] for head in numbers if head is not None and head[0] == wire.HELLO]
    assert len(set(of_sessions)) == len(of_sessions) > 30
    assert len(set(greetings)) == len(greetings) >= 6
    assert each.counts.sessions == 7
