"""Windows of a driven body's recording, each simulated from a state that is fitted in a lead-in which is not scored.

A body that nothing holds integrates: the smallest error of its input drifts, and a whole record simulated in one go
shows that alone. Windows show what the model does within each. The record is cut into blocks of equal length, of which
a third is held out; a block is one window. Its lead-in is the end of the block before it, unless that is held out:
then it is the block's own beginning. What laws remember there comes of all motion before it: as it was measured, and in
blocks that are held out as it is simulated. So no held-out sample sets a state that is scored.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mmt_drake.model import driven_body
from mmt_drake.numeric.arrays import Array, Flags

Numbers = NDArray[np.intp]

FEWEST, MOST, EVERY = 6, 120, 3
"""Blocks of a record; one of every so many is held out."""
LEAD = 0.1
"""Length of a lead-in over that of a window."""
LEAST_LEAD = 8
"""Samples of a lead-in."""
WHOLE = 12
"""Blocks where the whole record is one window."""

_GUESS_WEIGHT = 1e-4
_SURE, _AT_REST = 2.0, 0.03  # deviations; over the RMS of the rate, the most that counts as rest
_SLOW = 0.1  # over the mean rate in a lead-in: the body as good as rests


@dataclass(frozen=True)
class Windows:
    """The windows of one recording.

    Attributes:
        rows: (w, 4) samples of each: the first, where the lead-in ends, the first that is scored, where it ends. A
            window without a lead-in starts at rest.
        kept: (w,) whether it is simulated.
        used: (n,) samples that may set a state.
        guess: (w, 2) position and rate at the first sample, from the lead-in alone.
        weight: (w, 2) what the guess counts beside the lead-in, which keeps a fit of a state that hardly shows near it.
        length: of a window [s].
    """

    rows: Numbers
    kept: Flags
    used: Flags
    guess: Array
    weight: Array
    length: float

    @property
    def count(self) -> int:
        """How many are simulated."""
        return int(self.kept.sum())

    @property
    def scored(self) -> Flags:
        """(n,) samples that are simulated, and not to fit a state."""
        flags = np.zeros(len(self.used), dtype=bool)
        for _, _, first, end in self.rows[self.kept]:
            flags[first:end] = True
        return flags

    def scoring(self, wanted: Flags) -> Windows:
        """Those that score any of the samples (n,) wanted."""
        any_of = np.array([wanted[first:end].any() for _, _, first, end in self.rows], dtype=bool)
        return replace(self, kept=self.kept & any_of)

    def every(self, often: int) -> Windows:
        """One of every so many."""
        return replace(self, kept=self.kept & ((np.cumsum(self.kept) - 1) % often == 0))

    @property
    def at_rest(self) -> bool:
        """True if no state is fitted."""
        return bool(np.all(self.rows[:, 0] == self.rows[:, 1]))

    def replay(
        self, measured: Array, time: Array, u: Array, load: Array, p: Array, output: Array, rate: Array, states: Array
    ) -> None:
        """`driven_body.replay_windows` of these."""
        windows = self.rows, self.kept, self.used, self.guess, self.weight
        driven_body.replay_windows(*windows, measured, time, u, load, p, output, rate, states)

    @classmethod
    def whole(cls, time: Array, output: Array, fitted: bool = False) -> Windows:
        """One window: at rest at the first sample, or from a state fitted to all that is not held out.

        Args:
            time: (n,) [s].
            output: (n,) measured.
            fitted: whether the state is fitted.
        """
        count = len(time)
        used = ~in_blocks(time, np.arange(WHOLE) % EVERY == EVERY - 1)
        guess, weight = np.array([[float(output[0]), 0.0]]), np.zeros((1, 2))
        lead = 0
        if fitted and count >= LEAST_LEAD:
            lead = count
            guess[0], weight[0] = _first(time, output)
        length = float(time[-1] - time[0])
        rows = np.array([[0, lead, 0, count]], dtype=np.intp)
        return cls(rows, np.ones(1, dtype=bool), used, guess, weight, length)

    @classmethod
    def of(cls, time: Array, output: Array, length: float | None, margin: float = 0.0, fitted: bool = False) -> Windows:
        """The windows of a recording.

        Args:
            time: (n,) [s].
            output: (n,) measured.
            length: about that of each [s]; None is the whole record.
            margin: between a lead-in and held-out samples [s], as far as a filter smears one into the other.
            fitted: as of `whole`.
        """
        if length is None:
            return cls.whole(time, output, fitted)
        duration = float(time[-1] - time[0])
        blocks = blocks_of(time, length)
        edges = time[0] + duration * np.arange(blocks + 1) / blocks
        edges[-1] = np.inf
        lead, held = LEAD * duration / blocks, held_blocks(blocks)
        rows = []
        for k in range(blocks):
            own = k == 0 or held[k - 1]
            first = edges[k] + margin * (k > 0) if own else edges[k] - margin - lead
            at = np.searchsorted(time, [first, first + lead, first + lead if own else edges[k], edges[k + 1]])
            rows.append(at)
        table = np.array([row for row in rows if row[3] > row[2]], dtype=np.intp)
        found = [_guess(time, output, int(first), int(end)) for first, end in table[:, :2]]
        guess, weight = (np.array([pair[i] for pair in found]) for i in (0, 1))
        kept, used = np.ones(len(table), dtype=bool), np.ones(len(time), dtype=bool)
        return cls(table, kept, used, guess, weight, duration / blocks)


def blocks_of(time: Array, length: float) -> int:
    """Blocks of about a length [s] that a record is cut into: a multiple of `EVERY`, between FEWEST and MOST."""
    most = min(MOST, int(LEAD * len(time) / LEAST_LEAD))
    wanted = round((time[-1] - time[0]) / length / EVERY)
    return max(min(wanted, most // EVERY) * EVERY, FEWEST)


def held_blocks(blocks: int) -> Flags:
    """(blocks,) which are held out: one of every `EVERY`, and never two in a row.

    Whether the second or the last one has no period (the sequence of Thue and Morse): where a machine repeats its
    motion, a regular choice would hold out the same parts of it again and again.
    """
    flags = np.zeros(blocks, dtype=bool)
    for turn in range(blocks // EVERY):
        flags[EVERY * turn + EVERY - 1 - turn.bit_count() % 2] = True
    return flags


def in_blocks(time: Array, chosen: Flags) -> Flags:
    """(n,) which samples lie in the chosen ones of blocks of equal length."""
    part = (time - time[0]) / (time[-1] - time[0])
    return chosen[np.minimum((part * len(chosen)).astype(np.intp), len(chosen) - 1)]


def sets_out(time: Array, output: Array) -> bool:
    """True if a body must be taken to be in motion at the first sample: no stretch of its output (n,) says it rests."""
    if len(time) < LEAST_LEAD:
        return False
    least = min(abs(solution[1]) + _SURE * deviation for _, solution, deviation in _beginnings(time, output))
    return bool(least > _AT_REST * np.sqrt(np.mean(np.gradient(output, time) ** 2)))


def _first(time: Array, output: Array) -> tuple[Array, Array]:
    """The result of `_guess`, at the first sample, from the stretch whose cubic says the rate best."""
    end, solution, _ = min(_beginnings(time, output), key=lambda found: found[2])
    return solution[:2], _weight(time[:end])


def _beginnings(time: Array, output: Array) -> list[tuple[int, Array, float]]:
    """Number of the first samples, their `_cubic`, and the deviation of its rate: of stretches each half the last."""
    found, end = [], len(time) // (2 * WHOLE)
    while True:
        end = max(end, LEAST_LEAD)
        found.append((end, *_cubic(time, output, end)))
        if end == LEAST_LEAD:
            return found
        end //= 2


def _cubic(time: Array, output: Array, end: int) -> tuple[Array, float]:
    """The cubic through the first samples, lowest power (of the time since the first) first; deviation of its rate."""
    solution, powers, span = _polynomial(time[:end], output[:end], 3)
    left = output[:end] - powers @ solution
    variance = left @ left / max(end - 4, 1) * np.linalg.pinv(powers.T @ powers)[1, 1]
    return solution / span ** np.arange(4), float(np.sqrt(variance)) / span


def _guess(time: Array, output: Array, first: int, end: int) -> tuple[Array, Array]:
    """Position and rate (2,) at the first of some samples by a parabola, and their weights (2,) beside the samples.

    A body that is still at rest there and then sets out draws none. Friction would take the parabola's rate off at
    once, and no fit of the state finds its way from there: where it moves, and the first samples say that it as good as
    rests, it begins at rest.
    """
    if end - first < LEAST_LEAD // 2:  # a gap: nothing to fit
        return np.array([output[first], 0.0]), np.zeros(2)
    solution, _, span = _polynomial(time[first:end], output[first:end], 2)
    state, slow = np.array([solution[0], solution[1] / span]), _SLOW * float(np.ptp(output[first:end])) / span
    few = slice(first, min(first + LEAST_LEAD, end))
    if abs(state[1]) > slow and _rests(time[few], output[few], slow):
        state = np.array([np.mean(output[few]), 0.0])
    return state, _weight(time[first:end])


def _rests(time: Array, output: Array, slow: float) -> bool:
    """Whether some samples' mean rate is surely no more than slow."""
    solution, powers, span = _polynomial(time, output, 1)
    left = output - powers @ solution
    deviation = np.sqrt(12.0 / len(time) * (left @ left) / (len(time) - 2))  # of a slope over evenly spaced samples
    return bool(abs(solution[1]) + _SURE * deviation <= slow * span)


def _weight(time: Array) -> Array:
    """Weights (2,) of a guessed position and rate beside the samples that they are guessed from."""
    return _GUESS_WEIGHT * len(time) * np.array([1.0, (time[-1] - time[0]) ** 2 / 12.0])


def _polynomial(time: Array, output: Array, degree: int) -> tuple[Array, Array, float]:
    """Least squares over samples: coefficients and (n, degree + 1) powers of the part of the span [s] that is over."""
    span = float(time[-1] - time[0])
    powers = np.vander((time - time[0]) / span, degree + 1, increasing=True)
    return np.linalg.lstsq(powers, output, rcond=None)[0].astype(np.float64), powers, span
