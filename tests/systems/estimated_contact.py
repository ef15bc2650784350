"""What systems that estimate are tested on, with names of what they put out."""

from typing import TypeVar

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.systems.leaf import LeafSystem

OUTPUTS = ("theta", "regrouped", "stable", "estimated_force", "filtered_force", "deviation", "status", "held_body")
STEP = 1e-3
TICKS = 1500

Estimator = TypeVar("Estimator", bound=LeafSystem)


def wired(estimator: Estimator, data: np.ndarray, flag: np.ndarray, step: float) -> tuple[Diagram, Estimator]:
    """An estimator that is told measurements (n, 9) and contact (n,), one every step [s]."""
    builder = DiagramBuilder()
    builder.AddNamedSystem("estimator", estimator)
    times = (np.arange(len(data)) - 0.5) * step  # a sample holds around its tick, clear of rounding in time
    for name, values in (("measurement", data), ("in_contact", flag[:, None])):
        source = builder.AddSystem(TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, values.T)))
        builder.Connect(source.get_output_port(), estimator.GetInputPort(name))
    return builder.Build(), estimator


def contact() -> tuple[np.ndarray, np.ndarray]:
    """Measurement (TICKS, 9) of strokes, with noise, and the flag."""
    t = np.arange(TICKS) * STEP
    position, velocity = scripted_motion("strokes", duration=4.0, lifts=0).sample(t)
    force, body = np.empty((TICKS, 3)), np.empty((TICKS, 4))
    box.replay(
        t, position, velocity, np.full(TICKS, box.CONTACT_BY_GEOMETRY), FlexibleBoxModel().kernel_vector(), force, body
    )
    noise = np.random.default_rng(0).normal(0.0, np.repeat([1e-5, 5e-4, 0.02], 3), (TICKS, 9))
    return np.hstack([position, velocity, force]) + noise, (position[:, 2] < 0.0).astype(float)
