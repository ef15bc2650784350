"""One end of a link, socket and all."""

import hashlib
import math
import time
from collections.abc import Callable, Collection, Mapping
from typing import Protocol

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.hw.link import wire
from mmt_drake.hw.link.clouds import CloudCollector, CloudSender
from mmt_drake.hw.link.endpoint import Endpoint, Packet
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions, LinkSignal, Role
from mmt_drake.hw.link.peer_clock import STEP, PeerClock
from mmt_drake.hw.link.samples import Samples
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.signals import LINK_CLOCKS

STATUS = (
    "alive", "age", "round_trip", "received", "lost", "overtaken", "repeated", "refused", "stale", "sessions",
    "clock_steps", "unsent",
)  # fmt: skip
"""What `Link.status` holds; see there."""

_PATIENCE = 1_000_000_000  # with a peer that seems to run another scenario [ns]
# Packets read in one exchange; what a flood leaves in the socket waits, or is dropped by the kernel.
_MOST_AT_ONCE = 128


class DatagramSocket(Protocol):
    """What a link needs of a socket."""

    def send(self, datagram: bytes) -> bool:
        """Send; False if it could not go out."""

    def receive(self) -> bytes | None:
        """The next datagram that has come, without waiting; None if there is none."""

    def close(self) -> None:
        """Give it back."""


