"""A closed mesh of triangles as a surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import UP, ZERO, Vector, cross, dot, get, length, minus, plus, times, unit
from mmt_drake.surfaces import layout
from mmt_drake.surfaces.layout import OWN
from mmt_drake.surfaces.shapes import Layout, Shape

SUFFIXES = (".ply", ".stl", ".obj")
REACH = 0.05
"""[m] from a mesh, on either side; further away a point counts as that far above it."""

_LARGEST = 2.0  # [m] of a side: larger than an object on a table, and what millimetres look like
_MOST_BYTES, _MOST_TRIANGLES, _MOST_CELLS = 1 << 26, 500_000, 1 << 21

# Behind `layout.OWN`: corner of the grid of cells [m], their edge [m], how many along x, y, z, where the triangles
# stand; then where each cell's list begins, these lists, and 9 coordinates and 9 of normals of each triangle.
_CORNER, _EDGE, _CELLS, _TRIANGLES, _STARTS = OWN, OWN + 3, OWN + 4, OWN + 7, OWN + 8
_EACH = 18


@dataclass(frozen=True, kw_only=True)
class Mesh(Shape):
    """A closed mesh, whose origin is that of its file. Its normal is mixed from those at a facet's corners.

    Attributes:
        file: `.ply`, `.stl` or `.obj` in metres, normals outward.
    """

    file: str = ""
    LAID: ClassVar = False
    KIND: ClassVar = layout.MESH

    def __post_init__(self) -> None:
        super().__post_init__()
        self.triangles()

    def triangles(self) -> tuple[Array, Array]:
        """(n, 3, 3) corners of the triangles [m], and the outward unit normals there.

        Raises:
            BadInput: see `read_mesh`.
        """
        return read_mesh(str(Path(self.file).absolute()) if self.file else "")

    def own_numbers(self) -> Array:
        """What `locate_on_mesh` reads."""
        return mesh_numbers(*self.triangles())

    def patch(self, uv: Array) -> Array:
        """As many points as are asked for, strewn evenly over the whole mesh."""
        corners, _ = self.triangles()
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        upto = np.cumsum(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
        drawn = np.random.default_rng(0)
        which = np.searchsorted(upto, (np.arange(len(uv)) + drawn.random(len(uv))) / len(uv) * upto[-1])
        which = np.minimum(which, len(corners) - 1)
        s, t = np.sqrt(drawn.random(len(uv)))[:, None], drawn.random(len(uv))[:, None]
        return np.asarray((1.0 - s) * a[which] + s * (1.0 - t) * b[which] + s * t * c[which])

    def cloud(
        self, n: int, size: tuple[float, float] = (0.3, 0.3), *, arranged: Layout = "regular", seed: int = 0
    ) -> Cloud:
        """n points strewn evenly over the whole mesh; see `Shape.cloud`, of which the rest has no meaning here."""
        points, packed = self.points(np.zeros((n, 2))), self.packed()
        from mmt_drake.surfaces.locate import locate  # which knows meshes

        normals = [locate(packed, tuple(point), ZERO)[1] for point in points]
        return Cloud(points, normals=np.array(normals).reshape(-1, 3))


@lru_cache(maxsize=4)
def read_mesh(file: str) -> tuple[Array, Array]:
    """(n, 3, 3) corners of a file's triangles [m], and the outward unit normals there.

    Raises:
        BadInput: no such file, nothing readable in it, a coordinate that is not finite, a mesh that is not closed or
            inside out, or larger than 2 m.
    """
    path = Path(file)
    if path.suffix.lower() not in SUFFIXES or not path.is_file():
        raise BadInput(file or "surface", at="file", found="no such mesh", expected=" or ".join(SUFFIXES))
    if path.stat().st_size > _MOST_BYTES:
        raise BadInput(path, found=f"{path.stat().st_size} bytes", expected=f"at most {_MOST_BYTES >> 20} MiB")
    import open3d

    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        mesh = open3d.io.read_triangle_mesh(path)
    mesh.remove_duplicated_vertices()
    return checked_mesh(np.asarray(mesh.vertices), np.asarray(mesh.triangles), path)


def checked_mesh(vertices: Array, triangles: NDArray[np.integer[Any]], source: object) -> tuple[Array, Array]:
    """Corners and normals of a mesh that may be a surface, see `read_mesh`.

    Args:
        vertices: (k, 3) [m].
        triangles: (n, 3) indices of vertices, counterclockwise seen from outside.
        source: for messages.

    Raises:
        BadInput: as there.
    """
    if not 4 <= len(triangles) <= _MOST_TRIANGLES:
        raise BadInput(source, found=f"{len(triangles)} triangles", expected=f"4 to {_MOST_TRIANGLES}")
    if not np.isfinite(vertices).all():
        bad = int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0])
        raise BadInput(source, at=f"vertex {bad}", found=vertices[bad], expected="finite coordinates")
    size = float(np.ptp(vertices, axis=0).max())
    if not size <= _LARGEST:
        expected = f"at most {_LARGEST:g} m: a mesh in metres, not in millimetres"
        raise BadInput(source, found=f"a mesh of {size:.4g} m", expected=expected)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    both = {tuple(edge) for edge in edges.tolist()}
    if len(both) != len(edges) or any((b, a) not in both for a, b in both):
        raise BadInput(source, found="a mesh that is not closed, or not turned one way", expected="a closed mesh")
    corners = vertices[triangles]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    if not np.einsum("ij,ij->", a, np.cross(b, c)) > 0.0:
        raise BadInput(source, found="a mesh inside out", expected="triangles counterclockwise, seen from outside")
    normals = np.zeros_like(vertices)
    for i in range(3):  # each triangle counts by its angle there
        at, one, other = corners[:, i], corners[:, (i + 1) % 3], corners[:, (i + 2) % 3]
        raised = np.cross(one - at, other - at)
        angle = np.arctan2(np.linalg.norm(raised, axis=1), np.einsum("ij,ij->i", one - at, other - at))
        area = np.linalg.norm(raised, axis=1)
        np.add.at(normals, triangles[:, i], raised * (angle / np.where(area > 0.0, area, 1.0))[:, None])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    return corners, normals[triangles]


def mesh_numbers(corners: Array, normals: Array) -> Array:
    """What `locate_on_mesh` reads: the triangles sorted into cubic cells.

    Args:
        corners, normals: (n, 3, 3) of `checked_mesh`.
    """
    low, high = corners.min(axis=(0, 1)) - REACH, corners.max(axis=(0, 1)) + REACH
    edge = float(np.clip(np.linalg.norm(np.ptp(corners, axis=1), axis=1).mean(), 2e-3, 2e-2))
    edge = max(edge, float((np.prod(high - low) / _MOST_CELLS) ** (1.0 / 3.0)))
    cells = np.maximum(np.ceil((high - low) / edge).astype(int), 1)
    first = np.floor((corners.min(axis=1) - low) / edge).astype(int)
    last = np.floor((corners.max(axis=1) - low) / edge).astype(int)
    lists: dict[int, list[int]] = {}
    for k, (f, t) in enumerate(zip(first, last, strict=True)):
        for z in range(f[2], t[2] + 1):
            for y in range(f[1], t[1] + 1):
                for x in range(f[0], t[0] + 1):
                    lists.setdefault(int(x + cells[0] * (y + cells[1] * z)), []).append(k)
    starts = np.zeros(int(np.prod(cells)) + 1)
    for cell, members in lists.items():
        starts[cell + 1] = len(members)
    listed = [k for cell in sorted(lists) for k in lists[cell]]
    begin = _STARTS + len(starts) + len(listed)
    each = np.concatenate([corners.reshape(-1, 9), normals.reshape(-1, 9)], axis=1)
    return np.concatenate([low, [edge], cells, [begin], np.cumsum(starts), listed, each.ravel()])


@njit(cache=True, error_model="numpy")
def _nearest(surface: Array, k: int, p: Vector) -> Vector:
    """Shares of a triangle's corners in its point nearest to p (Ericson, Real-Time Collision Detection, 5.1.5)."""
    at = int(surface[_TRIANGLES]) + _EACH * k
    a, b, c = get(surface, at), get(surface, at + 3), get(surface, at + 6)
    ab, ac = minus(b, a), minus(c, a)
    ap, bp, cp = minus(p, a), minus(p, b), minus(p, c)
    d1, d2, d3, d4, d5, d6 = dot(ab, ap), dot(ac, ap), dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp)
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / (d1 - d3)
        return 1.0 - t, t, 0.0
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 0.0, 1.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6)
        return 1.0 - t, 0.0, t
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 0.0, 1.0 - t, t
    total = va + vb + vc
    return va / total, vb / total, vc / total


