"""Common parts of a diagnosis's figures: how each model is drawn, labels, binned curves."""

from typing import Final

import numpy as np

from mmt_drake.analysis.plotting import BLACK, BLUE, GREEN, GREY, ORANGE
from mmt_drake.diagnosis.tell.evidence import Series
from mmt_drake.numeric.arrays import Array

MEASURED: Final = BLACK
NOISE: Final = GREY
COLORS: Final = {"nominal": ORANGE, "refit": BLUE, "augmented": GREEN}
DASHES: Final = {"nominal": "dash", "refit": "dot", "augmented": "solid"}
"""Lines are told apart without colour too, on a grey print."""
NAMES: Final = {"nominal": "as handed in", "refit": "with parameters fitted", "augmented": "with what was found"}
"""What a reader calls each model."""
HELDOUT: Final = "#E1ECF5"
_BINS, _LEAST = 28, 12


def axis_label(signal: Series, what: str | None = None) -> str:
    """`label [unit]`, with another word for the label if given; nothing in brackets without a unit."""
    label = what or signal.label
    return f"{label} [{signal.unit}]" if signal.unit else label


def limits(*values: Array) -> tuple[float, float]:
    """Of an axis that shows all but the utmost thousandth of the values, with a margin."""
    finite = np.concatenate([array[np.isfinite(array)] for array in values])
    low, high = np.percentile(finite, (0.05, 99.95)) if finite.size else (-1.0, 1.0)
    margin = 0.08 * (high - low) or 1.0
    return float(low - margin), float(high + margin)


def binned(over: Array, values: Array) -> tuple[Array, Array, Array, Array]:
    """The median of `values` in equal bins of `over`, with its spread: four (m,) arrays.

    Bins span the 0.5th to the 99.5th percentile, so that a stray sample does not stretch them; those with fewer than
    `_LEAST` samples are left out.

    Returns:
        centre of each bin, 10th percentile, median, 90th percentile of the values in it.
    """
    if len(over) == 0:
        return np.empty(0), np.empty(0), np.empty(0), np.empty(0)
    low, high = np.percentile(over, (0.5, 99.5))
    edges = np.linspace(low, high, _BINS + 1)
    which = np.digitize(over, edges) - 1
    full = [k for k in range(_BINS) if np.count_nonzero(which == k) >= _LEAST]
    quantiles = np.array([np.percentile(values[which == k], (10, 50, 90)) for k in full]).reshape(-1, 3)
    return 0.5 * (edges[:-1] + edges[1:])[full], quantiles[:, 0], quantiles[:, 1], quantiles[:, 2]
