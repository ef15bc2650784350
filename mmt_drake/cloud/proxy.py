"""The proxy: it follows the hand everywhere but through a point cloud (thesis appendix C, eq. 11-23).

Three spheres around the proxy, r1 < r2 < r3. Points within r1 entrench it and push it out, points within r2 mean
contact, points within r3 give the surface normal. One call of `step_proxy` is one tick of the algorithm.

Where the appendix is followed to the letter the proxy does not hold what the appendix promises. What differs, and why
(each has its test):

- eq. 12 uses the step s_k before it exists; s_{k-1} is meant. Put in as printed, eq. 13 and 12 give v_{k-1} = 0 for
  ever.
- eq. 12 takes only steps that the cloud forced (entrenched ones). Counted as well, the steps of a hand that comes down
  at 5 m/s would make eq. 13 carry the proxy through the surface. Without contact there is no cloud velocity: it is 0.
- eq. 12 divides a correction by the time since the last one, not by one period: the cloud needs many ticks to cross
  the band between r1 and its middle, and credited to one tick that way overshoots and the proxy chatters.
- eq. 14: the weight takes the distance, not the vector.
- eq. 22: the two cases are exchanged. With the outward normal that eq. 14 gives, pushing in is n·u < 0.
- eq. 22: a step along the surface never goes past the hand's projection; with the length of eq. 20-21 alone the proxy
  of a hand that presses straight down swings to and fro about it.
- eq. 29 lacks the factor 4 on (b·c)² (see `spheres.distance_roots`).
- A normal that turns by more than 90° while entrenched means that the cloud has passed the proxy's centre: the side
  where the proxy was is kept. Where the points around it cancel each other, the last normal holds.
- A cloud that moved rigidly since the last tick by a known translation sweeps the proxy along, however far it moved,
  so a cloud that arrives at 30 Hz cannot jump over it. The part of the motion along the surface leaves it alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numba import njit

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.grid import COUNT, EDGE, Array, count_within
from mmt_drake.cloud.spheres import neighbourhood, way_ahead, way_out
from mmt_drake.errors import BadInput

FREE, IN_CONTACT, ENTRENCHED = 0.0, 1.0, 2.0
NO_CLOUD = Cloud.empty()

# Layout of the proxy's memory. Vectors take three places.
POSITION = 0  # of the proxy [m]
NORMAL = 3  # outward unit normal of the last tick, 0 if there was none
STEP = 6  # last step s, without the carrying of eq. 13 [m]
SPEED = 9  # of the cloud along the normal, eq. 12 [m/s]
SINCE = 10  # ticks since the speed was last corrected
STATE = 11  # FREE, IN_CONTACT or ENTRENCHED: what decided the last step
TOUCHING = 12  # 1 if points are within r2 after the step, else 0
CLOUD = 13  # serial number of the cloud's base points, 0 before the first
SHIFT = 14  # that cloud's translation [m]
SURFACE = 17  # the proxy's foot on the undeformed surface; the proxy itself if it touches nothing [m]
MEMORY_SIZE = 20


@dataclass(frozen=True)
class ProxySettings:
    """Parameters of the proxy.

    Attributes:
        r1: entrenchment radius [m]. Noisy clouds want r2 - r1 no smaller than their noise.
        r2: contact radius [m].
        r3: radius of the normal estimate [m].
        gamma: share of the way to the hand that one step in contact takes when the hand is nearer than r1 (eq. 20).
        zeta: length of that step, in r1, when the hand is further away (eq. 21). The proxy slides along a surface at
            zeta r1 / period at most, and leaves it after `steps_to_leave` ticks.
        period: time between two ticks [s].
        surface_offset: how far the cloud is taken to lie below where it is, along -z [m]; None for
            `contact_offset(r2, spacing)` with the spacing of each cloud that comes in.

    Raises:
        BadInput: 0 < r1 < r2 < r3, 0 < gamma < 1, 0 < zeta < 1 or period > 0 does not hold, or a number is not finite.
    """

    r1: float = 3e-3
    r2: float = 5e-3
    r3: float = 10e-3
    gamma: float = 0.9
    zeta: float = 0.5
    period: float = 1e-3
    surface_offset: float | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (value is None and field.name == "surface_offset") and not math.isfinite(value):
                raise BadInput("proxy", at=field.name, found=value, expected="a finite number")
        if not 0.0 < self.r1 < self.r2 < self.r3:
            raise BadInput(
                "proxy", at="r1, r2, r3", found=f"{self.r1}, {self.r2}, {self.r3}", expected="0 < r1 < r2 < r3"
            )
        for name in ("gamma", "zeta"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise BadInput("proxy", at=name, found=getattr(self, name), expected="a number between 0 and 1")
        if self.period <= 0.0:
            raise BadInput("proxy", at="period", found=self.period, expected="a time above 0 s")

    @property
    def steps_to_leave(self) -> int:
        """Ticks the proxy needs to leave a surface that the hand leaves in a jump, at most (thesis eq. 23)."""
        return math.ceil((self.r2 - self.r1) / (self.zeta * self.r1))

    def packed(self) -> Array:
        """The numbers in the order the kernel wants them; a surface_offset of None becomes NaN."""
        values = [getattr(self, field.name) for field in fields(self)]
        return np.array([math.nan if value is None else value for value in values])


def contact_offset(r2: float, spacing: float, noise: float = 0.0) -> float:
    """How high above the surface a sphere coming down on its sampled points first touches one, on average [m].

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
        return r2 - spacing**2 / (12.0 * r2)
    from scipy.special import ndtr

    rho = np.linspace(0.0, r2, 400)
    height = np.linspace(-6.0 * noise, r2 + 6.0 * noise, 800)
    above = ndtr((np.sqrt(r2**2 - rho**2) - height[:, None]) / noise)
    expected_points = np.trapezoid(above * 2.0 * np.pi * rho, rho, axis=1) / spacing**2
    below = np.exp(-expected_points)
    return float(height[-1] - np.trapezoid(below, height))


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
        raise BadInput("proxy", at="point_cloud", found=type(cloud).__name__, expected="a mmt_drake.cloud.Cloud")
    if not _tick(memory, hand, *cloud.kernel_arrays, settings):
        raise BadInput("proxy", at="position", found=hand, expected="finite numbers [m]")


