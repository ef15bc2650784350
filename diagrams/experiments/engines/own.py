"""The renderer's kernel: a Runge-Kutta step of order 4 whose input is evaluated inside the step."""

import time
from dataclasses import replace

import numpy as np

from mmt_drake.diagrams.experiments.engines.method import OURS, STEP, Method, Setting, Trace, us_per_step
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import FlexibleBoxModel

_LEAD = 30_000  # steps: the object begins at rest, and what that adds has died away by time 0
_DEPTH = 0.01  # [m] below the surface


def _run(setting: Setting) -> Trace:
    """Both tangential axes and the normal one, as the renderer has them; the sine is along y."""
    probe = replace(setting.probe, lead=_LEAD)
    times, (x, v) = probe.times, probe.at_samples()
    position, velocity = np.zeros((len(times), 3)), np.zeros((len(times), 3))
    position[:, 1], velocity[:, 1] = x, v
    position[:, 2] = -_DEPTH
    contact = np.ones(len(times))
    p = FlexibleBoxModel(setting.parameters).kernel_vector(STEP * (1.0 + 1e-9))  # one step a sample, as the renderer
    force, body = np.empty((len(times), 3)), np.empty((len(times), 4))
    box.replay(times[:2], position[:2], velocity[:2], contact[:2], p, force[:2], body[:2])  # compiles
    start = time.process_time()
    box.replay(times, position, velocity, contact, p, force, body)
    return Trace(-force[_LEAD:, 1], us_per_step(start, len(times)))


METHODS = (Method(OURS, "Runge-Kutta 4, three axes", _run),)
