"""Where a point stands to a surface: its depth, and the outward normal there."""

import math

from numba import njit

from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import UP, Vector, unit
from mmt_drake.surfaces.height_field import height_of
from mmt_drake.surfaces.layout import AT, CYLINDER, HEIGHTS, KIND, MESH, OWN, PLANE, SPHERE, STEP, TURN
from mmt_drake.surfaces.mesh import locate_on_mesh

_NEWTON_STEPS = 12
_NEAR_ENOUGH = 1e-12  # [m] of the foot


@njit(cache=True, error_model="numpy")
def locate(surface: Array, at: Vector, held: Vector) -> tuple[float, Vector]:
    """Depth of a point below a surface [m], negative above it, and the outward unit normal there.

    Below a sharp edge two faces are near. The one with the normal `held` then counts as long as it is above the point:
    so who presses on a face meets that until leaving over its edge.

    Args:
        surface: of `Shape.packed`.
        at: the point [m], in the frame in which the surface is given.
        held: normal of the face in contact; zero without a contact.
    """
    c, s = surface[TURN], surface[TURN + 1]
    dx, dy, dz = at[0] - surface[AT], at[1] - surface[AT + 1], at[2] - surface[AT + 2]
    own = (c * dx + s * dy, c * dy - s * dx, dz)
    kind = surface[KIND]
    if kind == PLANE:
        n = (surface[OWN], 0.0, surface[OWN + 1])
        depth = -(n[0] * own[0] + n[2] * own[2])
    elif kind == SPHERE:
        r = surface[OWN]
        out = (own[0], own[1], own[2] + r)
        depth = r - math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
        n = unit(out, UP)
    elif kind == CYLINDER:
        r = surface[OWN]
        out = (own[0], 0.0, own[2] + r)
        depth = r - math.sqrt(out[0] * out[0] + out[2] * out[2])
        n = unit(out, UP)
    elif kind == STEP:
        depth, n = _step(surface[OWN], own, c * held[0] + s * held[1], held[2])
    elif kind == MESH:
        depth, n = locate_on_mesh(surface, own)
    else:
        depth, n = _under_heights(surface, own)
    return depth, (c * n[0] - s * n[1], s * n[0] + c * n[1], n[2])


@njit(cache=True, error_model="numpy")
def _step(fall: float, at: Vector, held_x: float, held_z: float) -> tuple[float, Vector]:
    x, z = at[0], at[2]
    out = (1.0, 0.0, 0.0)
    if x > 0.0:
        if z > 0.0 and z * z + x * x < (z + fall) * (z + fall):  # the edge is nearer than the lower level
            return -math.sqrt(x * x + z * z), unit((x, 0.0, z), UP)
        if z > -fall and x < z + fall:
            return -x, out
        return -(z + fall), UP
    if z >= 0.0 or held_z > 0.5:
        return -z, UP
    if z < -fall:
        return (-x, out) if -x < -z else (-z, UP)
    return (-x, out) if held_x > 0.5 or -x < -z else (-z, UP)


@njit(cache=True, error_model="numpy")
def _height(surface: Array, u: float, v: float) -> tuple[float, float, float, float, float, float]:
    """Of the surface at (u, v), its slopes along both and its second derivatives uu, uv, vv."""
    if surface[KIND] == HEIGHTS:
        return height_of(surface, u, v)
    curved = 1.0 / surface[OWN]
    return 0.5 * curved * (u * u - v * v), curved * u, -curved * v, curved, 0.0, -curved


@njit(cache=True, error_model="numpy")
def _under_heights(surface: Array, at: Vector) -> tuple[float, Vector]:
    """The nearest point of a surface z = h(x, y), by Newton's steps where they lead there, else across the tangent."""
    u, v = at[0], at[1]
    for _ in range(_NEWTON_STEPS):
        h, hx, hy, hxx, hxy, hyy = _height(surface, u, v)
        away = h - at[2]
        fx, fy = u - at[0] + away * hx, v - at[1] + away * hy
        a, b, d = 1.0 + hx * hx + away * hxx, hx * hy + away * hxy, 1.0 + hy * hy + away * hyy
        if not (a > 0.1 and a * d - b * b > 0.1 * a):  # further from it than its curvature allows
            a, b, d = 1.0 + hx * hx, hx * hy, 1.0 + hy * hy
        scale = 1.0 / (a * d - b * b)
        du, dv = scale * (d * fx - b * fy), scale * (a * fy - b * fx)
        u, v = u - du, v - dv
        if abs(du) + abs(dv) < _NEAR_ENOUGH:
            break
    h, hx, hy, _, _, _ = _height(surface, u, v)
    n = unit((-hx, -hy, 1.0), UP)
    return n[0] * (u - at[0]) + n[1] * (v - at[1]) + n[2] * (h - at[2]), n