@njit(cache=True, error_model="numpy")
def _mixed(surface: Array, at: int, share: Vector) -> Vector:
    """Of three vectors that stand one behind the other."""
    first, second, third = get(surface, at), get(surface, at + 3), get(surface, at + 6)
    return plus(plus(times(share[0], first), times(share[1], second)), times(share[2], third))


@njit(cache=True, error_model="numpy")
def locate_on_mesh(surface: Array, p: Vector) -> tuple[float, Vector]:
    """Depth of a point below a mesh [m] and the normal there; `-REACH` and up where none is so near.

    Args:
        surface: of `Shape.packed`.
        p: from its origin [m].
    """
    edge = surface[_EDGE]
    nx, ny, nz = int(surface[_CELLS]), int(surface[_CELLS + 1]), int(surface[_CELLS + 2])
    cx = math.floor((p[0] - surface[_CORNER]) / edge)
    cy = math.floor((p[1] - surface[_CORNER + 1]) / edge)
    cz = math.floor((p[2] - surface[_CORNER + 2]) / edge)
    if not (0 <= cx < nx and 0 <= cy < ny and 0 <= cz < nz):
        return -REACH, UP
    lists = _STARTS + nx * ny * nz + 1
    best, nearest, share = REACH, -1, (0.0, 0.0, 0.0)
    for ring in range(math.ceil(REACH / edge) + 1):
        if best <= (ring - 1) * edge:
            break
        for z in range(max(cz - ring, 0), min(cz + ring + 1, nz)):
            for y in range(max(cy - ring, 0), min(cy + ring + 1, ny)):
                shell = abs(z - cz) == ring or abs(y - cy) == ring
                for x in range(cx - ring, cx + ring + 1, 1 if shell or ring == 0 else 2 * ring):
                    if not 0 <= x < nx:
                        continue
                    cell = _STARTS + x + nx * (y + ny * z)
                    for i in range(int(surface[cell]), int(surface[cell + 1])):
                        k = int(surface[lists + i])
                        found = _nearest(surface, k, p)
                        away = length(minus(p, _mixed(surface, int(surface[_TRIANGLES]) + _EACH * k, found)))
                        if away < best:
                            best, nearest, share = away, k, found
    if nearest < 0:
        return -REACH, UP
    at = int(surface[_TRIANGLES]) + _EACH * nearest
    flat = cross(minus(get(surface, at + 3), get(surface, at)), minus(get(surface, at + 6), get(surface, at)))
    n = unit(_mixed(surface, at + 9, share), unit(flat, UP))
    return (-best if dot(minus(p, _mixed(surface, at, share)), n) > 0.0 else best), n
