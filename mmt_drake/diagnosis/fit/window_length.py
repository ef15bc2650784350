"""Length of the windows over which models of a driven body are held against its recordings."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.checks.preflight import Preflight
from mmt_drake.diagnosis.fit.floors import noise_through
from mmt_drake.diagnosis.fit.tracks import DrivenTrack
from mmt_drake.errors import attempt
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.numeric.arrays import Array
from mmt_drake.windows import FEWEST, LEAD, LEAST_LEAD, MOST

REVERSALS, TIME_CONSTANTS = 3, 3
"""At least so many reversals of the output, or time constants of the body, whichever is less, lie in a window; where
an error grows, as on an inverted pendulum, the time in which it grows by e is enough."""
HELD = 10.0
"""A body comes back, overdamped, in this part of a recording or less, if its springs and gravity hold it."""
TOLERATED, LEAST = 3.0, 1e-4
"""It is longer as long as noise of the input adds no more than so many times the noise of the output, or than this part
of the output's spread."""


def window_length(preflights: Sequence[Preflight], model: DrivenBodyModel) -> float | None:
    """Length of the windows [s], the same for all recordings; None: each recording in one.

    Args:
        preflights: of the recordings.
        model: nominal; noise of the input is sent through it.
    """
    found = [_of_one(check, model) for check in preflights]
    return None if all(math.isinf(length) for length in found) else min(found)


def _of_one(check: Preflight, model: DrivenBodyModel) -> float:
    """The longest window of a recording that the noise of its input allows [s]; infinite: all of it.

    Of a body that drifts what no model explains adds up as noise of its input would. Where there is no such noise to
    go by, the window is as short as it may be.
    """
    track = DrivenTrack(check.smoothed, 0, np.zeros(len(check.smoothed.time), dtype=bool))
    allowed = max(TOLERATED * float(track.smoothed.output_noise[0]), LEAST * float(np.std(track.measured)))
    if not _drifts(track, model) or LEAD * len(check.recording) < FEWEST * LEAST_LEAD:
        return math.inf
    noisy = track.smoothed.input_noise.any()
    if noisy and _through(track, model) <= allowed:
        return math.inf
    least = min(REVERSALS * track.duration / (check.motions[0].reversals + 1), track.duration / FEWEST)
    if model.b > 0.0:
        least = min(least, TIME_CONSTANTS * model.m / model.b)
    least = max(min(least, _growth_time(track, model)), track.duration / MOST)
    blocks = FEWEST
    while noisy and track.duration / blocks > least and blocks < MOST:
        if _through(replace(track, window_s=track.duration / blocks), model) <= allowed:
            return track.duration / blocks
        blocks *= 2
    return least


def _drifts(track: DrivenTrack, model: DrivenBodyModel) -> bool:
    """Whether next to nothing takes the body back to where it would be: an error of its input moves it on and on."""
    stiffness = float(np.mean(_stiffness(track, model)))
    return not stiffness * track.duration > HELD * model.b


def _growth_time(track: DrivenTrack, model: DrivenBodyModel) -> float:
    """In which an error of the state grows by e where the body is least stable [s]; infinite where nothing grows."""
    stiffness = float(np.min(_stiffness(track, model)))
    if not (stiffness < 0.0 < model.m):
        return math.inf
    return 2.0 * model.m / (math.sqrt(model.b**2 - 4.0 * model.m * stiffness) - model.b)


def _stiffness(track: DrivenTrack, model: DrivenBodyModel) -> Array:
    """(n,) what takes the body back, over its displacement: its spring, and gravity on a pendulum."""
    return model.k + model.slope(track.measured)


def _through(track: DrivenTrack, model: DrivenBodyModel) -> float:
    """RMS of what noise adds to the simulated output; infinite where the model cannot be simulated."""
    through = attempt(noise_through, track, model, np.random.default_rng(0))
    return math.inf if through is None else through