class Link(Closing):
    """Sends one vector a tick, shows another, and tells how things stand.

    Args:
        role: which end this is.
        signals: what each role sends.
        key: that both sides share.
        socket: to the peer.
        options: limits.
        scenario: whatever else both sides must agree on, in words.
        clock: [ns], never set; the machine's monotonic clock.

    Attributes:
        options: limits.
        clocks: (5) time stamps of this exchange [s], see `mmt_drake.recording.signals.LINK_CLOCKS`; 0 until known.
        status: (12) see `STATUS`. alive: 1 while samples come, the peer says that it hears us, and it has not said
            goodbye; age of the latest sample's arrival [s], NaN before the first; latest round trip [s], NaN until
            known; and counts: packets received; lost in this session; samples that came too late to be shown;
            duplicates and replays; refused as not authentic, not of this link or malformed; possibly older than
            allowed, or later than the quickest by more than the timeout; sessions; clocks seen to be set, or the way to
            have become longer; packets that the network did not take.
    """

    def __init__(
        self,
        role: Role,
        signals: Mapping[Role, LinkSignal],
        key: bytes,
        socket: DatagramSocket,
        options: LinkOptions = LinkOptions(),  # noqa: B008  (a frozen dataclass)
        *,
        scenario: str = "",
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._socket, self._clock, self.options = socket, clock, options
        self._in = signals[TELEROBOT if role == OPERATOR else OPERATOR]
        self._out_size = signals[role].size
        self._timeout = round(options.timeout * 1e9)
        said = [scenario, *(f"{name} sends {signals[name].name} ({signals[name].size})" for name in signals)]
        steady, self._jumping = _digest(said), _digest([*said, "from a source that may jump"])
        self._endpoint = Endpoint(
            role,
            key,
            self._jumping if signals[role].may_jump else steady,
            timeout=self._timeout,
            oldest=options.oldest,
            accepted={steady, self._jumping} if self._in.may_jump else {steady},
        )
        self._peer_clock = PeerClock(min(STEP, self._timeout))
        self._samples = Samples(self._in.initial, round(options.playout * 1e9), motion=self._in.motion)
        self._arrival: int | None = None  # of the latest sample
        self._began: int | None = None  # when the run's time 0 was due
        self._sessions = 0
        self._surface_of_peer = 0  # that it has complete
        self._to_send = CloudSender(options.cloud_points, round(options.cloud_interval * 1e9))
        self._collector = CloudCollector()
        self._unsent = self._malformed = 0
        self._closed = False
        self._round_trip = math.nan
        self.status: Array = np.zeros(len(STATUS))
        self.clocks: Array = np.zeros(len(LINK_CLOCKS))
        self._tell(clock())

    def connect(self, seconds: float) -> None:
        """Wait for the peer.

        Raises:
            BadInput: there is none within that time, or it runs another scenario.
        """
        begun = self._clock()
        end = begun + round(seconds * 1e9)
        while self._clock() < end:
            self.poll()
            if self._endpoint.has_session and self._endpoint.heard:
                return
            # A recorded greeting played again may look like another link; so the true peer gets its time.
            if self._endpoint.other_link and self._clock() > begun + _PATIENCE:
                if self._endpoint.other_link == self._jumping:
                    expected = "another one, or the switch that lets it move hardware"
                    raise BadInput("--peer", found="a hand on sliders", expected=expected)
                raise BadInput("--peer", found="a peer with another scenario", expected="the same one on both sides")
            self._send(wire.ALIVE, b"")
            time.sleep(0.005)
        found = f"nobody with this key within {seconds:g} s"
        expected = "the other side: started, with the same key, and the address right at both"
        raise BadInput("--peer", found=found, expected=expected)

    @property
    def alive(self) -> bool:
        """Whether the peer was there at the latest exchange."""
        return bool(self.status[0])

    @property
    def age(self) -> float:
        """Since the latest sample of a peer that hears us [s], at the latest exchange; infinite without one."""
        return float(self.status[1]) if self._well and not math.isnan(self.status[1]) else math.inf

    @property
    def _well(self) -> bool:
        return self._endpoint.heard and not self._endpoint.ended

    @property
    def ended(self) -> bool:
        """Whether the peer said goodbye."""
        return self._endpoint.ended

    @property
    def cloud(self) -> Cloud:
        """The peer's newest surface."""
        return self._collector.cloud

    def offer_cloud(self, cloud: Cloud) -> None:
        """The surface as it is now, to be sent with the coming exchanges."""
        self._to_send.offer(cloud, self._clock())

    def exchange(self, tick: float, vector: Array | None, shown: Array) -> None:
        """One tick: read what has come, send.

        Samples carry the time at which their tick was due, so that a play-out buffer takes out the lateness of both
        sides' ticks together with the network's.

        Args:
            tick: its time in the run [s].
            vector: (n) to be sent, as this side's `LinkSignal`; None: there is none, the peer sees the latest grow old.
            shown: (m) set to what is to be shown of the peer's; while it is lost, to what its `when_lost` says.

        Raises:
            ValueError: the vector is of another size.
        """
        if vector is not None and vector.size != self._out_size:  # which the peer would refuse
            raise ValueError(f"the link sends {self._out_size} numbers, not {vector.size}")
        self.poll()
        now, since = self._clock(), round(tick * 1e9)
        if self._began is None or abs(now - since - self._began) > STEP:
            self._began = now - since  # the first tick; or our clock was set, or the run cannot keep pace with it
        due = self._began + since
        if vector is None:
            self._send(wire.ALIVE, b"")
        else:
            self._send(wire.DATA, wire.TIME.pack(due) + vector.astype("<f8").tobytes())
        translation = self._to_send.translation()
        if translation is not None:
            self._send(wire.TRANSLATION, translation)
        block = self._to_send.block(self._surface_of_peer)
        if block is not None:
            self._send(wire.BLOCK, block)
        self._tell(now)
        shown[:] = self._samples.show(due - self._peer_clock.offset)
        self.clocks[0], self.clocks[4] = 1e-9 * due, 1e-9 * self._samples.instant
        if not self.alive and self._arrival is not None:
            falls = ~np.isnan(self._in.when_lost)
            shown[falls] = self._in.when_lost[falls]

    def poll(self) -> None:
        """Read what has come, and greet a peer that is not there."""
        for _ in range(_MOST_AT_ONCE):
            datagram = self._socket.receive()
            if datagram is None:
                break
            packet, answers = self._endpoint.receive(datagram, self._clock())
            for answer in answers:
                self._put(answer)
            if packet is not None:
                self._take(packet)
        for datagram in self._endpoint.due(self._clock()):
            self._put(datagram)

    def close(self) -> None:
        """Say goodbye and give the socket back. A second call does nothing."""
        if self._closed:
            return
        self._closed = True
        for _ in range(3):  # one may be lost; the peer's timeout is behind them
            self._send(wire.BYE, b"")
        self._socket.close()

    def _take(self, packet: Packet) -> None:
        now = self._clock()
        if self._endpoint.counts.sessions != self._sessions:
            self._sessions = self._endpoint.counts.sessions
            steps = self._peer_clock.steps
            self._peer_clock = PeerClock(min(STEP, self._timeout))  # another start of the peer, perhaps another machine
            self._peer_clock.steps = steps
            self._samples.clear()
            self._collector.clear()
            self._surface_of_peer = 0
        if self._peer_clock.note(packet.times.sent, now):
            self._samples.clear()
        if now - packet.times.sent - self._peer_clock.offset > self._timeout:  # as if it had not come
            self._endpoint.counts.stale += 1
            return
        self._round_trip = packet.round_trip
        self._surface_of_peer = max(self._surface_of_peer, packet.times.surface)
        accepted = True
        if packet.kind == wire.DATA:
            accepted = self._take_sample(packet, now)
        elif packet.kind == wire.TRANSLATION:
            accepted = self._collector.add_translation(packet.body, packet.sequence)
        elif packet.kind == wire.BLOCK:
            accepted = self._collector.add_block(packet.body)
        self._malformed += not accepted

    def _take_sample(self, packet: Packet, now: int) -> bool:
        if len(packet.body) != wire.TIME.size + 8 * self._in.size:
            return False
        (due,) = wire.TIME.unpack_from(packet.body)
        vector = np.frombuffer(packet.body, dtype="<f8", offset=wire.TIME.size)
        if not np.all(np.isfinite(vector) | (np.isnan(vector) & self._in.may_be_nan)):
            return False
        self._samples.add(packet.sequence, due, vector)
        self._arrival = now
        self.clocks[1:4] = 1e-9 * due, 1e-9 * packet.times.sent, 1e-9 * now
        return True

    def _send(self, kind: int, body: bytes) -> None:
        datagram = self._endpoint.pack(kind, body, self._clock(), self._collector.number)
        if datagram is not None:
            self._put(datagram)

    def _put(self, datagram: bytes) -> None:
        self._unsent += not self._socket.send(datagram)

    def _tell(self, now: int) -> None:
        counts, status = self._endpoint.counts, self.status
        age = math.nan if self._arrival is None else now - self._arrival
        status[0] = float(age <= self._timeout and self._well)
        status[1:3] = 1e-9 * age, self._round_trip
        status[3:6] = counts.received, self._endpoint.lost, self._samples.overtaken
        status[6:9] = counts.repeated, counts.refused + self._malformed, counts.stale
        status[9:] = counts.sessions, self._peer_clock.steps, self._unsent


def _digest(said: Collection[str]) -> bytes:
    return hashlib.sha256("\n".join(sorted(said)).encode()).digest()[: wire.DIGEST_SIZE]
