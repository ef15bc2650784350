"""Where a surface is, by when a force begins on the tip that comes down on it.

A camera errs by a millimetre, and a touch tells the height to some hundredths of one. Before the touch there is no
force along the normal, and from it on

    F = k (h - z) - b v        for z < h,

late by what the force is late: a delay, then a low pass of first order. z is the tip's height over the surface as the
cloud shows it, v its speed, h how much higher the surface is. For each instant of the touch h is z then, and k and b
follow by least squares, neither below 0; the best instant is taken. A damper makes the force begin with a step, so an
extrapolation of the force to zero would be wrong by b v / k, centimetres.
"""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from numba import njit

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.facet import surface_near
from mmt_drake.cloud.grid import COUNT, Grid, cells_across
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import UP, Vector
from mmt_drake.quantities import Checked, Quantity

BEFORE_S, AFTER_S = 0.08, 0.048
"""How much of a touch is looked at before the force shows and after it [s]."""
_BACK_S = 0.06  # before the force shows, in which the touch may have been
_SPLITS = 5  # of the lateness into delay and time constant
_PART = 0.1  # of a sample, to which the instant is told
_STEEP = 0.2  # least z of a normal
_EXPLAINED = 0.9  # share of the squared force
_ALIKE = 1e-9  # share of the squared force by which two instants are equally good: at even speed, all in one tick
_LEAST = 0.3  # samples, to which the instant is known at best


@dataclass(frozen=True)
class TouchSettings(Checked):
    """What is known of a cloud before anything has been touched.

    Attributes:
        deviation: standard deviation of the height that it shows [m]; the tip is in free space where it is higher than
            three of them and 1 mm.
        slope: of its slope [1]: so much more per metre it may be off beside the last touch.
        wander: standard deviation from one touch to the next at the same place [m].
        lateness: to which the lateness of the force is known at best, a standard deviation [s].

    Raises:
        BadInput: a value out of range.
    """

    deviation: Annotated[float, Quantity("m", most=0.01, positive=True)] = 1e-3
    slope: Annotated[float, Quantity("1", most=1.0)] = 0.01
    wander: Annotated[float, Quantity("m", most=0.01)] = 5e-5
    lateness: Annotated[float, Quantity("s", most=0.1)] = 1e-3

    CALLED: ClassVar = "touch"

    def beside(self, spread: float, way: float) -> float:
        """What a standard deviation of the height [m] becomes a way from where that was touched [m]."""
        return min(math.hypot(spread, self.slope * way, self.wander), self.deviation)


class TouchedHeight(NamedTuple):
    """What a touch tells.

    Attributes:
        height: of the surface over where the cloud shows it, along z [m].
        deviation: standard deviation of that [m].
        shared: of it what touches of the same speed have in common [m]: the lateness of the force.
    """

    height: float
    deviation: float
    shared: float


class SeenPlane(NamedTuple):
    """The plane of a surface under a tip, as a cloud shows it.

    Attributes:
        normal: outward unit normal n.
        along: n . x of its points x [m].
        deviation: standard deviation of that [m], by the noise of points without normals; of others how far the nearer
            half of them says otherwise, which is much at an edge.
    """

    normal: Vector
    along: float
    deviation: float

    def below(self, tip: Array) -> float:
        """z of the plane below a tip [m]."""
        n = self.normal
        return float((self.along - n[0] * tip[0] - n[1] * tip[1]) / n[2])


def height_of_touch(
    samples: Array, noise: Array, onset: int, seen: SeenPlane, period: float, lateness: tuple[float, float]
) -> TouchedHeight | None:
    """The height of a surface by one touch; None where the force is not a touch's.

    Args:
        samples: (n, 9) position [m], velocity [m/s] and force [N] of the tip, less the force in free space.
        noise: (3,) standard deviations of the force in free space [N].
        onset: the first sample whose force is no noise.
        seen: the surface there.
        period: between samples [s].
        lateness: of the force, and its standard deviation [s].
    """
    n = np.array(seen.normal)
    z, v, force = samples[:, :3] @ n - seen.along, samples[:, 3:6] @ n, samples[:, 6:] @ n
    late, unsure = max(lateness[0], 0.0), lateness[1]
    at, ticks, share = instant_of_touch(z, v, force, onset, period, late, float(np.linalg.norm(noise * n)))
    if not share > _EXPLAINED:
        return None
    speed = abs(_between(v, at))
    deviation = math.hypot(speed * period * ticks, speed * unsure, seen.deviation)
    return TouchedHeight(_between(z, at) / n[2], deviation / n[2], speed * unsure / n[2])