@njit(cache=True)
def _tick(memory, hand, points, starts, frame, place, settings):
    """See `step_proxy`. `place`: (5,) the cloud's translation, the serial number of its base points, their spacing."""
    hx, hy, hz = hand[0], hand[1], hand[2]
    if not math.isfinite(hx + hy + hz):
        return False
    if points.shape[1] == 0:
        memory[:] = 0.0
        _put(memory, POSITION, hx, hy, hz)
        _put(memory, SURFACE, hx, hy, hz)
        return True
    r1, r2, r3, gamma, zeta = settings[0], settings[1], settings[2], settings[3], settings[4]
    period, offset = settings[5], settings[6]
    if math.isnan(offset):
        offset = r2 - place[4] ** 2 / (12.0 * r2)
    # From here on (sx, sy, sz) takes grid coordinates to the table frame.
    sx, sy, sz = place[0], place[1], place[2] - offset
    _prepare(memory, hx, hy, hz, points, starts, frame, place, offset, r1, r3, period)
    x, y, z = memory[POSITION], memory[POSITION + 1], memory[POSITION + 2]

    nearest, nx, ny, nz, total, mx, my, mz = _look(memory, points, starts, frame, x - sx, y - sy, z - sz, r1, r3)
    state = ENTRENCHED if nearest < r1 else (IN_CONTACT if nearest < r2 else FREE)
    middle = 0.5 * (r1 + r2)
    dx = dy = dz = 0.0
    if state == ENTRENCHED:
        d = way_out(points, starts, frame, x - sx, y - sy, z - sz, nx, ny, nz, middle)
        dx, dy, dz = d * nx, d * ny, d * nz  # eq. 19
    elif state == IN_CONTACT:
        dx, dy, dz = _step_in_contact(hx - x, hy - y, hz - z, nx, ny, nz, r1, gamma, zeta)
    x, y, z = x + dx, y + dy, z + dz

    touching = state != FREE and count_within(points, starts, frame, x - sx, y - sy, z - sz, r2, 1) > 0
    if not touching:
        # Free, or free now: a proxy that slid over a gap in the points must land again in the same tick.
        ux, uy, uz = hx - x, hy - y, hz - z
        way = math.sqrt(ux * ux + uy * uy + uz * uz)
        d = way
        if way > 0.0:
            ux, uy, uz = ux / way, uy / way, uz / way
            d = way_ahead(points, starts, frame, x - sx, y - sy, z - sz, ux, uy, uz, way, middle)
        if d < way:
            x, y, z = x + d * ux, y + d * uy, z + d * uz  # eq. 17
            touching = True
        else:
            x, y, z = hx, hy, hz  # and not x + d ux: free, the proxy is at the hand to the last bit
            touching = count_within(points, starts, frame, x - sx, y - sy, z - sz, r2, 1) > 0
        if touching:
            _, nx, ny, nz, total, mx, my, mz = _look(memory, points, starts, frame, x - sx, y - sy, z - sz, r1, r3)
    memory[STATE] = state
    memory[TOUCHING] = 1.0 if touching else 0.0
    _put(memory, POSITION, x, y, z)
    _put(memory, NORMAL, nx, ny, nz)
    _put(memory, STEP, dx, dy, dz)
    _put(memory, SURFACE, x, y, z)
    if touching and total > 0.0:
        # Down along the normal to the plane through the weighted mean of the points, where they truly are.
        height = nx * (x - sx - mx / total) + ny * (y - sy - my / total) + nz * (z - sz - offset - mz / total)
        _put(memory, SURFACE, x - height * nx, y - height * ny, z - height * nz)
    return True


