"""Writes the picture of a carried object: `python scripts/carrying_picture.py RECORDING docs/images/carrying.png`.

RECORDING: of `mmt-drake run setup1-carrying --record RECORDING`.
"""

import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt

from mmt_drake.analysis.plotting import GREEN, RENDERED
from mmt_drake.recording import load


def main(source: Path, target: Path) -> None:
    """Draw how high the object is, the force on the hand beside the true one, and the mass that is told."""
    recording = load(source)
    time = recording.time
    figure, panels = plt.subplots(4, 1, figsize=(9.0, 7.0), sharex=True, layout="constrained")
    panels[0].plot(time, 1e3 * recording["body_height"], color=GREEN)
    panels[0].set_ylabel("height [mm]")
    for panel, axis in zip(panels[1:3], "xz", strict=True):
        panel.plot(time, recording[f"true_force_{axis}"], color=GREEN, linewidth=2.0, label="the object's")
        panel.plot(time, recording[f"rendered_force_{axis}"], color=RENDERED, linewidth=0.7, label="rendered")
        panel.set_ylabel(f"force along {axis} [N]")
    panels[1].legend(loc="upper left", frameon=False, ncols=2)
    panels[3].plot(time, 1e3 * recording["carried_m"], color=RENDERED, label="mass [g]")
    panels[3].plot(time, 1e3 * recording["carried_centre"], color=GREEN, label="centre below the grip [mm]")
    panels[3].legend(loc="upper left", frameon=False, ncols=2)
    panels[3].set_ylabel("told")
    panels[3].set_xlabel("time [s]")
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
