"""What an estimator costs in processor time."""

from __future__ import annotations

import time
from typing import Final

import numpy as np

from mmt_drake.diagrams.stations.estimators import KINDS, EstimatorOptions
from mmt_drake.recording import Recording

COST_S: Final = 10.0
"""Of a motion, from its beginning, over which the cost is taken [s]."""


def cost_us(options: EstimatorOptions, recording: Recording) -> float:
    """Processor time of the estimator alone, each tick [us], along a motion as it was measured.

    The estimator is compiled before the clock starts. Where it learns beside the fast loop this is what both cost
    together.
    """
    count = min(len(recording.time), round(COST_S / options.step))
    measured = [recording.vector(name) for name in ("position", "velocity", "force")]
    measurement, contact = np.hstack(measured)[:count], recording["in_contact"][:count]
    replay = KINDS[type(options)].replay
    replay(measurement[:10], contact[:10], options)
    start = time.process_time()
    replay(measurement, contact, options)
    return 1e6 * (time.process_time() - start) / count
