"""Surfaces of an object: where a point stands to one, and clouds of them.

A surface says of a point its signed depth and the outward unit normal there. What a contact makes of these stands in
`mmt_drake.model.local_contact`, which knows no surface: only the plane that touches it under the tip.
"""

from mmt_drake.surfaces.height_field import HeightField
from mmt_drake.surfaces.locate import locate
from mmt_drake.surfaces.mesh import Mesh
from mmt_drake.surfaces.shapes import Cylinder, Plane, Saddle, Shape, Sphere, Step

__all__ = ["Cylinder", "HeightField", "Mesh", "Plane", "Saddle", "Shape", "Sphere", "Step", "locate"]
