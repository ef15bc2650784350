"""The renderer's own tick, with all that it does in a station: it checks theta, moves the body and makes the force.

Once in a compiled loop, beside engines that step in C, and once called from Python, as a station calls it.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numba import njit

from mmt_drake.diagrams.proof.experiments.engines.method import OURS, STEP, Method, Setting, Trace, us_per_step
from mmt_drake.model.held_body import NO_REPORT
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.numeric.arrays import Array
from mmt_drake.rendering.impedance import MEMORY_SIZE, READOUT_SIZES, render
from mmt_drake.rendering.updates import renderer_rule

_LEAD = 30_000  # steps: the object begins at rest, and what that adds has died away by time 0
_DEPTH = 0.01  # [m] below the surface


@njit(cache=True)
def _ticks(times: Array, motion: Array, theta: Array, rule: Array, held: Array, out: Array) -> None:
    """What the renderer puts out, memory last, (n, sum(READOUT_SIZES)) at every motion (n, 6)."""
    memory = np.zeros(MEMORY_SIZE)
    for k in range(len(times)):
        render(memory, times[k], motion[k], motion[k], theta, 1.0, 1.0, rule, False, held, out[k])
        memory = out[k, -MEMORY_SIZE:]


def _run(setting: Setting, ticks: Callable[..., None]) -> Trace:
    """Both tangential axes and the normal one; the sine is along y."""
    probe = replace(setting.probe, lead=_LEAD)
    times = probe.times - probe.times[0]  # no clock of a station is before 0
    motion = np.zeros((len(times), 6))
    motion[:, 1], motion[:, 4] = probe.at_samples()
    motion[:, 2] = -_DEPTH
    out = np.zeros((len(times), sum(READOUT_SIZES)))
    settings = FlexibleBoxModel(setting.parameters).theta(), renderer_rule(None, STEP, 1), NO_REPORT
    ticks(times[:2], motion[:2], *settings, out[:2])  # compiles
    start = time.process_time()
    ticks(times, motion, *settings, out)
    return Trace(-out[_LEAD:, 1], us_per_step(start, len(times)))


METHODS = (
    Method(OURS, "its tick, three axes", partial(_run, ticks=_ticks)),
    Method(OURS, "its tick from Python", partial(_run, ticks=_ticks.py_func), from_python=True),
)
