"""The scene: table, object, probe, hand, cloud, the proxy's spheres, contact normal and forces."""

import math
import time
from collections.abc import Mapping, Sequence

import numpy as np

from mmt_drake.analysis.plotting import GREEN, MEASURED, ORANGE, PURPLE, RED, RENDERED, SKY
from mmt_drake.cloud import Cloud, ProxySettings
from mmt_drake.model.scene_layout import ACROSS, ALONG, HEIGHT, STATE, THING, TOP, SeenState, X, Y, rows
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.clouds import thinned
from mmt_drake.viewer.shapes import box, cylinder, rgb, sphere
from mmt_drake.viewer.shapes import cloud as cloud_of
from mmt_drake.viewer.viewer import Viewer

Vector = Sequence[float] | Array

METRES_PER_NEWTON = 0.01
"""Length of a force's arrow."""

_NORMAL_LENGTH = 0.03  # [m]
_OBJECT_HEIGHT = 0.04  # [m]; nobody says how high it is
_AXES = 0.05  # length of the table frame's axes, x red, y green, z blue [m]
_TABLE = (0.8, 0.8, 0.01)  # [m]
_TIP, _SHAFT = 0.003, 0.06  # radius of the probe's tip, length of its shaft [m]
_POINT = 0.0012  # [m]
_CLOUD_INTERVAL = 0.2  # between two clouds with other points: the browser has to take them in [s]
_BESIDE = 0.0005  # the object is drawn so far below the cloud that its points show [m]

_SEEN = 0.2  # what the camera shows from where it stands at first [m]
_HEAD = 0.25  # of an arrow: share of its length
_SHORTEST = 1e-3  # [m]; an arrow that is shorter is not shown

LEGEND = (
    ("probe, measured force", MEASURED),
    ("hand, rendered force", RENDERED),
    ("contact, surface normal", GREEN),
    ("surface as seen", PURPLE),
)
"""What is drawn, and its colour."""

_STATES = {
    SeenState.OCCLUDED: SKY,
    SeenState.LOST: RED,
    SeenState.FOUND: GREEN,
    SeenState.MERGED: ORANGE,
    SeenState.SPLIT: ORANGE,
    SeenState.NEW: GREEN,
    SeenState.CARRIED: PURPLE,
}
"""Colours of objects of which something is told."""
_NOTHING = (0.0, 0.0, 0.0)
_OBJECT, _WOOD = "#8CBF99", "#998570"
_SPHERES = {"r1": (RED, 0.35), "r2": (ORANGE, 0.25), "r3": (SKY, 0.15)}  # colour and opacity


class Arrow:
    """An arrow of any length and direction.

    Args:
        viewer: where it is drawn.
        path: in the scene tree.
        radius: of its shaft [m].
        colour: of all of it, `#RRGGBB`.
    """

    def __init__(self, viewer: Viewer, path: str, radius: float, colour: str) -> None:
        self._viewer, self._path = viewer, path
        shaft = 1.0 - _HEAD
        viewer.set_object(f"{path}/shaft", cylinder(radius, shaft, colour))
        viewer.set_transform(f"{path}/shaft", placed(0.0, 0.0, 0.5 * shaft))
        viewer.set_object(f"{path}/head", cylinder(2.5 * radius, _HEAD, colour, top=0.0))
        viewer.set_transform(f"{path}/head", placed(0.0, 0.0, 1.0 - 0.5 * _HEAD))
        self._shown = True
        self.show(np.zeros(3), np.zeros(3))

    def show(self, foot: Vector, vector: Vector) -> None:
        """Have it stand at `foot` (3) and reach to `foot + vector` (3) [m], table frame.

        It is hidden while it is shorter than 1 mm, or a number is not finite.
        """
        matrix = stretched(foot, vector)
        if (matrix is not None) != self._shown:
            self._shown = matrix is not None
            self._viewer.set_property(self._path, "visible", self._shown)
        if matrix is not None:
            self._viewer.set_transform(self._path, matrix)


