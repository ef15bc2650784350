"""Where points stand to surfaces, against closed forms, and what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.surfaces import Cylinder, HeightField, Mesh, Plane, Saddle, Shape, Sphere, Step, locate
from mmt_drake.surfaces.height_field import height_of
from mmt_drake.surfaces.layout import OWN
from mmt_drake.surfaces.mesh import checked_mesh, mesh_numbers

FREE = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)
SMOOTH: list[Shape] = [
    Plane(tilt=0.0),
    Plane(tilt=60.0, turned=30.0, at=(0.01, 0.02, -0.03)),
    Sphere(at=(0.01, -0.02, 0.005)),
    Cylinder(radius=0.05, turned=40.0),
    Saddle(radius=0.1, turned=-20.0),
    HeightField(turned=15.0),
]


def at(surface: Shape, *point: float, held: tuple[float, float, float] = FREE) -> tuple[float, Any]:
    depth, normal = locate(surface.packed(), point, held)
    return depth, np.array(normal)


@pytest.mark.parametrize("surface", SMOOTH, ids=lambda s: type(s).__name__)
def test_a_point_off_the_surface_along_its_normal_has_that_depth_and_the_same_normal(surface: Shape) -> None:
    packed = surface.packed()
    for foot in surface.points(np.random.default_rng(1).uniform(-0.06, 0.06, (200, 2))):
        on, normal = locate(packed, tuple(foot), FREE)
        assert on == pytest.approx(0.0, abs=1e-10)
        assert math.hypot(*normal) == pytest.approx(1.0, abs=1e-12)
        for depth in (0.005, -0.01):
            found, there = locate(packed, tuple(foot - depth * np.array(normal)), FREE)
            assert found == pytest.approx(depth, abs=1e-9)
            assert there == pytest.approx(normal, abs=1e-7)


@pytest.mark.parametrize("surface", SMOOTH, ids=lambda s: type(s).__name__)
def test_the_depth_falls_along_the_normal_at_a_rate_of_one_and_not_across_it(surface: Shape) -> None:
    packed, h = surface.packed(), 1e-6
    for foot in surface.points(np.random.default_rng(2).uniform(-0.06, 0.06, (50, 2))):
        point = foot - 0.003 * np.array(locate(packed, tuple(foot), FREE)[1])
        _, normal = locate(packed, tuple(point), FREE)
        ends = [[locate(packed, tuple(point + s * h * e), FREE)[0] for e in np.eye(3)] for s in (-1, 1)]
        assert (np.array(ends[0]) - ends[1]) / (2.0 * h) == pytest.approx(normal, abs=1e-6)


def test_a_plane_leans_as_far_as_it_is_told_and_where_it_is_turned() -> None:
    depth, normal = at(Plane(tilt=30.0, turned=90.0), 0.0, 0.1, 0.0)
    assert normal == pytest.approx([0.0, 0.5, math.sqrt(0.75)], abs=1e-12)
    assert depth == pytest.approx(-0.05)


def test_a_ball_and_a_cylinder_are_round() -> None:
    depth, normal = at(Sphere(radius=0.06), 0.03, 0.04, -0.06)
    assert depth == pytest.approx(0.01)
    assert normal == pytest.approx([0.6, 0.8, 0.0], abs=1e-12)
    depth, normal = at(Cylinder(radius=0.05, turned=90.0), 7.0, 0.03, -0.01)
    assert depth == pytest.approx(0.0, abs=1e-12)
    assert normal == pytest.approx([0.0, 0.6, 0.8], abs=1e-12)


def test_who_presses_on_a_face_of_a_step_meets_that_until_it_leaves_over_the_edge() -> None:
    step = Step(fall=0.02)
    assert at(step, -0.1, 0.0, -0.001)[0] == pytest.approx(0.001)
    depth, normal = at(step, -0.002, 0.0, -0.004, held=UP)
    assert (depth, *normal) == pytest.approx((0.004, 0.0, 0.0, 1.0))
    depth, normal = at(step, -0.002, 0.0, -0.004)
    assert (depth, *normal) == pytest.approx((0.002, 1.0, 0.0, 0.0))
    assert at(step, 0.001, 0.0, -0.004, held=UP)[0] < 0.0
    depth, normal = at(step, -0.004, 0.0, -0.002, held=(1.0, 0.0, 0.0))
    assert (depth, *normal) == pytest.approx((0.004, 1.0, 0.0, 0.0))
    assert at(step, 0.1, 0.0, -0.021)[0] == pytest.approx(0.001)
    assert at(step, 0.003, 0.0, 0.004)[0] == pytest.approx(-0.005)


def test_heights_on_a_grid_are_met_and_the_slope_between_them_has_no_jump() -> None:
    field = HeightField()
    packed, heights = field.packed(), field.heights()
    row, column = 12, 33
    u, v = ((i - 0.5 * (side - 1)) * field.spacing for i, side in zip((column, row), heights.shape[::-1], strict=True))
    assert height_of(packed, u, v)[0] == pytest.approx(heights[row, column], abs=1e-15)
    before, after = height_of(packed, u - 1e-9, v), height_of(packed, u + 1e-9, v)
    assert before[1] == pytest.approx(after[1], abs=1e-6)


@pytest.mark.parametrize("surface", [*SMOOTH, Step()], ids=lambda s: type(s).__name__)
def test_a_cloud_lies_on_its_surface_evenly(surface: Shape) -> None:
    cloud = surface.cloud(2000, (0.1, 0.1))
    packed = surface.packed()
    assert max(abs(locate(packed, tuple(point), FREE)[0]) for point in cloud.points()) < 1e-9
    assert cloud.spacing == pytest.approx(0.1 / math.sqrt(2000), rel=0.12)


def ball(radius: float = 0.06, rings: int = 60) -> tuple[Array, Any]:
    """A closed mesh of a ball about the origin."""
    polar = np.linspace(0.0, math.pi, rings + 1)[1:-1]
    around = np.arange(2 * rings) * math.pi / rings
    sides = [[math.sin(p) * math.cos(a), math.sin(p) * math.sin(a), math.cos(p)] for p in polar for a in around]
    vertices = radius * np.array([*sides, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    top, low, n = len(sides), len(sides) + 1, 2 * rings
    triangles = []
    for j in range(n):
        k = (j + 1) % n
        triangles += [[top, j, k], [low, (rings - 2) * n + k, (rings - 2) * n + j]]
        for i in range(rings - 2):
            a, b, c, d = i * n + j, i * n + k, (i + 1) * n + j, (i + 1) * n + k
            triangles += [[a, c, d], [a, d, b]]
    return vertices, np.array(triangles)


def test_a_mesh_of_a_ball_is_a_ball_to_the_size_of_its_facets() -> None:
    packed = np.concatenate([Plane().packed()[:OWN], mesh_numbers(*checked_mesh(*ball(), "ball"))])
    packed[0] = Mesh.KIND
    drawn = np.random.default_rng(3)
    out = drawn.standard_normal((300, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    for direction, depth in zip(out, drawn.uniform(-0.02, 0.02, 300), strict=True):
        found, normal = locate(packed, tuple((0.06 - depth) * direction), FREE)
        assert found == pytest.approx(depth, abs=5e-5)
        assert normal == pytest.approx(direction, abs=0.02)
    assert locate(packed, (0.0, 0.0, 0.5), FREE)[0] < -0.04


def test_the_normal_of_a_mesh_turns_evenly_though_its_facets_meet_at_nine_degrees() -> None:
    packed = np.concatenate([Plane().packed()[:OWN], mesh_numbers(*checked_mesh(*ball(rings=20), "ball"))])
    packed[0] = Mesh.KIND
    angles = np.linspace(0.2, 1.2, 4000)
    normals = [locate(packed, (0.0575 * math.sin(a), 0.002, 0.0575 * math.cos(a)), FREE)[1] for a in angles]
    turned = np.linalg.norm(np.diff(normals, axis=0), axis=1)
    assert turned.max() < 0.05 * math.radians(9.0)


def test_a_mesh_that_is_open_inside_out_not_finite_or_in_millimetres_is_refused_in_one_line(tmp_path: Path) -> None:
    vertices, triangles = ball(rings=6)
    for wrong, expected in (
        ((vertices, triangles[1:]), "not closed"),
        ((vertices, triangles[:, ::-1]), "inside out"),
        ((1000.0 * vertices, triangles), "millimetres"),
        ((np.where(vertices == vertices[3], np.nan, vertices), triangles), "finite"),
    ):
        with pytest.raises(BadInput, match=expected) as error:
            checked_mesh(*wrong, "file.ply")
        assert "\n" not in str(error.value)
    with pytest.raises(BadInput, match="no such mesh"):
        Mesh(file=str(tmp_path / "none.ply"))


def test_a_mesh_is_read_from_a_file(tmp_path: Path) -> None:
    import open3d

    vertices, triangles = ball(rings=8)
    shape = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(triangles)
    )
    open3d.io.write_triangle_mesh(str(tmp_path / "ball.ply"), shape)
    mesh = Mesh(file=str(tmp_path / "ball.ply"), at=(0.0, 0.0, -0.06))
    assert locate(mesh.packed(), (0.0, 0.0, -0.01), FREE)[0] == pytest.approx(0.01, abs=3e-4)
    assert len(mesh.cloud(500)) == 500


@pytest.mark.parametrize(
    ("text", "expected"),
    [("0,0\n0,nan\n", "finite|height"), ("0,5\n0,0\n", "metres"), ("0,0\n0\n", "as many"), ("0\n", "along each side")],
)
def test_heights_that_are_no_surface_are_refused_in_one_line(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "heights.csv").write_text(text)
    with pytest.raises(BadInput, match=expected) as error:
        HeightField(file=str(tmp_path / "heights.csv"))
    assert "\n" not in str(error.value)


def test_a_size_without_meaning_is_refused() -> None:
    for wrong in (lambda: Sphere(radius=0.0), lambda: Plane(tilt=90.0), lambda: Plane(at=(0.0, math.nan, 0.0))):
        with pytest.raises(BadInput):
            wrong()
