"""The contact in three dimensions: a tip on a surface, in the frame of the plane that touches it.

With the outward unit normal n, the depth delta of the tip p and its velocity u relative to the surface's body::

    N  = k delta + b delta'                     along n (eq. 8)
    T  = k2 D + b2 u_t,   D' = u_t - slip       across n: the spring D is anchored where the tip touched
    |T| <= mu max(N, 0)                         and where that is reached the anchor is carried along, along T
    F  = N n - T                                on the tip

The plane turns as the tip glides; D then keeps its length and turns with it, so that turning stores no energy. On a
level plane without slip this is `mmt_drake.model.flexible_box`: F_z = -k z - b v_z and F_x = -(k2 d + b2 (v - v_m)).

What it does to the body depends on what the surface is fixed to. One that is fixed to the *body* goes with it, and the
body, which the table holds level, is moved by the horizontal part of -F. One that is fixed to the *world* stays, and
the body slides along it: its two axes lie in the plane that touches, turned from level the shortest way, T alone moves
it, and all goes on as on a level plane.
"""

import math
from typing import NamedTuple

from numba import njit

from mmt_drake.model.forces import Spring, level_spring
from mmt_drake.model.hermite import Cubic, position_at, velocity_at
from mmt_drake.model.parameters import Constants
from mmt_drake.numeric.vectors import ZERO, Vector, across, dot, length, minus, plus, times, unit

_NEVER_BELOW = 1e-9  # of 1 + n_z, where the way from level is no longer unique


class Facet(NamedTuple):
    """The plane that touches the surface under the tip.

    Attributes:
        n: outward unit normal.
        c: n . x of its points x [m], counted from the body where that carries the surface.
        world: 1 where the surface is fixed to the world, 0 where the body carries it.
        mu: friction of the tip on it; infinite: it never slips.
    """

    n: Vector
    c: float
    world: float
    mu: float


class Touch(NamedTuple):
    """A tip in contact at an instant.

    Attributes:
        normal: N [N].
        tangential: T of the spring and damper before it is limited by friction [N].
        limited: the part of it that friction lets through, at most 1.
    """

    normal: float
    tangential: Vector
    limited: float


class Paths(NamedTuple):
    """The tip between two samples [m]."""

    x: Cubic
    y: Cubic
    z: Cubic


@njit(error_model="numpy", forceinline=True)
def is_level(facet: Facet) -> bool:
    """Whether it is the table's own plane, on which the tip never slips; or, all zeros, that of a state not begun."""
    return facet.mu == 0.0 or (facet.n[2] == 1.0 and facet.c == 0.0 and facet.mu == math.inf)


@njit(error_model="numpy", forceinline=True)
def height_above(facet: Facet, at: Vector) -> float:
    """Of a point above the plane [m]; `at` from the body where that carries the surface."""
    return dot(facet.n, at) - facet.c


@njit(error_model="numpy")
def between_facets(before: Facet, after: Facet) -> Facet:
    """The plane half way from one to the next."""
    both = plus(before.n, after.n)
    size = length(both)
    if size < 1e-6:
        return after
    return Facet(times(1.0 / size, both), (before.c + after.c) / size, after.world, after.mu)


@njit(error_model="numpy")
def axes_of(facet: Facet) -> tuple[Vector, Vector]:
    """What a step of the body along its x and y moves the surface by, across n [m/m].

    Of a surface that the body carries these are x and y without their parts along n; of another the two axes of the
    plane, level ones turned the shortest way.
    """
    n = facet.n
    if facet.world == 0.0:
        return across((1.0, 0.0, 0.0), n), across((0.0, 1.0, 0.0), n)
    scale = 1.0 / max(1.0 + n[2], _NEVER_BELOW)
    return (1.0 - n[0] * n[0] * scale, -n[0] * n[1] * scale, -n[0]), (
        -n[0] * n[1] * scale,
        1.0 - n[1] * n[1] * scale,
        -n[1],
    )


@njit(error_model="numpy", forceinline=True)
def turned(d: Vector, n: Vector) -> Vector:
    """A deflection turned into the plane of a normal, as long as before."""
    flat = across(d, n)
    size = length(flat)
    return times(length(d) / size, flat) if size > 0.0 else flat


@njit(error_model="numpy")
def touching(facet: Facet, at: Vector, rate: Vector, d: Vector, body: Vector, p: Constants) -> Touch:
    """The contact at an instant.

    Args:
        facet: under the tip.
        at: the tip, from the body where that carries the surface [m].
        rate: its velocity, in the table frame [m/s].
        d: deflection of the contact spring, across n [m].
        body: velocity of the body, its third number 0 [m/s].
        p: of the body.
    """
    first, second = axes_of(facet)
    u = minus(across(rate, facet.n), plus(times(body[0], first), times(body[1], second)))
    relative = rate if facet.world != 0.0 else minus(rate, body)
    normal = -p.normal_k * height_above(facet, at) - p.normal_b * dot(facet.n, relative)
    tangential = plus(times(p.k2, d), times(p.b2, u))
    return Touch(normal, tangential, _share(facet.mu, normal, length(tangential)))


