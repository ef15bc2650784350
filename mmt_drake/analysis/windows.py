"""Windows: parts of a run to look at."""

import numpy as np

from mmt_drake.analysis.metrics import counted
from mmt_drake.analysis.signals import BANDS, column, in_band, mean_step, on_even_clock
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import TANGENTIAL_THETA
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.recording import Recording

Window = tuple[float, float]


def dominant_window(recording: Recording, band: str, length_s: float, axis: str = "y") -> Window:
    """The stretch (from, to) [s] in which one band of the measured force dominates most.

    Of all windows of `length_s` (half the recording where that is shorter) it is the one with the greatest
    E_band^2 / E, the energy in the band times its share of all energy, so that neither a loud mixture nor a faint pure
    tone wins. Only samples that count for the errors (`metrics.counted`) add to the energies.

    Raises:
        BadInput: a column is missing or broken, or nothing counts.
    """
    even = on_even_clock(recording)
    step = mean_step(even)
    force = column(even, f"force_{axis}")
    selected = counted(even)
    length = min(round(length_s / step), len(even) // 2)

    def energy(values: Array) -> Array:
        total: Array = np.concatenate([[0.0], np.cumsum(np.where(selected, values**2, 0.0))])
        return total[length:] - total[:-length]

    in_it, everything = energy(in_band(force, BANDS[band], 1.0 / step, even.source)), energy(force)
    score = np.divide(in_it**2, everything, out=np.zeros_like(in_it), where=everything > 0.0)
    first = int(np.argmax(score))
    return float(even.time[first]), float(even.time[first + length - 1])


def wound_up(recording: Recording) -> Window:
    """The stretch (from, to) [s] from the first sample that counts for the errors (`metrics.counted`) to the end.

    Raises:
        BadInput: nothing counts.
    """
    even = on_even_clock(recording)
    first = int(np.flatnonzero(counted(even))[0])
    return float(even.time[first]), float(even.time[-1])


def frozen_since(recording: Recording) -> float:
    """Time of the last change of theta [s], in the first half of the recording.

    Raises:
        BadInput: a column `theta_*` is missing, was never estimated, or changes in the second half.
    """
    theta = np.column_stack([recording[f"theta_{name}"] for name in TANGENTIAL_THETA])
    same = (theta[1:] == theta[:-1]) | (np.isnan(theta[1:]) & np.isnan(theta[:-1]))
    changes = np.flatnonzero(~same.all(axis=1)) + 1
    last = int(changes[-1]) if changes.size else 0
    unknown = np.isnan(theta[-1]).any()
    if unknown or last > len(theta) // 2:
        found = "no estimate" if unknown else f"changes up to {recording.time[last]:.3f} s"
        expected = "parameters that stand still in the second half of the recording"
        raise BadInput(recording.source, at="theta_*", found=found, expected=expected)
    return float(recording.time[last])
