"""Things of a scene, as three.js reads them (its JSON object format 4), which draws for Meshcat."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

_IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
_Y_TO_Z = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1]  # column by column; a cylinder's axis is y there
_ROUND = 32  # sides of what is round

Thing = dict[str, Any]


def rgb(colour: str) -> list[float]:
    """(3) of `#RRGGBB`, 0 to 1."""
    return [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]


def sphere(radius: float, colour: str, opacity: float = 1.0) -> Thing:
    """A sphere about the origin [m]."""
    return _mesh("Sphere", colour, opacity, radius=radius, widthSegments=_ROUND, heightSegments=_ROUND)


def box(size: Sequence[float], colour: str, opacity: float = 1.0) -> Thing:
    """A box (3) about the origin [m]."""
    x, y, z = map(float, size)
    return _mesh("Box", colour, opacity, width=x, height=y, depth=z)


def cylinder(radius: float, length: float, colour: str, opacity: float = 1.0, *, top: float | None = None) -> Thing:
    """A cylinder about the origin, along z [m]; with another radius at its top, a cone."""
    radii = {"radiusTop": radius if top is None else top, "radiusBottom": radius}
    return _mesh("Cylinder", colour, opacity, _Y_TO_Z, **radii, height=length, radialSegments=_ROUND)


def cloud(points: NDArray[np.float64], size: float, colour: str) -> Thing:
    """Points (n, 3) [m], each a square of that size [m]."""
    numbers = {"itemSize": 3, "type": "Float32Array", "array": points.astype("<f4").tobytes(), "normalized": False}
    geometry = {"type": "BufferGeometry", "data": {"attributes": {"position": numbers}}}
    return _thing("Points", geometry, {"type": "PointsMaterial", "color": int(colour[1:], 16), "size": size}, _IDENTITY)


def _mesh(kind: str, colour: str, opacity: float, matrix: Sequence[float] = _IDENTITY, **sizes: float) -> Thing:
    seen = {"color": int(colour[1:], 16), "opacity": opacity, "transparent": opacity < 1.0}
    return _thing("Mesh", {"type": f"{kind}Geometry", **sizes}, {"type": "MeshPhongMaterial", **seen}, matrix)


def _thing(kind: str, geometry: Thing, material: Thing, matrix: Sequence[float]) -> Thing:
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": "geometry", **geometry}],
        "materials": [{"uuid": "material", **material}],
        "object": {"uuid": "object", "type": kind, "geometry": "geometry", "material": "material", "matrix": matrix},
    }