@njit(error_model="numpy", forceinline=True)
def _share(mu: float, normal: float, tangential: float) -> float:
    return 1.0 if mu == math.inf else let_through(mu * normal if normal > 0.0 else 0.0, tangential)


@njit(error_model="numpy", forceinline=True)
def let_through(limit: float, tangential: float) -> float:
    """The part of a tangential force [N] that friction of a level [N] lets through, at most 1."""
    return 1.0 if tangential <= limit else limit / tangential


@njit(error_model="numpy", forceinline=True)
def force_of(touch: Touch, n: Vector) -> Vector:
    """On the tip [N]."""
    return minus(times(touch.normal, n), times(touch.limited, touch.tangential))


@njit(error_model="numpy")
def carried(d: Vector, touch: Touch, h: float, k: float, b: float) -> Vector:
    """The deflection after h [s] in which the tip slipped, where it did: the anchor follows along T.

    Spring k [N/m] and damper b [N s/m] are in a row with the friction: what exceeds it, E - mu N, slips by
    (E - mu N) h/(b + k h), the step of Euler backwards; without a damper the deflection comes back to the limit.
    """
    if touch.limited == 1.0:
        return d
    gives = b + k * h
    return minus(d, times((1.0 - touch.limited) * h / gives, touch.tangential)) if gives > 0.0 else d


# What moves the body between two samples.
@njit(error_model="numpy", forceinline=True)
def _sum(a: float, first: Cubic, b: float, second: Cubic) -> Cubic:
    """a first + b second."""
    return Cubic(
        a * first.x0 + b * second.x0, a * first.v0 + b * second.v0, a * first.c2 + b * second.c2,
        a * first.c3 + b * second.c3,
    )  # fmt: skip


@njit(error_model="numpy", forceinline=True)
def _rate(path: Cubic) -> Cubic:
    return Cubic(path.v0, 2.0 * path.c2, 3.0 * path.c3, 0.0)


@njit(error_model="numpy", forceinline=True)
def _from(path: Cubic, x0: float) -> Cubic:
    return Cubic(path.x0 - x0, path.v0, path.c2, path.c3)


@njit(error_model="numpy")
def local_path(paths: Paths, axis: Vector) -> Cubic:
    """The tip's way along an axis of the plane [m]."""
    return _sum(1.0, _sum(axis[0], paths.x, axis[1], paths.y), axis[2], paths.z)


@njit(error_model="numpy")
def spring_of(
    facet: Facet, i: int, paths: Paths, other: Cubic, anchor: Vector, slips: bool, way: Vector, p: Constants
) -> Spring:
    """The contact as it acts on the body's x (0) or y (1), while the plane stays what it is.

    Args:
        facet: under the tip, in the middle of the time in question.
        i: the axis.
        paths: of the tip.
        other: of the body along its other axis [m].
        anchor: tip less body where the spring is unstretched [m]; of a surface that the body carries.
        slips: whether friction limits T.
        way: unit vector along T.
        p: of the body.

    Returns:
        Spring and damper along the axis, and what else pushes the body.
    """
    n, k, b = facet.n, p.normal_k, p.normal_b
    if facet.world != 0.0:
        if not slips:
            return level_spring(p)
        above = _from(local_path(paths, n), facet.c)
        share = -facet.mu * dot(axes_of(facet)[i], way)
        return Spring(0.0, 0.0, _sum(share * k, above, share * b, _rate(above)))
    j = 1 - i
    across_it, beside = (paths.y, anchor[1]) if i == 0 else (paths.x, anchor[0])
    # What the way along n has of the other two axes, from the anchor; and of the anchor itself.
    moved = _from(_sum(1.0, across_it, -1.0, other), beside)
    rest = _sum(n[j], moved, n[2], _from(paths.z, anchor[2]))
    rate, lies = _rate(rest), dot(n, anchor) - facet.c
    if slips:
        w = facet.mu * way[i] - n[i]
        push = _sum(-w * k, _from(rest, -lies), -w * b, rate)
        return Spring(-w * k * n[i], -w * b * n[i], push)
    push = _sum((k - p.k2) * n[i], rest, (b - p.b2) * n[i], rate)
    own = n[i] * n[i]
    stiff, damped = own * k + (1.0 - own) * p.k2, own * b + (1.0 - own) * p.b2
    return Spring(stiff, damped, _from(push, -k * n[i] * lies))


@njit(error_model="numpy", forceinline=True)
def shifted(path: Cubic, s: float) -> Cubic:
    """A path that is counted from s [s], counted from 0."""
    return Cubic(position_at(path, -s), velocity_at(path, -s), path.c2 - 3.0 * path.c3 * s, path.c3)


@njit(error_model="numpy", forceinline=True)
def direction(touch: Touch) -> Vector:
    """Unit vector along T; 0 where there is none."""
    return unit(touch.tangential, ZERO)
