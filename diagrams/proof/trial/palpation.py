"""The trial's cases on a surface: a tip that palpates, simulated by other means than the model's.

The tip is put below a point of the surface, at a depth along the normal there, so that nothing has to be searched for.
The load acts along that normal; friction is a spring with a slider (Jenkins 1962), fastened to the point, at 1 kHz.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from scipy.spatial.transform import Rotation

from mmt_drake.diagrams.proof.trial.cases import Case, Nominal, four
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.other_cases import case_of, off
from mmt_drake.diagrams.proof.trial.sizes import log
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import AXES, Recording
from mmt_drake.recording.check import completed
from mmt_drake.recording.signals import ORIENTATION

Values = Mapping[str, float]
Surface = Callable[[Array, Array], tuple[Array, Array, Array]]
"""Places x, y (n,) [m] -> height [m] and its slopes along x and y there."""

PALPATION: Final = "palpation"
"""Name of these cases where a plant is asked for."""
RATE_HZ, SUBSTEPS = 50.0, 20
_SPRING = 0.8  # of k: stiffness of the spring that friction pulls at
_POSITION_NOISE = 3e-6  # [m]


@dataclass(frozen=True)
class Tip:
    """A tip on its way over a surface, (n, 3) each.

    Attributes:
        place: where it is [m].
        up: the normal there.
        force: on it [N].
    """

    place: Array
    up: Array
    force: Array


def palpated(surface: Surface, way: Array, depth: Array, k: Array, *, b: float = 0.0, mu: float = 0.0) -> Tip:
    """A tip that presses into a surface and slips on it.

    Args:
        surface: what is palpated.
        way: (n, 2) places of the surface that the tip presses on, at 1 kHz [m].
        depth: (n,) along the normal [m].
        k: (n,) stiffness there [N/m].
        b: damping along the normal [N s/m].
        mu: friction.
    """
    height, slope_x, slope_y = surface(way[:, 0], way[:, 1])
    up = np.column_stack([-slope_x, -slope_y, np.ones_like(height)])
    up /= np.linalg.norm(up, axis=1)[:, np.newaxis]
    foot = np.column_stack([way, height])
    load = k * depth + b * np.gradient(depth) * RATE_HZ * SUBSTEPS
    stretch = np.zeros_like(foot)
    if mu > 0.0:
        _slid(foot, up, mu * load / (_SPRING * k), stretch)
    force = load[:, np.newaxis] * up - (_SPRING * k)[:, np.newaxis] * stretch
    return Tip(foot - depth[:, np.newaxis] * up, up, force)


@njit(cache=True)
def _slid(foot: Array, up: Array, longest: Array, stretch: Array) -> None:
    """How far the spring of friction is stretched, (n, 3) to be filled, where it may be no longer than `longest`."""
    for i in range(1, len(foot)):
        along = 0.0
        for j in range(3):
            stretch[i, j] = stretch[i - 1, j] + foot[i, j] - foot[i - 1, j]
            along += stretch[i, j] * up[i, j]
        size = 0.0
        for j in range(3):
            stretch[i, j] -= along * up[i, j]
            size += stretch[i, j] ** 2
        size = math.sqrt(size)
        if size > longest[i]:
            for j in range(3):
                stretch[i, j] *= longest[i] / size


def level(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """A level surface."""
    return 0.0 * x, 0.0 * x, 0.0 * x


def ball(radius: float) -> Surface:
    """The top of a ball [m]."""

    def surface(x: Array, y: Array) -> tuple[Array, Array, Array]:
        up = np.sqrt(radius**2 - x**2 - y**2)
        return up - radius, -x / up, -y / up

    return surface


def wave(amplitude: float, length: float, angle: float, phase: float) -> Surface:
    """A wave that goes along an angle from x [m], [m], [rad], [rad]."""
    number = 2.0 * math.pi / length
    along_x, along_y = number * math.cos(angle), number * math.sin(angle)

    def surface(x: Array, y: Array) -> tuple[Array, Array, Array]:
        at = along_x * x + along_y * y + phase
        slope = -amplitude * np.sin(at)
        return amplitude * np.cos(at), slope * along_x, slope * along_y

    return surface


def recorded(
    tip: Tip, noise: float, rng: np.random.Generator, hand: Rotation | None = None, tool: Values | None = None
) -> Recording:
    """What a robot writes down of a tip at 50 Hz, with white noise.

    Args:
        tip: at 1 kHz.
        noise: standard deviation of the force's [N].
        rng: for it.
        hand: its orientations, (n,); None: they are not recorded.
        tool: x, y, z [m] from what is taken for the tip to the tip, in the hand's frame.
    """
    place, columns = tip.place, dict[str, Array]()
    if hand is not None:
        if tool is not None:
            place = place - hand.apply([tool[axis] for axis in AXES])
        # q and -q are the same, and robots write down either.
        flips = np.where(np.arange(len(place)) // (3 * SUBSTEPS) % 2, 1.0, -1.0)
        columns |= zip(ORIENTATION, (hand.as_quat() * flips[:, np.newaxis])[::SUBSTEPS].T, strict=True)
    for i, axis in enumerate(AXES):
        columns[f"position_{axis}"] = (place[:, i] + _POSITION_NOISE * rng.standard_normal(len(place)))[::SUBSTEPS]
        columns[f"force_{axis}"] = (tip.force[:, i] + noise * rng.standard_normal(len(place)))[::SUBSTEPS]
    time = np.arange(len(place))[::SUBSTEPS] / (RATE_HZ * SUBSTEPS)
    return completed(time, columns | {"in_contact": np.ones(len(time))}, PALPATION)


@dataclass(frozen=True)
class PalpationSession:
    """A scan over some square centimetres, pressing 1 to 5 mm deep about once a second.

    Attributes:
        seed: of the way, the hand's turning and the noise.
        noise: standard deviation of the force's [N].
        turns: by how much the hand turns [rad]; 0: its orientation is not recorded.
        seconds: how long it takes [s].
    """

    seed: int
    noise: float
    turns: float = 0.0
    seconds: float = 40.0

    def record(self, base: Values, effects: tuple[Concealed, ...]) -> Recording:
        """The recording."""
        tool = next((e.parameters for e in effects if e.name == "tool_offset"), None)
        rng = np.random.default_rng((self.seed, 1))
        return recorded(_tip(self, base, effects), self.noise, rng, self.hand(), tool)

    def true_reading(self, base: Values, effects: tuple[Concealed, ...]) -> Array:
        """The force (3 n,) without noise [N]; of a tip elsewhere, where the hand believes it to be it would feel so."""
        tip, hand = _tip(self, base, effects), self.hand()
        force = tip.force
        for effect in effects:
            if effect.name == "tool_offset" and hand is not None:
                off = hand.apply([effect.parameters[axis] for axis in AXES])
                deeper = np.sum((off - off.mean(axis=0)) * tip.up, axis=1)
                force = force + base["k"] * deeper[:, np.newaxis] * tip.up
        return force[::SUBSTEPS].ravel()

    def way(self) -> tuple[Array, Array]:
        """Places (n, 2) [m] and depth (n,) [m] at 1 kHz."""
        rng = np.random.default_rng((self.seed, 2))
        t = np.arange(int(self.seconds * RATE_HZ * SUBSTEPS)) / (RATE_HZ * SUBSTEPS)
        wide, far = rng.uniform(0.008, 0.014), rng.uniform(0.025, 0.04)
        x = wide * np.sin(2.0 * np.pi * t / rng.uniform(4.0, 6.5))
        y = far * (t / self.seconds - 0.5) + 0.002 * np.sin(2.0 * np.pi * t / rng.uniform(2.5, 3.5))
        presses = np.sin(2.0 * np.pi * rng.uniform(0.8, 1.6) * t) + 0.15 * np.sin(rng.uniform(1.0, 2.0) * t)
        return np.column_stack([x, y]), rng.uniform(0.0028, 0.0036) + rng.uniform(0.0013, 0.002) * presses

    def hand(self) -> Rotation | None:
        """Its orientations at 1 kHz: the tool points down and nods."""
        if self.turns == 0.0:
            return None
        rng = np.random.default_rng((self.seed, 3))
        t = np.arange(int(self.seconds * RATE_HZ * SUBSTEPS)) / (RATE_HZ * SUBSTEPS)
        nods = [np.sin(2.0 * np.pi * t / rng.uniform(3.0, 9.0) + rng.uniform(0.0, 6.0)) for _ in AXES]
        return Rotation.from_rotvec(self.turns * np.column_stack(nods)) * Rotation.from_rotvec([math.pi, 0.0, 0.0])


def _tip(session: PalpationSession, base: Values, effects: tuple[Concealed, ...]) -> Tip:
    found = {effect.name: effect.parameters for effect in effects}
    way, depth = session.way()
    surface: Surface = level
    k = np.full(len(depth), base["k"])
    if (shape := found.get("surface_shape")) is not None:
        surface = ball(shape["radius"]) if "radius" in shape else wave(**shape)
    if (lump := found.get("stiffness_map")) is not None:
        away = (way - [lump["at_x"], lump["at_y"]]) / lump["width"]
        k = k * (1.0 + lump["gain"] * np.exp(-0.5 * np.sum(away**2, axis=1)))
    mu = found.get("probe_slip", {"mu": 0.0})["mu"]
    return palpated(surface, way, depth, k, b=base["b"], mu=mu)


def _shape(rng: np.random.Generator, size: float) -> dict[str, float]:
    if rng.random() < 0.5:
        return {"radius": log(2.0, 0.06, size)}
    length, angle, phase = rng.uniform(0.025, 0.05), rng.uniform(0.0, math.pi), rng.uniform(0.0, 2.0 * math.pi)
    return {"amplitude": log(5e-5, 1.5e-3, size), "length": length, "angle": angle, "phase": phase}


def _lump(rng: np.random.Generator, size: float) -> dict[str, float]:
    x, y = rng.uniform(-0.005, 0.005), rng.uniform(-0.01, 0.01)
    return {"gain": log(0.03, 1.5, size), "at_x": x, "at_y": y, "width": rng.uniform(0.004, 0.007)}


def _tool(rng: np.random.Generator, size: float) -> dict[str, float]:
    way = rng.standard_normal(3)
    return dict(zip(AXES, log(3e-4, 0.01, size) * way / np.linalg.norm(way), strict=True))


EFFECTS: Final[dict[str, Callable[[np.random.Generator, float], dict[str, float]]]] = {
    "probe_slip": lambda rng, size: {"mu": log(0.01, 0.5, size)},
    "surface_shape": _shape,
    "stiffness_map": _lump,
    "tool_offset": _tool,
}
"""What these cases may have concealed -> its parameters at a size from 0 (barely visible) to 1 (plain)."""


def draw_palpation(
    rng: np.random.Generator, name: str, concealed: tuple[str, ...], size: float, *, wrong: bool
) -> Case:
    """A case on a surface.

    Args:
        rng: for all that is left open.
        name: of the case.
        concealed: of `EFFECTS`; none, one or two.
        size: 0 (barely visible) to 1 (plain).
        wrong: whether the nominal parameters are off by up to 20 %.
    """
    base = {"k": four(rng.uniform(150.0, 800.0)), "b": four(rng.uniform(0.2, 2.0))}
    given = off(rng, base) if wrong else base
    nominal: Nominal = {"structure": "surface_contact", "parameters": dict(given)}
    turns = rng.uniform(0.06, 0.2) if "tool_offset" in concealed or rng.random() < 0.5 else 0.0
    session = PalpationSession(int(rng.integers(2**31)), four(rng.uniform(0.002, 0.008)), four(turns))
    drawn = {effect: EFFECTS[effect](rng, size) for effect in concealed}
    return case_of(name, drawn, size, base, nominal, session, wrong=wrong)
