"""One end of a link without its socket: handshake, sessions, freshness. Bytes and times go in, bytes come out.

Each start draws a number of 16 random bytes and tells it in HELLO, sealed by a key made of the shared key and that
number. A session's keys are made of the shared key and both sides' numbers. A HELLO recorded earlier can so be played
again, but only makes a *candidate*: what counts is the first packet sealed by the candidate's keys, which nobody can
have made before our own number was drawn. A session whose peer is heard is never given up for another. No session is
ever forgotten, so that its sequence numbers stay taken; and one count of them serves all, so that none is sealed twice.

A HELLO that is made up costs one keyed hash: those of a flood are dropped before a cipher is made, and do not take the
turn of a true one.
"""

import hashlib
import hmac
import math
import os
from collections.abc import Collection
from dataclasses import dataclass, field

from mmt_drake.hw.link import wire
from mmt_drake.hw.link.keys import Cipher, derive
from mmt_drake.hw.link.options import ROLES, Role
from mmt_drake.hw.link.replay import ReplayWindow
from mmt_drake.hw.link.wire import Times

HELLO_INTERVAL = 20_000_000
"""Between two HELLOs while the peer is not heard [ns]."""

_CLOCK_ERROR = 1e-3  # by which the clocks may go apart while the peer holds an echo [s]
_MEETING_INTERVAL = 5_000_000  # between two HELLOs with a true mark that are looked at [ns]: each costs some ciphers
_GREETED = 4  # latest candidates that are greeted
_MOST_SESSIONS = 1024  # starts of the peer that are told apart; more are not met


@dataclass
class Counts:
    """What came in.

    Attributes:
        received: authentic packets, each once.
        repeated: numbers that had been taken, or were too old to tell: duplicates and replays; not applied.
        refused: packets that were no packets of this session: corrupted, forged, of another key; not applied.
        stale: authentic, but possibly older than allowed; not applied.
        sessions: how often a peer began.
    """

    received: int = 0
    repeated: int = 0
    refused: int = 0
    stale: int = 0
    sessions: int = 0


@dataclass(frozen=True, slots=True)
class Packet:
    """An authentic packet that has not been seen before.

    Attributes:
        kind: `wire.DATA` ...
        sequence: its number in the session.
        times: its times; `sent` on the peer's clock.
        body: what follows the times.
        round_trip: since the time of ours that it echoes, less what the peer held it [s]; NaN without an echo. It
            bounds the packet's age.
    """

    kind: int
    sequence: int
    times: Times
    body: bytes
    round_trip: float


@dataclass
class _LinkSession:
    tag: int
    outward: Cipher
    inward: Cipher
    first: int = -1
    taken: int = 0
    window: ReplayWindow = field(default_factory=ReplayWindow)


