"""Where hands end up under different kinds of force feedback."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from mmt_drake.analysis.plotting import legend_above, line, panels, shade, styled
from mmt_drake.recording import Recording


@styled
def hands(recordings: Mapping[str, Recording], still_from_s: float | None) -> Figure:
    """Height of the hand and force along the normal over time, one line per scheme.

    Args:
        recordings: what it was under -> the run; needs `master_position_z` and `rendered_force_z`.
        still_from_s: since when the hand means to hold still [s]; None: not known of this motion.
    """
    figure, grid = panels(2, 4.4)
    for name, recording in recordings.items():
        line(grid[0], recording.time, 1e3 * recording["master_position_z"], name)
        line(grid[1], recording.time, recording["rendered_force_z"], name)
    first = next(iter(recordings.values()))
    if still_from_s is not None:
        shade(grid, first.time, first.time >= still_from_s)
    grid[0].set(ylabel="height of the hand [mm]", title="Hand and force along the normal")
    grid[1].set(ylabel="rendered force [N]", xlabel="time [s]")
    grid[1].set_xlim(first.time[0], first.time[-1])
    legend_above(grid[0])
    return figure
