"""The proxy: it follows the hand everywhere but through a point cloud (thesis appendix C, eq. 11-23).

Three spheres around the proxy, r1 < r2 < r3. Points within r1 entrench it and push it out, points within r2 mean
contact, points within r3 give the surface normal. One call of `step_proxy` is one tick of the algorithm.

Where the appendix is followed to the letter the proxy does not hold what the appendix promises. What differs, and why
(each has its test):

- eq. 12 uses the step s_k before it exists; s_{k-1} is meant. Put in as printed, eq. 13 and 12 give v_{k-1} = 0 for
  ever.
- eq. 12 takes only steps that the cloud forced (entrenched ones). Counted as well, the steps of a hand that comes down
  at 3 m/s would make eq. 13 carry the proxy through the surface. Without contact there is no cloud velocity: it is 0.
- eq. 12 divides a correction by the time since the last one, not by one period: the cloud needs many ticks to cross
  the band between r1 and its middle, and credited to one tick that way overshoots and the proxy chatters.
- eq. 14: the weight takes the distance, not the vector.
- eq. 22: the two cases are exchanged. With the outward normal that eq. 14 gives, pushing in is n·u < 0.
- eq. 22: a step along the surface never goes past the hand's projection; with the length of eq. 20-21 alone the proxy
  of a hand that presses straight down swings to and fro about it.
- eq. 29 lacks the factor 4 on (b·c)² (see `spheres.distance_roots`).
- A normal that turns by more than 90° while entrenched means that the cloud has passed the proxy's centre: the side
  where the proxy was is kept. Where the points around it cancel each other, the last normal holds.
- A sphere of radius r2 notices a surface from r2 away, so the cloud is lowered: against the normals of its points where
  it has them. Lowered along z, a slope would be noticed before it is there, and a steep one after.
- A cloud that moved rigidly since the last tick by a known translation sweeps the proxy along, however far it moved,
  so a cloud that arrives at 30 Hz cannot jump over it. The part of the motion along the surface leaves it alone.
"""

import math
from dataclasses import dataclass, fields
from typing import Annotated, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.cloud.cloud import SERIAL, Cloud
from mmt_drake.cloud.grid import COUNT, EDGE, Grid, count_within
from mmt_drake.cloud.spheres import neighbourhood, way_ahead, way_out
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.numeric.vectors import UP, ZERO, Vector, dot, get, length, minus, plus, put, times
from mmt_drake.quantities import Checked, Length, Quantity, Time

FREE, IN_CONTACT, ENTRENCHED = 0.0, 1.0, 2.0
NO_CLOUD = Cloud.empty()

# Layout of the proxy's memory.
_next = Layout()
POSITION = _next(3)  # of the proxy [m]
NORMAL = _next(3)  # outward unit normal of the last tick, 0 if there was none
STEP = _next(3)  # last step s, without the carrying of eq. 13 [m]
SPEED = _next()  # of the cloud along the normal, eq. 12 [m/s]
SINCE = _next()  # ticks since the speed was last corrected
STATE = _next()  # FREE, IN_CONTACT or ENTRENCHED: what decided the last step
TOUCHING = _next()  # 1 if points are within r2 after the step, else 0
CLOUD = _next()  # serial number of the cloud's base points, 0 before the first
SHIFT = _next(3)  # that cloud's translation [m]
SURFACE = _next(3)  # the proxy's foot on the undeformed surface; the proxy itself if it touches nothing [m]
MEMORY_SIZE = _next.size


