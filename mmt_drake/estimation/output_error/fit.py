"""One fit of the free-running force to a window of samples, and what a fit leaves behind.

The force along x and y that the object of `mmt_drake.model` exerts on the probe, simulated from where it rested on, is
compared with the measured one, both as means over the samples, the simulated one as late as the measured. What is
minimised is the squared difference over its variance, and the squared distance from what was known before: from older
samples, and from the prior. A direction in which the motion does not excite the object is left where it was known to
be. `unknowns` says what is sought.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from mmt_drake.errors import MmtError, attempt
from mmt_drake.estimation.output_error.beginning import Beginning
from mmt_drake.estimation.output_error.lateness import LONGEST_S, late_means
from mmt_drake.estimation.output_error.replay import replay_window
from mmt_drake.estimation.output_error.unknowns import (
    HIGH,
    LATENESS,
    LOG,
    LOW,
    OBJECT,
    SIZE,
    UNKNOWNS,
    Information,
    Stick,
    theta_of,
)
from mmt_drake.estimation.output_error.unsure_touches import UnsureTouches
from mmt_drake.estimation.output_error.window import FORCE, Window
from mmt_drake.model.parameters import MAX_STEP, NORMAL_AXIS
from mmt_drake.model.theta import adopt_theta
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.numeric.least_squares import Minimum, minimise, stay
from mmt_drake.told_laws import NO_LAWS, VECTOR_SIZE, put_laws, step_with_laws

COARSE = 3.0
"""Integration steps are so much longer than accuracy asks for; what that adds is below 1e-4 of the force."""
LEAST_STEP = 2e-5
"""A set that needs shorter integration steps [s] is no candidate: nothing that fast shows in a force."""
LEAST_NOISE = 1e-3
"""No fit is believed to be better than this [N]."""
HALF_KNOWN = 0.5
"""Share of the prior's deviation: what is not known better has not been excited."""
MOST_NOISE = 0.3
"""Of what samples say of an unknown may be their motion's noise."""

_DIFFERENCE = 1e-3  # of an unknown's size
_BLOCK_S = 0.1  # sums of residuals over that long nearly are independent
_MOST_PARTS = 5  # of the time between samples: more say nothing of a mean


class ReplayedWindow(NamedTuple):
    """A simulated window.

    Attributes:
        force: along x and y at each tick [N], as the object exerts it.
        state: (2, AXIS_SIZE) of the body at the last sample.
    """

    force: Array
    state: Array


def comparable(window: Window, h: float) -> Array:
    """(n, 3) 1 where the force is compared: not at first, when a late one is of the time before the window."""
    weight = window.weight.copy()
    if window.contact[:1].any():
        weight[: math.ceil(LONGEST_S / h)] = 0.0
    return weight


