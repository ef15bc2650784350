"""The samples that are fitted: what was measured, and what of it drives the model.

A window is never changed, so Drake need not copy it with its contexts: `Window.extended` and `Window.shortened` give
new ones.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from mmt_drake.estimation.output_error.smoothing import FilterBank
from mmt_drake.estimation.output_error.unsure_touches import begins_and_ends, since_touch
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.numeric.layout import Layout

# Columns of a sample: means of what was measured over its time; 1 where all of them are good.
_next = Layout()
POSITION, VELOCITY, FORCE = map(_next.part, (3, 3, 3))
CONTACT, MOTION_GOOD, FORCE_GOOD = _next(), _next(), _next.part(3)
STAMP = _next()  # when the motion of its first tick was sent
TAKEN = _next()  # the middle of its time, by the estimator's clock
SAMPLE_SIZE = _next.size

_SEARCH_S = 0.05  # a change of the contact flag and the crossing of the surface as it is seen are not farther apart
_BLIND = 2  # samples about a touch or a release that are not compared, however certain it is
_UNSURE = 0.5  # deviations of the surface's height, in whose time about a touch or a release the force is not compared
SHORT_GAP = 4
"""Samples of motion that may be missing without the body getting lost."""
_SETTLING_S = 0.3  # after a longer gap: what the body did meanwhile is forgotten
_SEGMENT = 20  # samples over which noise is taken as even
_MEDIAN = 0.6745  # of the absolute value of what has a normal distribution, over its deviation
_OVER_NOISE, _PART = 1.5, 0.005  # of the noise, of the force
_QUIET = 0.2  # share of the segments that hold nothing but noise
_SHAKES = np.random.default_rng(0).standard_normal((4099, 2))


@dataclass(frozen=True)
class Window:
    """Samples on an even clock, the oldest first.

    Attributes:
        samples: (n, SAMPLE_SIZE) in the columns above [m, m/s, N, s]; gaps in the motion are bridged.
        motion: (n, 6) position and velocity, smoothed [m], [m/s].
        shaken: (n, 6) the same, as it would be with as much noise on x and y again.
        number: (n,) of each sample, from the first that there ever was.
        noise: (n, 3) square of what is not motion in each position [m^2].
        contact: (n,) 1 in contact, else 0.
        switch: (n,) where the contact differs from the sample before: the share of the time from that one at which it
            changes.
        weight: (n, 3) 1 where the force along each axis is compared.
        height: (n,) of the surface over where it is seen, as the contact nearest to the sample tells it [m].
        unsure: (n,) standard deviation of that [m]; 0: taken for certain.
    """

    samples: Array
    motion: Array
    shaken: Array
    number: Array
    noise: Array
    contact: Array
    switch: Array
    weight: Array
    height: Array
    unsure: Array

    @classmethod
    def empty(cls) -> Self:
        """No sample."""
        none = np.zeros(0)
        motion = np.zeros((0, 6))
        axes = np.zeros((0, 3))
        return cls(np.zeros((0, SAMPLE_SIZE)), motion, motion, none, axes, none, none, axes, none, none)

    def __len__(self) -> int:
        return len(self.samples)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def extended(self, new: Array, h: float, bank: FilterBank) -> "Window":
        """With new samples (k, SAMPLE_SIZE) at the end, h [s] apart."""
        samples = np.concatenate([self.samples, new])
        begin = max(0, len(self) - 2 * bank.reach)  # what is older stays as it is
        gap = np.flatnonzero(samples[:, MOTION_GOOD] == 0.0)
        if len(gap) and (open_since := _open_gap(self.samples)) < begin:
            begin = open_since
        _bridge(samples, begin, h)
        first = max(0, begin - 2 * bank.reach)
        motion, noise = samples[:, :6].copy(), np.zeros((len(samples), 3))
        motion[:begin], noise[:begin] = self.motion[:begin], self.noise[:begin]
        number = np.arange(len(samples)) + (self.number[0] if len(self) else 0.0)
        for i in range(3):
            noise[begin:, i] = bank.noise(samples[first:, i])[begin - first :]
        deviation = _quiet(noise)
        for i in range(3):
            x, v = bank.smooth(samples[first:, i], samples[first:, 3 + i], float(deviation[i]))
            motion[begin:, i], motion[begin:, 3 + i] = x[begin - first :], v[begin - first :]
        shaken = motion.copy()
        shaken[:begin] = self.shaken[:begin]
        for i in range(2):
            again = math.sqrt(deviation[i]) * _SHAKES[number[first:].astype(int) % len(_SHAKES), i]
            x, v = bank.smooth(samples[first:, i] + again, samples[first:, 3 + i], 2.0 * float(deviation[i]))
            shaken[begin:, i], shaken[begin:, 3 + i] = x[begin - first :], v[begin - first :]
        height, unsure = _as_last(self.height, len(new)), _as_last(self.unsure, len(new))
        contact, switch, weight = _compared(samples, motion, height, unsure, h)
        return Window(samples, motion, shaken, number, noise, contact, switch, weight, height, unsure)

    def at_heights(self, height: Array, unsure: Array, h: float) -> "Window":
        """With the surface as high as contacts (c,) tell it, one at least, and standard deviations of that, both [m].

        A touch or release is then where the probe crosses that. About it the force is not compared as long as it is
        most unsure in which samples it was.
        """
        begins, ends = begins_and_ends(self.contact)
        between = (ends[:-1] + begins[1:]) // 2
        times = np.diff(np.concatenate([[0], between, [len(self)]]))
        height, unsure = np.repeat(height, times), np.repeat(unsure, times)
        contact, switch, weight = _compared(self.samples, self.motion, height, unsure, h)
        return replace(self, contact=contact, switch=switch, weight=weight, height=height, unsure=unsure)

    def unexplained(self) -> float:
        """How much a good fit may leave of the force along x and y [N]: its noise, or a small part of it.

        0 without contact.
        """
        force, weight = self.samples[:, FORCE][:, :2], self.weight[:, :2]
        compared = weight[3:] * weight[:-3] > 0.0
        if not compared.any():
            return 0.0
        noise = white_noise(force, compared)
        return max(_OVER_NOISE * noise, _PART * float(np.sqrt(np.mean(force[weight > 0.0] ** 2))))

    def largest_force(self) -> float:
        """Largest measured force along x and y where it is compared [N]; 0 without contact."""
        size = np.linalg.norm(self.samples[:, FORCE][:, :2] * self.weight[:, :2], axis=1)
        return float(size.max(initial=0.0))

    def shortened(self, count: int) -> Self:
        """Without the first `count` samples."""
        return self.part(slice(count, None))

    def not_compared(self, count: int) -> Self:
        """With the force of the first `count` samples left out of what is compared, now and later."""
        found = self.part(slice(None))
        found.samples[:count, FORCE_GOOD] = found.weight[:count] = 0.0
        return found

    def part(self, span: slice) -> Self:
        """Some of the samples, copied."""
        return replace(self, **{name: getattr(self, name)[span].copy() for name in self.__dataclass_fields__})


def white_noise(values: Array, counted: Flags | None = None) -> float:
    """Deviation of the white noise on signals (n, k), by the third differences; next to nothing of a motion is in it.

    Args:
        values: the signals.
        counted: (n - 3, k) which of the differences count; all by default.
    """
    differences = np.abs(np.diff(values, 3, axis=0))
    if counted is not None:
        differences = differences[counted]
    return float(np.median(differences)) / (_MEDIAN * 20.0**0.5) if differences.size else 0.0


def _as_last(values: Array, count: int) -> Array:
    """Values with so many more like the last one; zeros where there is none."""
    return np.append(values, np.full(count, values[-1] if len(values) else 0.0))


def _open_gap(samples: Array) -> int:
    """Where a gap in the motion that reaches to the end begins; the length where there is none."""
    good = np.flatnonzero(samples[:, MOTION_GOOD] != 0.0)
    return int(good[-1]) + 1 if len(good) else 0


def _bridge(samples: Array, begin: int, h: float) -> None:
    """Bridge gaps in the motion by the cubic through their ends; one that is still open by standing still. In place."""
    good = samples[:, MOTION_GOOD] != 0.0
    if good[begin:].all() or not good.any():
        return
    gone, known = np.flatnonzero(~good[begin:]) + begin, np.flatnonzero(good)
    known = known[max(0, np.searchsorted(known, gone[0]) - 1) :]  # from where the first gap begins
    nearest = np.clip(gone, known[0], known[-1])
    samples[gone, POSITION], samples[gone, VELOCITY] = samples[nearest, POSITION], 0.0
    inside = gone[nearest == gone]
    if len(inside):
        cubic = CubicHermiteSpline(known * h, samples[known, POSITION], samples[known, VELOCITY])
        samples[inside, POSITION], samples[inside, VELOCITY] = cubic(inside * h), cubic(inside * h, 1)


def _quiet(noise: Array) -> Array:
    """Variance of the noise on each position (3,): the mean over the quietest segments."""
    whole = noise[: len(noise) // _SEGMENT * _SEGMENT]
    means = whole.reshape(-1, _SEGMENT, 3).mean(axis=1)
    means = means[means.any(axis=1)]
    return np.quantile(means, _QUIET, axis=0) if len(means) else np.zeros(3)


def _compared(samples: Array, motion: Array, height: Array, unsure: Array, h: float) -> tuple[Array, Array, Array]:
    """Contact, switch and weight of a `Window`, from what else is in it."""
    contact, switch = _touches(samples[:, CONTACT] >= 0.5, motion[:, 2] - height, height, motion[:, 5], h)
    return contact, switch, _weight(samples, contact, motion[:, 5], unsure, h)


def _touches(flag: Flags, z: Array, height: Array, rate: Array, h: float) -> tuple[Array, Array]:
    """Contact (n,), and where in its interval it changes (n,): where the probe crosses the surface, if that is near.

    Args:
        flag: (n,) contact as it is told.
        z: (n,) of the probe above the surface [m].
        height: (n,) of the surface over where whoever tells it sees it [m].
        rate: (n,) of the probe's z [m/s].
        h: time between samples [s].
    """
    contact, switch = flag.astype(np.float64), np.ones(len(flag))
    changes = np.flatnonzero(flag[1:] != flag[:-1]) + 1
    below = z < 0.0
    crossings = np.flatnonzero(below[1:] != below[:-1]) + 1
    last = 0
    for k in changes:
        reach = (_SEARCH_S + abs(since_touch(height[k], rate[k]))) / h
        same = crossings[(below[crossings] == flag[k]) & (np.abs(crossings - k) <= reach) & (crossings > last)]
        if len(same):
            j = int(same[np.argmin(np.abs(same - k))])
            contact[min(j, k) : max(j, k)] = float(flag[k]) if j < k else float(flag[k - 1])
            switch[j] = z[j - 1] / (z[j - 1] - z[j])
            last = j
    return contact, switch


def _weight(samples: Array, contact: Array, rate: Array, unsure: Array, h: float) -> Array:
    """Where the force along each axis is compared, (n, 3) of 0 and 1.

    `rate` (n,) is that of the probe's z [m/s], `unsure` (n,) the standard deviation of the surface's height [m].
    """
    weight = samples[:, FORCE_GOOD] * (contact * samples[:, MOTION_GOOD])[:, np.newaxis]
    for k in np.flatnonzero(contact[1:] != contact[:-1]) + 1:
        blind = _BLIND + math.ceil(since_touch(_UNSURE * unsure[k], rate[k]) / h)
        weight[max(0, k - blind) : k + blind] = 0.0
    gone = samples[:, MOTION_GOOD] == 0.0
    ends = np.flatnonzero(gone[:-1] & ~gone[1:]) + 1
    begins = np.flatnonzero(np.diff(gone, prepend=False) & gone)[: len(ends)]
    for begin, end in zip(begins, ends, strict=True):
        if end - begin > SHORT_GAP or begin == 0:
            weight[end : end + round(_SETTLING_S / h)] = 0.0
    return weight
