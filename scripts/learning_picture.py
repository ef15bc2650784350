"""Writes the picture of what a learner brings: `python scripts/learning_picture.py RECORDING docs/images/learning.png`.

RECORDING: of `mmt-drake run setup1-learning --record RECORDING`.
"""

import sys
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import numpy as np
from matplotlib import pyplot as plt

from mmt_drake.analysis.learned import learned
from mmt_drake.analysis.plotting import GREEN, RENDERED
from mmt_drake.recording import load


def main(source: Path, target: Path) -> None:
    """Draw the force before and after the first law that was told, and what the rendered one is off by."""
    recording = load(source)
    found = learned(recording)
    if found is None or not found.told[0].effects:
        sys.exit(f"{source}: nothing was told")
    first = found.told[0]
    time = recording.time
    figure, (above, below) = plt.subplots(2, 1, figsize=(9.0, 4.6), sharex=True, layout="constrained")
    plant, rendered = (recording[f"{name}_y"] for name in ("true_force", "rendered_force"))
    above.plot(time, plant, color=GREEN, linewidth=2.0, label="the object's")
    above.plot(time, rendered, color=RENDERED, linewidth=0.6, label="rendered")
    above.set_ylabel("force along y [N]")
    above.legend(loc="upper left", frameon=False, ncols=2)
    off = np.sqrt(sum((recording[f"rendered_force_{a}"] - recording[f"true_force_{a}"]) ** 2 for a in "xy"))
    below.plot(time, off, color=RENDERED, linewidth=1.0)
    below.set_ylabel("off by, x and y [N]")
    below.set_xlabel("time [s]")
    below.set_ylim(bottom=0.0)
    for panel in (above, below):
        panel.axvline(first.at, color="0.3", linewidth=1.0, linestyle="--")
        panel.spines[["top", "right"]].set_visible(False)
    words = "told: " + " and ".join(effect.words for effect in first.effects)
    below.annotate(words, (first.at, 1.0), (6, -12), xycoords=("data", "axes fraction"), textcoords="offset points")
    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