@dataclass(frozen=True)
class Objective:
    """What is minimised over the unknowns.

    Attributes:
        window: the samples.
        h: time between them [s].
        ticks: of which each is a mean.
        start: where the body is at the first sample.
        known: of the unknowns from elsewhere, prior included.
        noise: deviation of what is compared [N].
        planar: of a kernel vector (`mmt_drake.model.plane_call.planar`).
        pull: (UNKNOWNS,) slope of what is minimised beside, see `slope_of_noise`.
        untold: (UNKNOWNS,) kept as they are known: all that noise alone tells, of samples that tell nothing else.
        laws: (TOLD_SIZE,) beside the numbers that are sought (`mmt_drake.told_laws`).
        normal: (2,) k and b of the normal axis, whose force is the load of laws.
        about: unknowns and stick at which it is found what another height changes.
        replays: of every object that was simulated.
    """

    window: Window
    h: float
    ticks: int
    start: Beginning
    known: Information
    noise: float
    planar: float = 0.0
    pull: Array = field(default_factory=lambda: np.zeros(UNKNOWNS))
    untold: Flags = field(default_factory=lambda: np.zeros(UNKNOWNS, dtype=bool))
    laws: Array = field(default_factory=lambda: NO_LAWS)
    normal: Array = field(default_factory=lambda: np.ones(2))
    about: tuple[Array, Stick] | None = None
    replays: dict[tuple[bytes, Stick, bool], ReplayedWindow] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @cached_property
    def weight(self) -> Array:
        """(2, n) 1 where the force along x and y is compared."""
        return comparable(self.window, self.h)[:, :2].T.copy()

    @property
    def compared(self) -> int:
        """How many samples of the force count, along x and y together."""
        return int(np.count_nonzero(self.weight))

    def difference(self, x: Array, stick: Stick, higher: bool = False) -> Array:
        """Simulated less measured force (2 n,) [N], along x and then along y; 0 where they are not compared.

        Args:
            x, stick: the object.
            higher: whether the surface is higher by one standard deviation.

        Raises:
            MmtError: a set that cannot be integrated.
        """
        x = self._told(x)
        force = self._replay(x, stick, higher).force
        found = np.empty((2, len(self.window)))
        late_means(force, self.h / self.parts, self.parts, x[LATENESS], found)
        return ((found - self.window.samples[:, FORCE].T[:2]) * self.weight).ravel()

    def end(self, x: Array, stick: Stick, count: int) -> Array:
        """The state (2, AXIS_SIZE) at sample `count`.

        Raises:
            MmtError: a set that cannot be integrated.
        """
        if count == len(self.window) - 1:
            return self._replay(x, stick).state
        return self._until(count)._replay(x, stick).state

    def beginning_after(self, x: Array, stick: Stick, count: int, deviation: Array) -> Beginning:
        """Where the body is at sample `count`, for unknowns with a deviation (UNKNOWNS,).

        Raises:
            MmtError: x cannot be integrated.
        """
        part = self._until(count)
        deviation = np.where(self.untold, 0.0, deviation)
        return Beginning.after(lambda tried: part._replay(tried, stick).state, x, deviation)

    def _until(self, count: int) -> Self:
        return replace(self, window=self.window.part(slice(count + 1)))

    def _told(self, x: Array) -> Array:
        return np.where(self.untold, np.clip(self.known.mean(), LOW, HIGH), x) if self.untold.any() else x

    @property
    def parts(self) -> int:
        """Into which the time from one sample to the next is divided, an odd number: ticks, as long as they are few."""
        return min(self.ticks + 1 - self.ticks % 2, _MOST_PARTS)

    def _replay(self, x: Array, stick: Stick, higher: bool = False) -> ReplayedWindow:
        x = self._told(x)
        key = x[OBJECT].tobytes(), stick, higher
        if key in self.replays:
            return self.replays[key]
        window, n = self.window, len(self.window)
        p = np.zeros(VECTOR_SIZE)
        theta = theta_of(x, stick, self.normal)
        if not adopt_theta(theta, math.inf, LEAST_STEP, self.planar, p):
            raise MmtError("the object is too stiff for a fit")
        put_laws(self.laws, p)
        p[NORMAL_AXIS] = 0.0  # no law that reads the load stands beside one along the normal (`check_side_by_side`)
        if step_with_laws(p) < LEAST_STEP:
            raise MmtError("the laws are too stiff for a fit")
        p[MAX_STEP] = COARSE * step_with_laws(p)
        force, state = np.zeros((2, max(0, n - 1) * self.parts + 1)), self.start.of(x)
        motion = window.motion[:, :3].T.copy(), window.motion[:, 3:].T.copy()
        try:
            touched = window.contact, window.switch, window.unsure if higher else np.zeros(n)
            replay_window(self.h, self.parts, *motion, *touched, p, state.ravel(), force)
        except RuntimeError as error:
            raise MmtError(str(error)) from None
        self.replays[key] = ReplayedWindow(force, state)
        return self.replays[key]

    def residual(self, x: Array, stick: Stick) -> Array:
        """What least squares are taken of: the difference over its deviation, and behind it what else is known.

        Touches at another height are part of that deviation (`UnsureTouches`).
        """
        root = np.linalg.cholesky(self.known.matrix).T
        return np.concatenate([self._unexplained(x, stick), root @ (x - self.known.mean())])

    def _unexplained(self, x: Array, stick: Stick) -> Array:
        """The difference over its deviation, as far as touches at another height need not have made it."""
        return self._touches.taken_from(self.difference(x, stick) / self.noise)

    @cached_property
    def _touches(self) -> UnsureTouches:
        if self.about is None or not self.window.unsure.any():
            return UnsureTouches()
        x, stick = self.about
        here, there = attempt(self.difference, x, stick), attempt(self.difference, x, stick, True)
        if here is None or there is None:
            return UnsureTouches()
        return UnsureTouches.of(self.window.contact, (there - here) / self.noise)

    def step(self, x: Array, stick: Stick, steps: int = 1) -> Minimum:
        """Some steps towards the least squares.

        Raises:
            MmtError: x cannot be integrated.
        """
        return minimise(lambda tried: self.residual(tried, stick), x, LOW, HIGH, SIZE, steps=steps, pull=self.pull)

    def slope_of_noise(self, x: Array, stick: Stick, numbers: Sequence[int]) -> tuple[Array, Array]:
        """Slope after some unknowns of half the sum of squares that noise on the motion adds (len(numbers),) [N^2].

        What is left of that noise acts in the simulated force, and nothing in the measured force answers it. Least
        squares make it small, at the price of wrong numbers: errors in the variables. The same is had once more from
        the motion with as much noise again, and taken off (compensated least squares: Fuller 1987, Measurement Error
        Models, 1.3; noise that is added on purpose: Cook and Stefanski 1994, J. Am. Stat. Assoc. 89).

        Returns:
            The slopes, and what share of the samples' word on each unknown is noise: where that is more than
            `MOST_NOISE` the slope is 0. Inf where they say nothing.

        Raises:
            MmtError: a set that cannot be integrated.
        """
        every = replace(self, untold=np.zeros(UNKNOWNS, dtype=bool)) if self.untold.any() else self
        start = self.start.moved((self.window.shaken - self.window.motion)[0, :2])  # a rest is where the probe was seen
        shaken = replace(every, window=replace(self.window, motion=self.window.shaken), start=start)

        def added(tried: Array) -> Array:
            return shaken.difference(tried, stick) - every.difference(tried, stick)

        here, slopes, share = added(x), np.zeros(len(numbers)), np.full(len(numbers), math.inf)
        for k, j in enumerate(numbers):
            moved = x.copy()
            moved[j] += _DIFFERENCE * SIZE[j] * (1.0 if x[j] + _DIFFERENCE * SIZE[j] <= HIGH[j] else -1.0)
            further = added(moved) - here
            whole = every.difference(moved, stick) - every.difference(x, stick)
            if whole.any():
                share[k] = further @ further / (whole @ whole)
            if share[k] <= MOST_NOISE:
                slopes[k] = further @ here / (moved[j] - x[j])
        return slopes, share

    def said(self, x: Array, stick: Stick, count: int) -> Information:
        """What the first `count` samples say, linear about x; those that repeat each other count as one.

        Raises:
            MmtError: x cannot be integrated.
        """
        there = stay(lambda tried: self._unexplained(tried, stick), x, LOW, HIGH, SIZE)
        n = len(self.window)
        rows = np.r_[0:count, n : n + count]
        share = float(np.count_nonzero(self.weight[:, :count])) / max(self.compared, 1)
        pulled = Information(np.zeros_like(self.known.matrix), -share * self.pull)
        found = Information.of(there.jacobian[rows], there.residual[rows], x).plus(pulled)
        return found.faded(1.0 / self.repeated(there))

    def repeated(self, minimum: Minimum) -> float:
        """How many residuals in a row say the same of the unknowns, on average over these; 1 at least.

        The design effect of samples that come in blocks (Kish 1965, Survey Sampling).
        """
        rows = 2 * len(self.window)
        J, r = minimum.jacobian[:rows], minimum.residual[:rows]
        if not J.any():
            return 1.0
        sums = self._sums(J * r[:, np.newaxis])
        inverse = self.inverse(J)
        return max(1.0, float(np.trace(inverse @ (sums.T @ sums)) / np.trace(inverse @ (J.T @ J))))

    def inverse(self, jacobian: Array) -> Array:
        """Of `curvature` (k, k)."""
        return np.asarray(np.linalg.inv(self.curvature(jacobian)), dtype=np.float64)

    def curvature(self, jacobian: Array) -> Array:
        """J' J (k, k); where no difference could be simulated, what is known stands for it."""
        normal = jacobian.T @ jacobian
        lost = np.flatnonzero(np.diag(normal) == 0.0)
        normal[lost, lost] = np.diag(self.known.matrix)[lost]
        return np.asarray(normal, dtype=np.float64)

    def left(self, minimum: Minimum) -> Array:
        """The `difference` (2 n,) where a fit ended [N], less what touches at another height may have made."""
        return minimum.residual[: 2 * len(self.window)] * self.noise

    def noise_left(self, minimum: Minimum) -> float:
        """Deviation of what is compared where a fit ended [N]."""
        difference = self.left(minimum)
        return max(math.sqrt(float(difference @ difference) / max(self.compared, 1)), LEAST_NOISE)

    def in_a_row(self, minimum: Minimum) -> float:
        """How many residuals in a row say the same, so that all together count as so many times fewer; 1 at least."""
        r = minimum.residual[: 2 * len(self.window)]
        sums = self._sums(r)
        return max(1.0, float(sums @ sums) / max(float(r @ r), 1e-300))

    def _sums(self, rows: Array) -> Array:
        """Sums over a tenth of a second."""
        every = np.arange(0, len(rows), max(1, round(_BLOCK_S / self.h)))
        return np.add.reduceat(rows, every, axis=0) if len(rows) else rows

    def covariance(self, minimum: Minimum) -> Array:
        """Of the unknowns (k, k): what is known, with the residuals as coloured as they are.

        Residuals in turn are not independent; their sums over a tenth of a second nearly are.
        """
        J, r = minimum.jacobian, minimum.residual
        bread, rows = self.inverse(J), 2 * len(self.window)
        sums = self._sums(J[:rows] * r[:rows, np.newaxis])
        return np.asarray(bread @ (self.known.matrix + sums.T @ sums) @ bread, dtype=np.float64)

    def unexcited_beside(self, minimum: Minimum, stick: Stick, covariance: Array, prior: Information) -> Array:
        """The covariance (k, k) with numbers that the motion hardly tells, and are far from their prior, back at it.

        A mass of next to nothing has no derivative, so that others seem to be known better than they are. How far they
        go when it is put back is part of what is not known.

        Raises:
            MmtError: a set that cannot be integrated.
        """
        x, mean, deviation = minimum.x, prior.mean(), np.diag(prior.matrix) ** -0.5
        far = (np.diag(covariance) > (HALF_KNOWN * deviation) ** 2) & (np.abs(x - mean) > deviation) & LOG
        found = covariance.copy()
        for j in np.flatnonzero(far):
            moved, others = x.copy(), np.arange(len(x)) != j
            moved[j] = mean[j]
            further = self.residual(moved, stick) - minimum.residual
            normal, gradient = self.curvature(minimum.jacobian), minimum.jacobian.T @ further
            followed = np.empty(len(x))
            followed[others] = -np.linalg.solve(normal[np.ix_(others, others)], gradient[others])
            followed[j] = moved[j] - x[j]
            found += np.outer(followed, followed)
        return found