class Endpoint:
    """One end.

    Args:
        role: which.
        key: the shared key.
        digest: (16 bytes) of what the link carries; a peer with another one is told apart, and not taken.
        timeout: after which a silent peer may be replaced by another start of it [ns].
        oldest: a packet that may be older is not taken [s].
        accepted: digests of peers that are taken; by default the same one.

    Attributes:
        counts: what came in.
        ended: the peer said BYE.
        heard: the peer says that it hears us.
        other_link: the digest of a peer with our key that was heard and is not accepted; empty without one.
    """

    def __init__(
        self, role: Role, key: bytes, digest: bytes, *, timeout: int, oldest: float, accepted: Collection[bytes] = ()
    ) -> None:
        self.counts = Counts()
        self.ended = self.heard = False
        self.other_link = b""
        self._key, self._digest, self._accepted = key, digest, accepted or (digest,)
        self._mine = ROLES.index(role)
        self._start = os.urandom(wire.START_SIZE)
        self._marking = derive(key, b"", "hello mark")
        self._hello = self._hello_cipher(self._start, self._mine)
        self._hellos = 0
        self._next_hello = self._next_meeting = 0
        self._sent = 0  # sequence numbers used, in whatever session
        self._timeout, self._oldest = timeout, oldest
        self._session: _LinkSession | None = None
        self._sessions: dict[bytes, _LinkSession] = {}  # by the peer's start, in the order of meeting
        self._heard = 0  # when the latest authentic packet came [ns, our clock]
        self._echo = 0  # its time of sending, on the peer's clock

    @property
    def has_session(self) -> bool:
        """Whether there is a peer, heard or not."""
        return self._session is not None

    @property
    def lost(self) -> int:
        """Packets of this session that have not come, though later ones have."""
        session = self._session
        return 0 if session is None else session.window.newest + 1 - session.first - session.taken

    def hears(self, now: int) -> bool:
        """Whether an authentic packet came within the timeout."""
        return self._session is not None and not self.ended and now - self._heard <= self._timeout

    def pack(self, kind: int, body: bytes, now: int, surface: int = 0) -> bytes | None:
        """A packet to the peer; None without one."""
        return None if self._session is None else self._seal(self._session, kind, body, now, surface)

    def due(self, now: int) -> list[bytes]:
        """What the handshake has to send by itself now; nothing while the peer is heard."""
        if self.hears(now) or now < self._next_hello:
            return []
        self._next_hello = now + HELLO_INTERVAL
        greeted = list(self._sessions.values())[-_GREETED:]
        return [self._greet(), *(self._seal(session, wire.ALIVE, b"", now) for session in greeted)]

    def receive(self, datagram: bytes, now: int) -> tuple[Packet | None, list[bytes]]:
        """Take in what came from the network, whatever it is.

        Returns:
            The packet, if it is authentic, new and fresh; and what is to be answered.
        """
        head = wire.read_header(datagram)
        if head is None:
            self.counts.refused += 1
            return None, []
        kind, tag, sequence = head
        if kind == wire.HELLO:
            return None, self._meet(datagram, sequence, now)
        return self._take(datagram, kind, tag, sequence, now), []

    def _take(self, datagram: bytes, kind: int, tag: int, sequence: int, now: int) -> Packet | None:
        top, sealed = datagram[: wire.HEADER_SIZE], datagram[wire.HEADER_SIZE :]
        known = False
        for session in self._sessions.values():
            if session.tag != tag:
                continue
            if not session.window.is_new(sequence):
                known = True
                continue
            body = session.inward.open(sequence, top, sealed)
            if body is None or len(body) < wire.TIMES_SIZE:
                continue
            session.window.take(sequence)
            if session is not self._session and not self._begin(session, now):
                return None
            return self._accept(session, kind, sequence, body, now)
        if known:
            self.counts.repeated += 1
        else:
            self.counts.refused += 1
        return None

    def _accept(self, session: _LinkSession, kind: int, sequence: int, body: bytes, now: int) -> Packet | None:
        session.first = sequence if session.first < 0 else min(session.first, sequence)
        session.taken += 1
        times = wire.Times(*wire.TIMES.unpack_from(body))
        round_trip = (now - times.echo - times.held) * 1e-9 if times.echo else math.nan
        # Made after the peer had what it echoes, it is no older than the round trip. Only greetings have no echo. A
        # peer whose clock has been set is right again at its next.
        fresh = kind == wire.ALIVE if times.echo == 0 else -_CLOCK_ERROR <= round_trip <= self._oldest
        if sequence == session.window.newest:
            self._heard, self._echo = now, times.sent
            self.heard = times.echo != 0 and times.held <= self._timeout
        if not fresh:
            self.counts.stale += 1
            return None
        self.counts.received += 1
        self.ended |= kind == wire.BYE
        return Packet(kind, sequence, times, body[wire.TIMES_SIZE :], round_trip)

    def _begin(self, session: _LinkSession, now: int) -> bool:
        """Another session's peer proved to be there; take it, unless the present one's is heard."""
        if self.hears(now):
            self.counts.refused += 1
            return False
        self._session = session
        self._heard, self._echo = now, 0
        self.ended = self.heard = False
        self.counts.sessions += 1
        return True

    def _meet(self, datagram: bytes, sequence: int, now: int) -> list[bytes]:
        """A HELLO: note its sender, and answer if it is new."""
        start = datagram[wire.HEADER_SIZE : wire.HEADER_SIZE + wire.START_SIZE]
        if len(datagram) != wire.HELLO_SIZE or start == self._start:
            self.counts.refused += 1
            return []
        if start in self._sessions:
            return []
        datagram, mark = datagram[: -wire.MARK_SIZE], datagram[-wire.MARK_SIZE :]
        if not hmac.compare_digest(mark, self._mark(datagram)):
            self.counts.refused += 1
            return []
        if now < self._next_meeting or len(self._sessions) >= _MOST_SESSIONS:
            self.counts.refused += 1
            return []
        self._next_meeting = now + _MEETING_INTERVAL
        theirs = 1 - self._mine
        clear = wire.HEADER_SIZE + wire.START_SIZE
        top, sealed = datagram[:clear], datagram[clear:]
        body = self._hello_cipher(start, theirs).open(sequence, top, sealed)
        if body is None or body[0] != theirs:
            self.counts.refused += 1
            return []
        if body[1:] not in self._accepted:
            self.other_link = body[1:]
            self.counts.refused += 1
            return []
        session = self._sessions[start] = self._session_with(start)
        return [self._greet(), self._seal(session, wire.ALIVE, b"", now)]

    def _session_with(self, peer: bytes) -> _LinkSession:
        starts = self._start + peer if self._mine == 0 else peer + self._start
        ciphers = [Cipher(derive(self._key, starts, f"from {role}")) for role in ROLES]
        tag = int.from_bytes(derive(self._key, starts, "tag")[:2], "little")
        return _LinkSession(tag, ciphers[self._mine], ciphers[1 - self._mine])

    def _hello_cipher(self, start: bytes, role: int) -> Cipher:
        return Cipher(derive(self._key, start, f"hello from {ROLES[role]}"))

    def _greet(self) -> bytes:
        sequence, self._hellos = self._hellos, self._hellos + 1
        top = wire.header(wire.HELLO, 0, sequence) + self._start
        hello = top + self._hello.seal(sequence, top, bytes([self._mine]) + self._digest)
        return hello + self._mark(hello)

    def _mark(self, hello: bytes) -> bytes:
        return hashlib.blake2s(hello, digest_size=wire.MARK_SIZE, key=self._marking).digest()

    def _seal(self, session: _LinkSession, kind: int, body: bytes, now: int, surface: int = 0) -> bytes:
        sequence, self._sent = self._sent, self._sent + 1  # 64 bits last for half a billion years at 1 kHz
        known = session is self._session and self._echo != 0
        times = Times(now, self._echo if known else 0, now - self._heard if known else 0, surface)
        top = wire.header(kind, session.tag, sequence)
        return top + session.outward.seal(sequence, top, wire.TIMES.pack(*times) + body)
