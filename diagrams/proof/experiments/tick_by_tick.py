"""An estimator and the renderer over a measured contact, tick by tick as in the station, but without a Diagram.

Both are the compiled ticks of the station's systems.
Where nothing that is rendered acts back on the motion, an estimator can be run after the fact, and several of them on
the very same measurement.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numba import njit

from mmt_drake.diagrams.proof.trial.sensor import Sensor
from mmt_drake.diagrams.stations.environment import numbers_of
from mmt_drake.diagrams.stations.estimators import KINDS, EstimatorOptions
from mmt_drake.foreign import plant as foreign
from mmt_drake.model import flexible_box as box
from mmt_drake.model.held_body import NO_REPORT
from mmt_drake.model.parameters import THETA, FlexibleBoxModel, InPlane
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.recording import AXES
from mmt_drake.rendering.impedance import MEMORY_SIZE, READOUT_SIZES, render
from mmt_drake.rendering.updates import AtOnce, rule
from mmt_drake.systems.flexible_box import SensorNoise


@dataclass(frozen=True)
class Followed:
    """What came of a contact, each as it is when the sample is taken: an estimator's outputs are one tick old.

    Attributes:
        theta: (n, 10) in the order of `mmt_drake.model.parameters.THETA`.
        stable: (n,) 0.0 or 1.0.
        estimated, filtered: (n, 3) forces that the estimator holds against each other [N].
        rendered: (n, 3) force of the model with these parameters, which runs freely [N].
        trace: all that the estimator put out, as it is after the sample.
    """

    theta: Array
    stable: Array
    estimated: Array
    filtered: Array
    rendered: Array
    trace: Any

    def columns(self) -> dict[str, Array]:
        """As a recording has them."""
        forces = {"estimated": self.estimated, "filtered": self.filtered, "rendered": self.rendered}
        made = by_axis({f"{name}_force": values for name, values in forces.items()})
        thetas = {f"theta_{name}": self.theta[:, i] for i, name in enumerate(THETA)}
        return made | thetas | {"theta_stable": self.stable}


def by_axis(vectors: Mapping[str, Array]) -> dict[str, Array]:
    """Vectors (n, 3) as a recording has them: a column an axis."""
    return {f"{name}_{axis}": values[:, i] for name, values in vectors.items() for i, axis in enumerate(AXES)}


def own_force(
    time: Array, motion: Array, model: FlexibleBoxModel, then: tuple[float, FlexibleBoxModel] | None = None
) -> Array:
    """Force (n, 3) of an object along a motion (n, 6) [N]; `then`: from a time [s] on it is another."""
    position, velocity = np.ascontiguousarray(motion[:, :3]), np.ascontiguousarray(motion[:, 3:])
    n, state = len(time), np.empty(box.STATE_SIZE)
    force, body, by_geometry = np.empty((n, 3)), np.empty((n, 4)), np.full(n, box.CONTACT_BY_GEOMETRY)
    changed, other = (n, model) if then is None else (int(np.searchsorted(time, then[0] - 1e-9)), then[1])
    for part, begin, end in ((model, 0, changed), (other, changed, n)):
        box.replay_part(state, begin, end, time, position, velocity, by_geometry, part.kernel_vector(), force, body)
    return force


def foreign_force(time: Array, motion: Array, model: FlexibleBoxModel) -> Array:
    """The same by the simulation that shares no physics with the model; friction is a vector."""
    steps = round((time[1] - time[0]) / foreign.STEP_S)
    return np.ascontiguousarray(foreign.simulated(time, motion, numbers_of(model), steps)[0][::steps])


PLANTS: Final = {"own": own_force, "foreign": foreign_force}
"""What gives the force of an object along a motion."""


def measured_along(
    time: Array,
    motion: Array,
    model: FlexibleBoxModel,
    noise: SensorNoise,
    random: np.random.Generator,
    plant: str = "own",
) -> tuple[Array, Array, Array]:
    """An object along a motion (n, 6): what sensors read of it (n, 9), contact (n,), and its force (n, 3) as it is."""
    force = PLANTS[plant](time, motion, model)
    deviation = np.repeat([noise.position, noise.velocity, noise.force], 3)
    measurement = np.hstack([motion, force]) + deviation * random.standard_normal((len(time), 9))
    return measurement, (motion[:, 2] < 0.0).astype(np.float64), force


def behind_sensor(time: Array, force: Array, delay: float, lag: float) -> Array:
    """A force (n, 3) at times (n,) behind a first-order low pass and a delay [s]."""
    sensor = Sensor(lag=lag, delay=delay)
    return np.column_stack([sensor.arrival(time, component, time) for component in force.T])


def follow(
    time: Array, measurement: Array, contact: Array, options: EstimatorOptions, *, motion: Array | None = None
) -> Followed:
    """Estimate from a measured contact, and render.

    Args:
        time: (n,) every `options.step` [s].
        measurement: (n, 9) position, velocity, force in the table frame [m, m/s, N].
        contact: (n,) 0.0 or 1.0.
        options: of the estimator.
        motion: (n, 6) position and velocity that drive the rendered model; those measured by default.

    Raises:
        BadInput: other shapes.
    """
    found = KINDS[type(options)].replay(measurement, contact, options)
    theta, stable = _a_tick_later(found.theta), _a_tick_later(found.stable)
    driven = measurement[:, :6] if motion is None else motion
    held = None if found.held_body is None else _a_tick_later(found.held_body)
    rendered = render_along(time, driven, theta, stable, contact, options.step, held, options.in_plane)
    estimated, filtered = _a_tick_later(found.estimated_force), _a_tick_later(found.filtered_force)
    return Followed(theta, stable, estimated, filtered, rendered, found)


def render_along(
    time: Array,
    motion: Array,
    theta: Array,
    stable: Array,
    contact: Array,
    step: float,
    held: Array | None = None,
    in_plane: InPlane = "vector",
) -> Array:
    """The force (n, 3) of the model that runs freely along a motion (n, 6), parameters (n, 10) as they come [N].

    `held` (n, 7) is where friction holds the body (`mmt_drake.model.held_body`), where that is known.
    """
    force = np.empty((len(time), 3))
    known = np.tile(NO_REPORT, (len(time), 1)) if held is None else np.ascontiguousarray(held)
    how = rule(AtOnce(), step, step, in_plane)
    _render_all(time, np.ascontiguousarray(motion), np.ascontiguousarray(theta), stable, contact, known, how, force)
    return force


def _a_tick_later(values: Array) -> Array:
    return np.ascontiguousarray(np.concatenate([values[:1], values[:-1]]))


@njit(cache=True)
def _render_all(
    time: Array, motion: Array, theta: Array, stable: Array, contact: Array, held: Array, how: Array, out: Array
) -> None:
    memory, readout = np.zeros(MEMORY_SIZE), np.zeros(sum(READOUT_SIZES))
    for k in range(len(time)):
        render(memory, time[k], motion[k], motion[k], theta[k], stable[k], contact[k], how, False, held[k], readout)
        assign(out[k], readout[:3])
        assign(memory, readout[len(readout) - MEMORY_SIZE :])