@njit(cache=True)
def instant_of_touch(
    z: Array, v: Array, force: Array, onset: int, period: float, late: float, noise: float
) -> tuple[float, float, float]:
    """When a touch began, in samples; how far that is certain, likewise; and the share of the force that it explains.

    Args:
        z: (n,) heights of the tip over the surface that was believed [m].
        v: (n,) its speeds along the normal [m/s].
        force: (n,) along the normal, less what there was in free space [N].
        onset: the first sample whose force is no noise.
        period: between samples [s].
        late: delay and time constant of the force together [s]; how much of it is which is told by the touch.
        noise: standard deviation of the force [N].
    """
    n, total = len(force), 0.0
    for i in range(n):
        total += force[i] ** 2
    least, best, lag = math.inf, math.nan, 0.0
    for split in range(_SPLITS if late > 0.0 else 1):
        tried = split * late / max(_SPLITS - 1, 1)
        for earlier in range(int((_BACK_S + 3.0 * late) / period)):
            at = onset - earlier - 0.5  # half-way between two samples: each instant between them is nearly as good
            left = math.inf if at < 1.0 else _left(at, z, v, force, period, late - tried, tried)
            if left < least:
                least, best, lag = left, at, tried
    if math.isinf(least):
        return math.nan, math.inf, 0.0
    limit = least + max(noise * noise, least / max(n - 3, 1), _ALIKE * total)
    first = last = best
    while first > 1.0 and _left(first - _PART, z, v, force, period, late - lag, lag) <= limit:
        first -= _PART
    while last < onset and _left(last + _PART, z, v, force, period, late - lag, lag) <= limit:
        last += _PART
    share = 1.0 - least / total if total > 0.0 else 0.0
    return 0.5 * (first + last), max(0.5 * (last - first), _LEAST), share


@njit(cache=True)
def _left(start: float, z: Array, v: Array, force: Array, period: float, delay: float, lag: float) -> float:
    """What is left of the squared forces where the touch was at sample `start`, k and b being the best."""
    height, shift = _between(z, start), delay / period
    spring = damper = kk = kb = bb = kf = bf = left = 0.0
    for i in range(len(force)):
        left += force[i] ** 2
        at = i - shift
        if at < start:
            continue
        depth, speed = height - _between(z, at), -_between(v, at)
        share = 1.0
        if lag > 0.0:
            share = 1.0 - math.exp(-min(at - start, 1.0) * period / lag)
        spring += share * (depth - spring)
        damper += share * (speed - damper)
        kk += spring * spring
        kb += spring * damper
        bb += damper * damper
        kf += spring * force[i]
        bf += damper * force[i]
    determinant = kk * bb - kb * kb
    k = b = -1.0
    if determinant > 1e-12 * kk * bb:
        k, b = (bb * kf - kb * bf) / determinant, (kk * bf - kb * kf) / determinant
    if k < 0.0 or b < 0.0:
        alone_k, alone_b = max(kf, 0.0) ** 2 / kk if kk > 0.0 else 0.0, max(bf, 0.0) ** 2 / bb if bb > 0.0 else 0.0
        return left - max(alone_k, alone_b)
    return left - k * kf - b * bf


@njit(cache=True)
def _between(values: Array, at: float) -> float:
    """A value between two samples, the first or last one beyond them."""
    i = min(max(int(at), 0), len(values) - 2)
    part = min(max(at - i, 0.0), 1.0)
    return values[i] + part * (values[i + 1] - values[i])


def plane_below(cloud: Cloud, tip: Array, radius: float) -> SeenPlane | None:
    """The plane of a cloud's surface under a tip; None where no point is near, or it is so steep that it has no height.

    Of a cloud without normals it is level, as high as the points within the radius of the tip across z.

    Args:
        cloud: the surface.
        tip: (3,) [m].
        radius: within which points count [m].
    """
    if cloud.normals is None:
        moved = cloud.translation
        points, starts, frame, _ = cloud.kernel_arrays
        mean, deviation = _height(Grid(points, starts, frame), tuple((tip[:3] - moved).tolist()), radius)
        return None if math.isnan(mean) else SeenPlane(UP, mean + float(moved[2]), deviation)
    (depth,), (n,) = surface_near(cloud, tip[None, :3], np.array([UP]), radius)
    if math.isnan(depth) or n[2] < _STEEP:
        return None
    foot = tip[:3] + depth * n
    ((apart,), _) = surface_near(cloud, foot[None], n[None], 0.5 * radius)
    return None if math.isnan(apart) else SeenPlane(tuple(n.tolist()), float(n @ foot), abs(float(apart)))


@njit(cache=True)
def _height(grid: Grid, at: Vector, radius: float) -> tuple[float, float]:
    """Mean z of the points in the column about `at`, grid coordinates, and its standard deviation [m]; NaN of none."""
    y0, y1 = cells_across(grid, 1, at, radius)
    x0, x1 = cells_across(grid, 0, at, radius)
    count_x, count_y = int(grid.frame[COUNT]), int(grid.frame[COUNT + 1])
    count = mean = squares = 0.0
    for iz in range(int(grid.frame[COUNT + 2])):
        for iy in range(y0, y1):
            row = count_x * (iy + count_y * iz)
            for i in range(grid.starts[row + x0], grid.starts[row + x1]):
                dx, dy = grid.points[0, i] - at[0], grid.points[1, i] - at[1]
                if dx * dx + dy * dy < radius * radius:
                    count += 1.0
                    away = grid.points[2, i] - mean
                    mean += away / count
                    squares += away * (grid.points[2, i] - mean)
    if count == 0.0:
        return math.nan, math.nan
    return mean, math.sqrt(squares) / count


def compile_touch(radius: float) -> None:
    """Compile what `plane_below`, of clouds with normals and without, and `height_of_touch` need."""
    samples = np.zeros((8, 9))
    samples[:, 2], samples[:, 5], samples[4:, 8] = -np.arange(8.0), -1.0, np.arange(1.0, 5.0)
    for normals in (None, [UP]):
        seen = plane_below(Cloud(samples[4:5, :3], normals=normals), samples[4], radius)
        if seen is not None:
            height_of_touch(samples, np.zeros(3), 4, seen, 0.01, (0.0, 0.0))
