"""Writes the picture of several objects: `python scripts/scene_picture.py RECORDING docs/images/scene.png`.

RECORDING: of `mmt-drake run setup4 --record RECORDING`.
"""

import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt

from mmt_drake.analysis.plotting import GREEN, ORANGE, RENDERED, SKY
from mmt_drake.analysis.signals import delayed, stretches, vector
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.model.scene_layout import MOST
from mmt_drake.recording import load

COLOURS = (SKY, ORANGE, GREEN)


def main(source: Path, target: Path) -> None:
    """Draw where the objects were and were seen, and the force of the first two touches of the first."""
    recording, scenario = load(source), load_scenario("setup4")
    delay, step = scenario.to_telerobot.playout, scenario.step
    touched, time = recording["touched"], recording.time
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
    felt = delayed(vector(recording, "rendered_force"), delay, step)
    visits = [span for span in stretches(touched == 1.0) if span[1] - span[0] > 1000]
    for which, (start, end) in zip(("first", "second"), visits[:2], strict=True):
        shown = slice(start, min(end, start + 3000))
        since = time[shown] - time[start]
        panels[which].plot(since, recording["true_force_y"][shown], color=GREEN, linewidth=2.0, label="the object's")
        panels[which].plot(since, felt[shown, 1], color=RENDERED, linewidth=0.8, label="rendered")
        panels[which].set(ylabel="along y [N]", title=f"{which} touch of the {names[0]}")
    panels["second"].set_xlabel("time in contact [s]")
    panels["first"].legend(frameon=False, ncols=2, loc="upper right")
    for panel in panels.values():
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