class Scene:
    """Draws a set-up in the table frame; what is drawn stands under `/station`.

    Shapes are sent once; from then on only what has moved, when the viewer is flushed.

    Args:
        viewer: where to draw.
        proxy: radii of the contact detector's spheres.
    """

    PATH = "/station"

    def __init__(self, viewer: Viewer, proxy: ProxySettings | None = None) -> None:
        self._viewer = viewer
        proxy = proxy or ProxySettings()
        for name, colour, opacity in (("hand", RENDERED, 0.5), ("probe", MEASURED, 1.0)):
            viewer.set_object(self._at(f"{name}/tip"), sphere(_TIP, colour, opacity))
            viewer.set_transform(self._at(f"{name}/tip"), placed(0.0, 0.0, _TIP))  # its lowest point counts
            viewer.set_object(self._at(f"{name}/shaft"), cylinder(0.5 * _TIP, _SHAFT, colour, opacity))
            viewer.set_transform(self._at(f"{name}/shaft"), placed(0.0, 0.0, _TIP + 0.5 * _SHAFT))
        for name, (colour, opacity) in _SPHERES.items():
            viewer.set_object(self._at(f"proxy/{name}"), sphere(getattr(proxy, name), colour, opacity))
        self._normal = Arrow(viewer, self._at("normal"), 0.001, GREEN)
        self._measured = Arrow(viewer, self._at("force/measured"), 0.002, MEASURED)
        self._rendered = Arrow(viewer, self._at("force/rendered"), 0.002, RENDERED)
        self._touching = False
        self._drawn: Array | None = None  # base points of the cloud that is drawn
        self._next_points = -math.inf
        self._has_object = False
        self._things: dict[str, tuple[SeenState, tuple[float, float, float]]] = {}
        viewer.set_property("/Grid", "visible", False)  # it lies in the object's top
        viewer.set_transform("/Axes", np.diag([_AXES, _AXES, _AXES, 1.0]))
        self.look_at((0.0, 0.0, 0.0))

    def show(self, values: Mapping[str, Sequence[float]], cloud: Cloud | None) -> None:
        """What is known at an instant, by the names of the ports of `mmt_drake.systems.live_view.LiveView`."""
        if "scene" in values:
            self.show_objects(np.asarray(values["scene"]))
        if cloud is not None:
            self.show_cloud(cloud)
        if "body_position" in values and "scene" not in values:
            self.show_object(values["body_position"])
        if "motion" in values:
            self.show_hand(values["motion"][:3], values.get("rendered_force", _NOTHING))
        if "measurement" in values:
            self.show_probe(values["measurement"][:3], values["measurement"][6:9])
        touching = values.get("in_contact", _NOTHING)[0] > 0.5
        if "proxy" in values:
            self.show_proxy(values["proxy"], values.get("normal", _NOTHING), touching)
        else:
            self._touch(touching)

    def look_at(self, middle: Vector, width: float = 0.0) -> None:
        """Look at `middle` (3) [m], from so far that what is so wide [m] is seen."""
        x, y, z = (float(value) for value in middle)
        far = max(1.0, width / _SEEN)
        self._viewer.set_camera((x + 0.10 * far, y - 0.20 * far, z + 0.11 * far), (x, y, z))

    def hide(self, name: str) -> None:
        """Draw `hand`, `probe` or `proxy` no more."""
        self._viewer.set_property(self._at(name), "visible", False)

    def show_hand(self, position: Vector, force: Vector) -> None:
        """The operator's hand at `position` (3) [m], and the force (3) [N] that is rendered to it."""
        self._move("hand", position)
        self._rendered.show(position, METRES_PER_NEWTON * np.asarray(force))

    def show_probe(self, position: Vector, force: Vector) -> None:
        """The probe's tip at `position` (3) [m], green in contact, and the force (3) [N] that is measured there."""
        self._move("probe", position)
        self._measured.show(position, METRES_PER_NEWTON * np.asarray(force))

    def show_proxy(self, position: Vector, normal: Vector, touching: bool) -> None:
        """The proxy's spheres about `position` (3) [m], with the unit normal (3) of the surface while it touches."""
        self._move("proxy", position)
        self._normal.show(position, _NORMAL_LENGTH * np.asarray(normal) if touching else np.zeros(3))
        self._touch(touching)

    def _touch(self, touching: bool) -> None:
        if touching != self._touching:
            self._touching = touching
            colour = GREEN if touching else MEASURED
            self._viewer.set_property(self._at("probe/tip"), "color", [*rgb(colour), 1.0])

    def show_object(self, displacement: Vector) -> None:
        """The object and what is drawn of it, displaced by (2) [m]; nothing before the first cloud told its size."""
        if self._has_object:
            self._move("object", [displacement[0], displacement[1], 0.0])

    def show_objects(self, scene: Array) -> None:
        """Each object of a scene (72) as a box, coloured by what is seen of it; one that is taken away is hidden."""
        seen = rows(scene)
        if len(seen) and not self._has_object:
            self._has_object = True  # none is made of the cloud
            self._viewer.set_object(self._at("table"), box(_TABLE, _WOOD))
            low = float(seen[0, TOP] - seen[0, HEIGHT])
            self._viewer.set_transform(self._at("table"), placed(0.0, 0.0, low - 0.5 * _TABLE[2]))
        for row in seen:
            name, state = f"things/{row[THING]:.0f}", SeenState(int(row[STATE]))
            size = (float(row[ALONG]), float(row[ACROSS]), float(row[HEIGHT]))
            if self._things.get(name) != (state, size):
                self._things[name] = state, size
                self._viewer.set_object(self._at(name), box(size, _STATES.get(state, _OBJECT), 0.5))
                self._viewer.set_property(self._at(name), "visible", state != SeenState.TAKEN_AWAY)
            self._move(name, (row[X], row[Y], row[TOP] - 0.5 * row[HEIGHT] - _BESIDE))

    def show_cloud(self, cloud: Cloud) -> None:
        """The surface as the camera saw it last, thinned to 5000 points.

        Points are sent only if they changed, and five times a second of wall clock at most; until then the last ones
        stay. A cloud that moved rigidly is moved.
        """
        if self._drawn is not cloud.base:
            now = time.monotonic()
            if now < self._next_points:
                return
            self._next_points = now + _CLOUD_INTERVAL
            self._drawn = cloud.base
            points = thinned(cloud.base)
            self._viewer.set_object(self._at("cloud"), cloud_of(points, _POINT, PURPLE))
            if not self._has_object and len(points):
                self.draw_object(points)
        self._move("cloud", cloud.translation)

    def draw_object(self, points: Array) -> None:
        """A box below the surface that these points (n, 3) [m] span, and the table that it stands on."""
        low, high = points.min(axis=0), points.max(axis=0)
        (x, y, _), (width, depth, _) = 0.5 * (low + high), np.maximum(high - low, 1e-3)
        self._has_object = True
        viewer, middle = self._viewer, -0.5 * _OBJECT_HEIGHT - _BESIDE
        viewer.set_object(self._at("object/box"), box((width, depth, _OBJECT_HEIGHT), _OBJECT, 0.6))
        viewer.set_transform(self._at("object/box"), placed(x, y, middle))
        viewer.set_object(self._at("table"), box(_TABLE, _WOOD))
        viewer.set_transform(self._at("table"), placed(x, y, -_OBJECT_HEIGHT - _BESIDE - 0.5 * _TABLE[2]))

    def _move(self, name: str, position: Vector) -> None:
        x, y, z = (float(value) for value in position)
        if math.isfinite(x + y + z):
            self._viewer.set_transform(self._at(name), placed(x, y, z))

    def _at(self, name: str) -> str:
        return f"{self.PATH}/{name}"


def placed(x: float, y: float, z: float) -> Array:
    """The (4, 4) matrix that moves by (x, y, z) [m]."""
    return np.array([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


def stretched(foot: Vector, vector: Vector) -> Array | None:
    """The (4, 4) matrix that takes the unit vector along z, at the origin, to `vector` (3) at `foot` (3).

    Across its axis nothing is stretched. None where the length is below 1 mm or anything is not finite.
    """
    x, y, z = (float(value) for value in vector)
    px, py, pz = (float(value) for value in foot)
    length = math.sqrt(x * x + y * y + z * z)
    if not (length >= _SHORTEST and math.isfinite(length + px + py + pz)):
        return None
    a, b, c = x / length, y / length, z / length
    # An orthonormal frame about (a, b, c) without a branch at the pole: Duff et al., JCGT 6(1), 2017.
    sign = math.copysign(1.0, c)
    p = -1.0 / (sign + c)
    q = a * b * p
    return np.array(
        [
            [1.0 + sign * a * a * p, q, x, px],
            [sign * q, sign + b * b * p, y, py],
            [-sign * a, -b, z, pz],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
