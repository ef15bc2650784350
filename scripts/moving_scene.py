"""Writes the moving picture of several objects: `python scripts/moving_scene.py RECORDING docs/images/scene.gif`.

RECORDING of `mmt-drake run setup4 --record RECORDING`: the hand comes back to the first object, lifts it, carries it
over the second and puts it down. From the side, from above, and the force; twice as fast as it went.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch, Rectangle
from moving_picture import INK, MEASURED, MM, RENDERED, smaller

from mmt_drake.analysis.plotting import GREEN, ORANGE, SKY
from mmt_drake.analysis.signals import delayed, vector
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.several import PlacedObject, SeveralObjects
from mmt_drake.model.scene_layout import SeenState
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, load

SHOWN = (22.5, 38.5)  # [s]
FPS, FASTER = 12, 2
COLOURS = (SKY, ORANGE, GREEN)


def main(source: str, moving: str) -> None:
    """Draw a recorded run of set-up 4."""
    recording = load(Path(source))
    mpl.rcParams |= {"font.size": 10, "axes.edgecolor": INK, "text.color": INK, "axes.labelcolor": INK}
    figure, panels = plt.subplot_mosaic(
        [["side", "force"], ["above", "force"]], figsize=(8.6, 4.2), dpi=90, width_ratios=(1.5, 1), layout="constrained"
    )
    draw = prepared(recording, figure, panels)
    FuncAnimation(figure, draw, frames=np.arange(*SHOWN, FASTER / FPS)).save(moving, writer=PillowWriter(fps=FPS))
    smaller(Path(moving), FPS)


def prepared(recording: Recording, figure: Figure, panels: dict[str, Axes]) -> Callable[[float], list[Artist]]:
    """Draw what stands still; returns what draws the rest at a time [s]."""
    scenario = load_scenario("setup4")
    several, delay = scenario.several, scenario.to_telerobot.playout
    assert several is not None  # it is set-up 4
    time, tip = recording.time, MM * vector(recording, "position")
    felt = delayed(vector(recording, "rendered_force"), delay, scenario.step)
    forces = {"measured": vector(recording, "force"), "rendered": felt}
    height = MM * recording["body_height"]
    for name, across, label in (("side", (-75, 95), "z [mm]"), ("above", (-85, 85), "y [mm]")):
        panels[name].set(xlim=(-205, 205), ylim=across, aspect="equal", ylabel=label)
        panels[name].spines[["top", "right"]].set_visible(False)
    panels["above"].set_xlabel("x [mm]")
    panels["side"].axhline(MM * several.table, color=INK, lw=1.0)
    coloured = zip(several.things.values(), COLOURS, strict=True)
    bodies = [Body(panels, several, thing, colour) for thing, colour in coloured]
    marks = {
        name: panels[name].plot([], [], "o", color="white", mec=INK, mew=1.6, ms=7, zorder=5)[0]
        for name in ("side", "above")
    }
    now, lines = _chart(panels["force"], time, forces)
    told = figure.suptitle(" ", x=0.012, ha="left", fontsize=10)

    def draw(at: float) -> list[Artist]:
        i = int(np.searchsorted(time, at))
        for k, body in enumerate(bodies, start=1):
            x, y = (MM * recording[f"places_{k}_{axis}"][i] for axis in "xy")
            seen = None
            if recording[f"scene_{k}_thing"][i] > 0.0:
                seen = MM * recording[f"scene_{k}_x"][i], MM * recording[f"scene_{k}_y"][i]
            body.move(x, y, height[i] if recording["touched"][i] == k else 0.0, seen)
        for mark, axis in zip(marks.values(), (2, 1), strict=True):
            mark.set_data([tip[i, 0]], [tip[i, axis]])
        done = (time >= SHOWN[0]) & (time <= at)
        for name, line in lines.items():
            line.set_data(time[done], np.linalg.norm(forces[name][done], axis=1))
        now.set_xdata([at, at])
        states = (SeenState(int(recording[f"scene_{k}_state"][i])).name for k in range(1, len(bodies) + 1))
        words = zip(several.things, states, strict=True)
        said = (f"{name}: {state.lower().replace('_', ' ')}" for name, state in words)
        told.set_text("    ".join([f"{at:.1f} s", *said]))
        return [told, now, *marks.values(), *lines.values(), *(patch for body in bodies for patch in body.patches)]

    return draw


class Body:
    """One object in both views; dashed is where the camera sees it.

    Args:
        panels: the views.
        several: all objects.
        thing: this one.
        colour: of it.
    """

    def __init__(self, panels: dict[str, Axes], several: SeveralObjects, thing: PlacedObject, colour: str) -> None:
        wide, deep, high = (MM * size for size in thing.size)
        self._half, self._table = (0.5 * wide, 0.5 * deep), MM * several.table
        looks: dict[str, Any] = {"facecolor": colour, "edgecolor": INK, "lw": 1.0, "alpha": 0.75}
        dashed: dict[str, Any] = {"fill": False, "edgecolor": INK, "lw": 1.0, "ls": "--"}
        self._side = Rectangle((0.0, 0.0), wide, high, **looks)
        self._round = thing.round
        self._above, self._seen = (self._outline(wide, deep, kept) for kept in (looks, dashed))
        panels["side"].add_patch(self._side)
        for patch in (self._above, self._seen):
            panels["above"].add_patch(patch)
        self.patches = (self._side, self._above, self._seen)

    def _outline(self, wide: float, deep: float, looks: dict[str, Any]) -> Patch:
        return Ellipse((0.0, 0.0), wide, deep, **looks) if self._round else Rectangle((0.0, 0.0), wide, deep, **looks)

    def move(self, x: float, y: float, up: float, seen: tuple[float, float] | None) -> None:
        """Draw it where it is, so high off the table, and where it is seen [mm]."""
        half_wide, half_deep = self._half
        self._side.set_xy((x - half_wide, self._table + up))
        self._above.set_zorder(2 if up > 0.0 else 1)
        for patch, place in ((self._above, (x, y)), (self._seen, seen)):
            patch.set_visible(place is not None)
            if place is not None and isinstance(patch, Ellipse):
                patch.set_center(place)
            elif place is not None and isinstance(patch, Rectangle):
                patch.set_xy((place[0] - half_wide, place[1] - half_deep))


def _chart(panel: Axes, time: Array, forces: dict[str, Array]) -> tuple[Line2D, dict[str, Line2D]]:
    """Draw the sizes of the forces, pale; returns the line that says now, and those of what has been."""
    shown = (time >= SHOWN[0]) & (time <= SHOWN[1])
    lines: dict[str, Line2D] = {}
    for name, colour, width in (("measured", MEASURED, 2.6), ("rendered", RENDERED, 1.2)):
        size = np.linalg.norm(forces[name], axis=1)
        panel.plot(time[shown], size[shown], color=colour, lw=width, alpha=0.2)
        (lines[name],) = panel.plot([], [], color=colour, lw=width, label=f"{name} force")
    panel.set(xlim=SHOWN, ylim=(0.0, 2.1), xlabel="time [s]", ylabel="size of the force [N]")
    panel.spines[["top", "right"]].set_visible(False)
    panel.legend(loc="upper left", frameon=False)
    return panel.axvline(SHOWN[0], color=INK, lw=0.8), lines


if __name__ == "__main__":
    main(*sys.argv[1:])
