"""Writes a picture of a recorded run in the docs: `python scripts/run_picture.py NAME RECORDING docs/images/NAME.png`.

NAME: `learning`, RECORDING of `mmt-drake run setup1-learning --record RECORDING`: what a learner brings; `carrying`, of
`setup1-carrying`: a carried object; `scene`, of `setup4`: several objects.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mmt_drake.analysis.learned import learned
from mmt_drake.analysis.plotting import GREEN, ORANGE, RENDERED, SKY
from mmt_drake.analysis.signals import delayed, stretches, vector
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.model.scene_layout import MOST
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, load

COLOURS = (SKY, ORANGE, GREEN)


def forces(panel: Axes, time: Array, true: Array, rendered: Array, width: float) -> None:
    """Draw a force on the hand beside the true one."""
    panel.plot(time, true, color=GREEN, linewidth=2.0, label="the object's")
    panel.plot(time, rendered, color=RENDERED, linewidth=width, label="rendered")


def carrying(recording: Recording) -> Figure:
    """How high the object is, the force on the hand beside the true one, and the mass that is told."""
    time = recording.time
    figure, panels = plt.subplots(4, 1, figsize=(9.0, 7.0), sharex=True, layout="constrained")
    panels[0].plot(time, 1e3 * recording["body_height"], color=GREEN)
    panels[0].set_ylabel("height [mm]")
    for panel, axis in zip(panels[1:3], "xz", strict=True):
        forces(panel, time, recording[f"true_force_{axis}"], recording[f"rendered_force_{axis}"], 0.7)
        panel.set_ylabel(f"force along {axis} [N]")
    panels[1].legend(loc="upper left", frameon=False, ncols=2)
    panels[3].plot(time, 1e3 * recording["carried_m"], color=RENDERED, label="mass [g]")
    panels[3].plot(time, 1e3 * recording["carried_centre"], color=GREEN, label="centre below the grip [mm]")
    panels[3].legend(loc="upper left", frameon=False, ncols=2)
    panels[3].set(xlabel="time [s]", ylabel="told")
    return figure


def learning(recording: Recording) -> Figure:
    """The force before and after the first law that was told, and what the rendered one is off by."""
    found = learned(recording)
    if found is None or not found.told[0].effects:
        sys.exit(f"{recording.source}: nothing was told")
    first, time = found.told[0], recording.time
    figure, (above, below) = plt.subplots(2, 1, figsize=(9.0, 4.6), sharex=True, layout="constrained")
    forces(above, time, recording["true_force_y"], recording["rendered_force_y"], 0.6)
    above.set_ylabel("force along y [N]")
    above.legend(loc="upper left", frameon=False, ncols=2)
    off = np.sqrt(sum((recording[f"rendered_force_{a}"] - recording[f"true_force_{a}"]) ** 2 for a in "xy"))
    below.plot(time, off, color=RENDERED, linewidth=1.0)
    below.set(xlabel="time [s]", ylabel="off by, x and y [N]")
    below.set_ylim(bottom=0.0)
    for panel in (above, below):
        panel.axvline(first.at, color="0.3", linewidth=1.0, linestyle="--")
    words = "told: " + " and ".join(effect.words for effect in first.effects)
    below.annotate(words, (first.at, 1.0), (6, -12), xycoords=("data", "axes fraction"), textcoords="offset points")
    return figure


def scene(recording: Recording) -> Figure:
    """Where the objects were and were seen, and the force of the first two touches of the first."""
    scenario, time = load_scenario("setup4"), recording.time
    touched = recording["touched"]
    figure, panels = plt.subplot_mosaic(
        [["places", "first"], ["places", "second"]], figsize=(9.0, 4.6), layout="constrained"
    )
    several = scenario.several
    names = [] if several is None else list(several.things)
    for i, (name, colour) in enumerate(zip(names[:MOST], COLOURS, strict=False)):
        panels["places"].plot(time, 1e3 * recording[f"places_{i + 1}_x"], color=colour, linewidth=2.5, label=name)
        seen = recording[f"scene_{i + 1}_thing"] > 0.0
        row = 1e3 * recording[f"scene_{i + 1}_x"][seen]
        panels["places"].plot(time[seen], row, color="0.2", linewidth=0.6, label="as seen" if i == 0 else None)
    panels["places"].set(xlabel="time [s]", ylabel="x [mm]")
    panels["places"].legend(frameon=False, ncols=2, loc="center", bbox_to_anchor=(0.5, 0.68))
    felt = delayed(vector(recording, "rendered_force"), scenario.to_telerobot.playout, scenario.step)
    visits = [span for span in stretches(touched == 1.0) if span[1] - span[0] > 1000]
    for which, (start, end) in zip(("first", "second"), visits[:2], strict=True):
        shown = slice(start, min(end, start + 3000))
        forces(panels[which], time[shown] - time[start], recording["true_force_y"][shown], felt[shown, 1], 0.8)
        panels[which].set(ylabel="along y [N]", title=f"{which} touch of the {names[0]}")
    panels["second"].set_xlabel("time in contact [s]")
    panels["first"].legend(frameon=False, ncols=2, loc="upper right")
    return figure


PICTURES: dict[str, Callable[[Recording], Figure]] = {"carrying": carrying, "learning": learning, "scene": scene}


def main(name: str, source: str, target: str) -> None:
    """Draw a recorded run."""
    figure = PICTURES[name](load(Path(source)))
    for panel in figure.axes:
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    main(*sys.argv[1:])