@dataclass(frozen=True)
class ProxySettings(Checked):
    """Parameters of the proxy.

    Attributes:
        r1: entrenchment radius [m]. Noisy clouds want r2 - r1 no smaller than their noise. A cloud keeps the proxy out
            only if its gaps are smaller than the spheres: its spacing should be well below `widest_spacing`.
        r2: contact radius [m].
        r3: radius of the normal estimate [m].
        gamma: share of the way to the hand that one step in contact takes when the hand is nearer than r1 (eq. 20).
        zeta: length of that step, in r1, when the hand is further away (eq. 21). The proxy slides along a surface at
            zeta r1 / period at most, and leaves it, once the hand is away,
            within ceil((r2 - r1) / (zeta r1)) ticks (thesis eq. 23).
        period: time between two ticks [s].
        surface_offset: how far the cloud is taken to lie below where it is, against the normals of its points, or
            along -z where it has none [m]; None for `contact_offset(r2, spacing)` with the spacing of each cloud.

    Raises:
        BadInput: 0 < r1 < r2 < r3, 0 < gamma < 1, 0 < zeta < 1 or period > 0 does not hold, or a number is not finite.
    """

    r1: Length = 3e-3
    r2: Length = 5e-3
    r3: Length = 10e-3
    gamma: float = 0.9
    zeta: float = 0.5
    period: Time = 1e-3
    surface_offset: Annotated[float | None, Quantity("m", -math.inf)] = None

    CALLED: ClassVar = "proxy"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.r1 < self.r2 < self.r3:
            found = f"{self.r1}, {self.r2}, {self.r3}"
            raise BadInput("proxy", at="r1, r2, r3", found=found, expected="0 < r1 < r2 < r3")
        for name in ("gamma", "zeta"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise BadInput("proxy", at=name, found=getattr(self, name), expected="a number between 0 and 1")

    @property
    def widest_spacing(self) -> float:
        """Spacing of a square lattice from which on a pressed proxy slips through between the points [m].

        A free proxy is stopped (r1 + r2)/2 from the next point; between four points it meets none if their diagonal is
        longer than twice that: (r1 + r2)/√2.
        """
        return (self.r1 + self.r2) / math.sqrt(2.0)

    def packed(self) -> Array:
        """The numbers in the order the kernel wants them; a surface_offset of None becomes NaN."""
        values = [getattr(self, field.name) for field in fields(self)]
        return np.array([math.nan if value is None else value for value in values])


def contact_offset(r2: float, spacing: float, noise: float = 0.0) -> float:
    """Height above a surface at which a sphere coming down on its sampled points first touches one, on average [m].

    Taking the cloud as lying this far below its true place makes contact begin where the probe's tip meets the surface.
    Over a continuous surface that is r2. Points leave gaps: at a horizontal distance rho from the nearest one the
    sphere touches at √(r2² - rho²), about r2 - rho²/(2 r2), and over a square lattice the mean of rho² is spacing²/6.
    With noise the sphere meets the highest of the points it covers instead; for points strewn with density
    1/spacing² the height H has P(H < h) = exp(-∫ P(z + √(r2² - rho²) > h) 2 pi rho drho / spacing²).

    Args:
        r2: contact radius [m].
        spacing: mean distance between neighbouring points, 1/√(points per area) [m].
        noise: standard deviation of the points along the surface normal [m].
    """
    if noise == 0.0:
        return _mean_touch(r2, spacing)
    from scipy.special import ndtr

    rho = np.linspace(0.0, r2, 400)
    height = np.linspace(-6.0 * noise, r2 + 6.0 * noise, 800)
    above = ndtr((np.sqrt(r2**2 - rho**2) - height[:, None]) / noise)
    expected_points = np.trapezoid(above * 2.0 * np.pi * rho, rho, axis=1) / spacing**2
    below = np.exp(-expected_points)
    return float(height[-1] - np.trapezoid(below, height))


@njit(cache=True)
def _mean_touch(r2: float, spacing: float) -> float:
    """`contact_offset` without noise."""
    return r2 - spacing**2 / (12.0 * r2)


def new_memory() -> Array:
    """The memory of a proxy that has not seen a cloud yet, (MEMORY_SIZE,)."""
    return np.zeros(MEMORY_SIZE)


def step_proxy(memory: Array, hand: Array, cloud: Cloud | None, settings: Array) -> None:
    """One tick of the proxy algorithm, in place.

    With the first cloud the proxy starts above it (+z is out of the surface) and comes down to the hand, so that a
    hand that is already below the surface is in contact. Without a cloud, or with an empty one, it is at the hand.

    Args:
        memory: (MEMORY_SIZE,) from `new_memory`, changed in place.
        hand: (3,) or longer; the first three are the haptic interaction point's position [m], table frame.
        cloud: the surface's points now; None if none has come in yet.
        settings: `ProxySettings.packed()`.

    Raises:
        BadInput: a position that is not finite, or something else than a `Cloud`.
    """
    if cloud is None:
        cloud = NO_CLOUD
    elif not isinstance(cloud, Cloud):
        raise BadInput("proxy", at="point_cloud", found=type(cloud).__name__, expected="an mmt_drake.cloud.Cloud")
    points, starts, frame, header = cloud.kernel_arrays
    offset = settings[6] if settings[6] == settings[6] else contact_offset(float(settings[1]), cloud.spacing)
    lowered = cloud.normals is not None and len(cloud) > 0
    if lowered:
        points, starts, frame = cloud.lowered(float(offset))[0]
    if not _tick(memory, hand, points, starts, frame, header, settings, float(offset), lowered):
        raise BadInput("proxy", at="position", found=hand, expected="finite numbers [m]")


@njit(cache=True)
def pressed(memory: Array, hand: Array) -> bool:
    """True where the hand is below the surface: the proxy touches it, and the hand is inward of the proxy's foot there.

    The plane through the points about the proxy decides, not which point a sphere meets first: neither the sampling of
    a flat surface nor the radii matter. A proxy that is to touch before the hand arrives needs a cloud that is lowered
    by less than `contact_offset`.

    Args:
        memory: after `step_proxy`.
        hand: (3,) or longer, as given to it.
    """
    stretch = minus(get(memory, SURFACE), get(hand, 0))
    return memory[TOUCHING] == 1.0 and dot(get(memory, NORMAL), stretch) > 0.0


@njit(cache=True)
def _tick(
    memory: Array,
    hand: Array,
    points: Array,
    starts: NDArray[np.int32],
    frame: Array,
    header: Array,
    settings: Array,
    offset: float,
    lowered: bool,
) -> bool:
    """See `step_proxy`; `points` to `header` are `Cloud.kernel_arrays`, or of the cloud `lowered` by the offset.

    Returns:
        False if the hand's position is not finite.
    """
    goal = get(hand, 0)
    if not math.isfinite(goal[0] + goal[1] + goal[2]):
        return False
    if points.shape[1] == 0:
        memory[:] = 0.0
        put(memory, POSITION, goal)
        put(memory, SURFACE, goal)
        return True
    grid = Grid(points, starts, frame)
    r1, r2, r3, gamma, zeta = settings[0], settings[1], settings[2], settings[3], settings[4]
    period, down = settings[5], 0.0 if lowered else offset
    shift = minus(get(header, 0), times(down, UP))  # takes grid coordinates to the table frame
    middle = 0.5 * (r1 + r2)

    at = _start_of_step(memory, grid, goal, header, down, r1, r3, period)
    nearest, normal, mean = _look(memory, grid, minus(at, shift), r1, r3)
    state = ENTRENCHED if nearest < r1 else (IN_CONTACT if nearest < r2 else FREE)
    step = ZERO
    if state == ENTRENCHED:
        step = times(way_out(grid, minus(at, shift), normal, middle), normal)  # eq. 19
    elif state == IN_CONTACT:
        step = _step_in_contact(minus(goal, at), normal, r1, gamma, zeta)
    at = plus(at, step)

    touching = state != FREE and count_within(grid, minus(at, shift), r2, 1) > 0
    if not touching:
        # Free, or free now: a proxy that slid over a gap between the points must land again in the same tick.
        way = minus(goal, at)
        part = way_ahead(grid, minus(at, shift), way, middle)
        touching = part < 1.0
        # Free, the proxy is at the hand to the last bit.
        at = plus(at, times(part, way)) if touching else goal  # eq. 17
        touching = touching or count_within(grid, minus(at, shift), r2, 1) > 0
        if touching:
            _, normal, mean = _look(memory, grid, minus(at, shift), r1, r3)

    memory[STATE] = state
    memory[TOUCHING] = 1.0 if touching else 0.0
    put(memory, POSITION, at)
    put(memory, NORMAL, normal)
    put(memory, STEP, step)
    if touching:
        # Down along the normal to the plane through the mean of the points, where they truly are.
        height = dot(normal, minus(minus(at, get(header, 0)), mean)) - (offset - down)
        at = minus(at, times(height, normal))
    put(memory, SURFACE, at)
    return True


@njit(cache=True)
def _step_in_contact(u: Vector, normal: Vector, r1: float, gamma: float, zeta: float) -> Vector:
    """Step of a proxy in contact, u being the way to the hand: along the surface or off it (eq. 20-22)."""
    d = gamma * length(u) if length(u) < r1 else zeta * r1  # eq. 20, 21
    inward = dot(normal, u)
    if inward < 0.0:
        u = minus(u, times(inward, normal))
        d = min(d, length(u))
    return times(d / length(u), u) if d > 0.0 else ZERO  # eq. 22


@njit(cache=True)
def _start_of_step(
    memory: Array, grid: Grid, goal: Vector, header: Array, offset: float, r1: float, r3: float, period: float
) -> Vector:
    """Begin of this tick's step: above the first cloud, else moved on by eq. 12-13 and by a cloud that moved."""
    if memory[CLOUD] == 0.0:
        memory[:] = 0.0
        top = grid.frame[2] + grid.frame[COUNT + 2] * grid.frame[EDGE] + header[2] - offset + r3
        at = (goal[0], goal[1], max(goal[2], top))
    else:
        normal = get(memory, NORMAL)
        if memory[STATE] == FREE:
            memory[SPEED] = memory[SINCE] = 0.0
        elif memory[STATE] == ENTRENCHED:
            memory[SPEED] += dot(normal, get(memory, STEP)) / (memory[SINCE] * period)  # eq. 12
            memory[SINCE] = 0.0
        at = plus(get(memory, POSITION), times(memory[SPEED] * period, normal))  # eq. 13
        if memory[CLOUD] == header[SERIAL]:
            at = _swept_along(memory, grid, at, minus(get(header, 0), get(memory, SHIFT)), offset, r1, r3)
    memory[SINCE] += 1.0
    memory[CLOUD] = header[SERIAL]
    put(memory, SHIFT, get(header, 0))
    return at


@njit(cache=True)
def _swept_along(memory: Array, grid: Grid, at: Vector, moved: Vector, offset: float, r1: float, r3: float) -> Vector:
    """Position at which a cloud that moved leaves the proxy.

    It is pushed along the normal where its r1 sphere was met, by as much as the rest of the motion goes that way.
    """
    before = plus(minus(at, get(memory, SHIFT)), times(offset, UP))
    # Seen from the cloud, the proxy came the other way.
    part = way_ahead(grid, before, times(-1.0, moved), r1)
    if part == 1.0:
        return at
    _, normal, _ = _look(memory, grid, minus(before, times(part, moved)), r1, r3)
    return plus(at, times(max((1.0 - part) * dot(normal, moved), 0.0), normal))


@njit(cache=True)
def _look(memory: Array, grid: Grid, at: Vector, r1: float, r3: float) -> tuple[float, Vector, Vector]:
    """Distance to the nearest point, unit normal on the proxy's side (0 without points), the points' weighted mean."""
    nearest, normal, total, mean = neighbourhood(grid, at, r1, r3)
    last = get(memory, NORMAL)
    if total > 0.0 and length(normal) > 1e-9 * total:
        normal = times(1.0 / length(normal), normal)
        if nearest < r1 and dot(normal, last) < 0.0:
            normal = times(-1.0, normal)
    elif total > 0.0:
        # The directions cancel: the last normal, or the table's if there was none.
        normal = last if last != ZERO else UP
    return nearest, normal, mean