@njit(cache=True)
def _step_in_contact(ux, uy, uz, nx, ny, nz, r1, gamma, zeta):
    """Step of a proxy in contact, u being the way to the hand: along the surface or off it (eq. 20-22)."""
    way = math.sqrt(ux * ux + uy * uy + uz * uz)
    d = gamma * way if way < r1 else zeta * r1  # eq. 20, 21
    inward = nx * ux + ny * uy + nz * uz
    if inward < 0.0:
        ux, uy, uz = ux - inward * nx, uy - inward * ny, uz - inward * nz
        way = math.sqrt(ux * ux + uy * uy + uz * uz)
        d = min(d, way)
    if way == 0.0:
        return 0.0, 0.0, 0.0
    return d * ux / way, d * uy / way, d * uz / way  # eq. 22


@njit(cache=True)
def _prepare(memory, hx, hy, hz, points, starts, frame, place, offset, r1, r3, period):
    """Bring the proxy to where this tick's step begins: at a start, eq. 12-13, and carried by a cloud that moved."""
    if memory[CLOUD] == 0.0:
        memory[:] = 0.0
        top = frame[2] + frame[COUNT + 2] * frame[EDGE] + place[2] - offset + r3
        _put(memory, POSITION, hx, hy, max(hz, top))
    nx, ny, nz = memory[NORMAL], memory[NORMAL + 1], memory[NORMAL + 2]
    if memory[STATE] == FREE:
        memory[SPEED] = memory[SINCE] = 0.0
    elif memory[STATE] == ENTRENCHED:
        step = nx * memory[STEP] + ny * memory[STEP + 1] + nz * memory[STEP + 2]
        memory[SPEED] += step / (max(memory[SINCE], 1.0) * period)  # eq. 12
        memory[SINCE] = 0.0
    memory[SINCE] += 1.0
    carried = memory[SPEED] * period  # eq. 13
    _put(
        memory,
        POSITION,
        memory[POSITION] + carried * nx,
        memory[POSITION + 1] + carried * ny,
        memory[POSITION + 2] + carried * nz,
    )
    if memory[CLOUD] == place[3]:
        _sweep_along(memory, points, starts, frame, place, offset, r1, r3)
    memory[CLOUD] = place[3]
    _put(memory, SHIFT, place[0], place[1], place[2])


@njit(cache=True)
def _sweep_along(memory, points, starts, frame, place, offset, r1, r3):
    """Push the proxy on, along the normal where it was met, by what its r1 sphere lacks to let the moved cloud pass."""
    vx, vy, vz = place[0] - memory[SHIFT], place[1] - memory[SHIFT + 1], place[2] - memory[SHIFT + 2]
    moved = math.sqrt(vx * vx + vy * vy + vz * vz)
    if moved == 0.0:
        return
    vx, vy, vz = vx / moved, vy / moved, vz / moved
    # Seen from the cloud, the proxy came the other way.
    x = memory[POSITION] - memory[SHIFT]
    y = memory[POSITION + 1] - memory[SHIFT + 1]
    z = memory[POSITION + 2] - memory[SHIFT + 2] + offset
    met = way_ahead(points, starts, frame, x, y, z, -vx, -vy, -vz, moved, r1)
    if met == moved:
        return
    _, nx, ny, nz, _, _, _, _ = _look(
        memory, points, starts, frame, x - met * vx, y - met * vy, z - met * vz, r1, r3
    )
    pushed = (moved - met) * (nx * vx + ny * vy + nz * vz)
    if pushed > 0.0:
        memory[POSITION] += pushed * nx
        memory[POSITION + 1] += pushed * ny
        memory[POSITION + 2] += pushed * nz


@njit(cache=True)
def _look(memory, points, starts, frame, x, y, z, r1, r3):
    """`neighbourhood` with the normal made a unit vector on the proxy's side of the cloud; 0 without points."""
    nearest, nx, ny, nz, total, mx, my, mz = neighbourhood(points, starts, frame, x, y, z, r1, r3)
    lx, ly, lz = memory[NORMAL], memory[NORMAL + 1], memory[NORMAL + 2]
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    if total > 0.0 and size > 1e-9 * total:
        nx, ny, nz = nx / size, ny / size, nz / size
        if nearest < r1 and nx * lx + ny * ly + nz * lz < 0.0:
            nx, ny, nz = -nx, -ny, -nz
    elif nearest < r3:
        # The directions cancel: the last normal, or the table's if there was none.
        nx, ny, nz = lx, ly, lz
        if lx == 0.0 and ly == 0.0 and lz == 0.0:
            nz = 1.0
    return nearest, nx, ny, nz, total, mx, my, mz


@njit(cache=True)
def _put(memory, place, x, y, z):
    memory[place] = x
    memory[place + 1] = y
    memory[place + 2] = z
