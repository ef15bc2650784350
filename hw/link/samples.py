"""Samples shown of the vectors that have arrived: the newest, or what a play-out buffer says."""

from bisect import bisect_right, insort

import numpy as np
from numba import njit

from mmt_drake.model.hermite import cubic, position_at, velocity_at
from mmt_drake.numeric.arrays import Array

_MOST = 4096  # samples in the buffer; a peer that sends more has its oldest dropped


class Samples:
    """Vectors by the times at which they were due at the peer.

    Args:
        initial: (n) what is shown before the first.
        delay: of the play-out buffer [ns]; 0: the newest is shown at once, and older ones never.
        motion: so many numbers at the front are positions and as many velocities, between which the buffer
            interpolates by a cubic; it holds the others.

    Attributes:
        vector: (n) what is shown.
        overtaken: samples that came after a newer one, or their turn in the buffer, had been shown.
        instant: of the peer that is shown, on its clock [ns]; 0 before the first sample.
    """

    def __init__(self, initial: Array, delay: int = 0, *, motion: int = 0) -> None:
        self.vector = initial.copy()
        self.overtaken = self.instant = 0
        self._delay, self._motion = delay, motion
        self._newest = -1  # sequence number of what is shown, without a buffer
        self._times: list[int] = []
        self._vectors: dict[int, Array] = {}
        first = initial[:motion].copy()
        first.flags.writeable = False  # as what comes out of a packet
        between(first, first, 1.0, 0.5, np.zeros(motion))  # compiles before the clock starts

    def clear(self) -> None:
        """Forget what has not been shown: the peer's clock was set."""
        self._newest = -1
        self._times.clear()
        self._vectors.clear()

    def add(self, sequence: int, due: int, vector: Array) -> None:
        """Take a sample that has arrived.

        Args:
            sequence: of its packet.
            due: when its tick was due, on the peer's clock [ns].
            vector: (n).
        """
        if self._delay == 0:
            if sequence < self._newest:
                self.overtaken += 1
                return
            self._newest = sequence
            self.instant = due
            self.vector[:] = vector
            return
        if due in self._vectors or (len(self._times) > 1 and due <= self._times[0]):
            self.overtaken += 1  # the first one is on show
            return
        insort(self._times, due)
        self._vectors[due] = vector
        if len(self._times) > _MOST:
            del self._vectors[self._times.pop(0)]

    def show(self, peer_now: int) -> Array:
        """(n) what is to be shown when it is `peer_now` [ns] at the peer, shortest transit included."""
        if self._delay == 0 or not self._times:
            return self.vector
        turn = peer_now - self._delay
        past = bisect_right(self._times, turn)
        if past == 0:
            return self.vector
        for due in self._times[: past - 1]:
            del self._vectors[due]
        del self._times[: past - 1]
        now = self._times[0]
        self.vector[:] = self._vectors[now]
        self.instant = now
        if len(self._times) == 1 or not self._motion:
            return self.vector
        following = self._times[1]
        self.instant = turn
        gap, since = (following - now) * 1e-9, (turn - now) * 1e-9
        n = self._motion
        between(self._vectors[now][:n], self._vectors[following][:n], gap, since, self.vector[:n])
        return self.vector


@njit(cache=True)
def between(first: Array, second: Array, gap: float, since: float, out: Array) -> None:
    """A motion between two samples of it.

    Args:
        first, second: (2 k) k positions and as many velocities.
        gap: from first to second [s].
        since: from first to what is wanted [s].
        out: (2 k) set to it.
    """
    half = first.shape[0] // 2
    for i in range(half):
        path = cubic(first[i], first[half + i], second[i], second[half + i], gap)
        out[i] = position_at(path, since)
        out[half + i] = velocity_at(path, since)
