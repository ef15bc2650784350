"""A recording session on the flexible object: a hand, an object with something concealed in it, sensors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mmt_drake.diagrams.proof.trial.laws import Concealed, linear_object, with_effects
from mmt_drake.diagrams.proof.trial.motions import ProbeMotion, draw_motion
from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.diagrams.proof.trial.plant import QUICK_STEP_S, STEP_S
from mmt_drake.diagrams.proof.trial.plants import OWN, Plant
from mmt_drake.diagrams.proof.trial.sensor import Sensor
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording

POSITION_NOISE = 1e-5
"""Standard deviation of the white noise on positions [m]."""
VELOCITY_NOISE = 5e-4
"""Of that on velocities [m/s]."""


@dataclass(frozen=True)
class ContactSession:
    """A hand that strokes the flexible object, and what is recorded of it. SI units.

    Attributes:
        seed: of the hand's motion and of all sensors' noise.
        noise: standard deviation of white noise on forces [N].
        duration: of the recording [s].
        rate_hz: samples per second.
        velocity, in_contact: whether these columns are recorded.
        still_x_alive: whether an x axis that does not move has the object's physics all the same; else it reads noise.
        plant: what simulates the object.
    """

    seed: int
    noise: float
    duration: float = 30.0
    rate_hz: float = 1000.0
    velocity: bool = True
    in_contact: bool = True
    still_x_alive: bool = False
    plant: Plant = OWN

    @property
    def motion(self) -> ProbeMotion:
        """The probe's true motion."""
        return _motion(self.seed, self.duration, self.rate_hz, self.plant.moves_x)

    def true_reading(self, base: Mapping[str, float], effects: tuple[Concealed, ...]) -> Array:
        """The reading (m,) along y without noise, while in contact [N]; by quick steps."""
        if not effects:
            return self.without_effects(base)[0][self.motion.contact]
        physics, sensor = with_effects(linear_object(base), Sensor(), effects)
        (reading,), _ = tangential_readings(physics, sensor, self.motion, (1,), QUICK_STEP_S, self.plant)
        return sensor.clipped(reading)[self.motion.contact]

    def without_effects(self, base: Mapping[str, float]) -> tuple[Array, Array]:
        """The true force (n,) along y [N] and the body's motion (n, 2) with nothing concealed; by quick steps."""
        return _without_effects(self, tuple(base.items()))

    def record(self, base: Mapping[str, float], effects: tuple[Concealed, ...]) -> Recording:
        """The recording of the object `base` with these effects."""
        physics, sensor = with_effects(linear_object(base), Sensor(), effects)
        motion, rng = self.motion, np.random.default_rng((self.seed, 1))
        n = len(motion.time)
        columns: dict[str, Array] = {}
        for i, axis in enumerate("xyz"):
            columns[f"position_{axis}"] = motion.position[:, i] + rng.normal(0.0, POSITION_NOISE, n)
        for i, axis in enumerate("xyz"):
            if self.velocity:
                columns[f"velocity_{axis}"] = motion.velocity[:, i] + rng.normal(0.0, VELOCITY_NOISE, n)
        x_alive = motion.moves_x or self.still_x_alive
        axes = (0, 1) if x_alive else (1,)
        arrived, _ = arrived_forces(physics, sensor, motion, axes, plant=self.plant)
        for i in range(2):
            if i in axes or any(sensor.turn):
                arrived[i] = sensor.tangential(motion.time, arrived[i], arrived[2])
        for axis, reading in zip("xyz", arrived, strict=True):
            columns[f"force_{axis}"] = sensor.clipped(reading + rng.normal(0.0, self.noise, n))
        if self.in_contact:
            columns["in_contact"] = motion.contact.astype(np.float64)
        return Recording(motion.time, columns)


@lru_cache(maxsize=4)  # a case asks for its motion several times
def _motion(seed: int, duration: float, rate_hz: float, along_x: float) -> ProbeMotion:
    return draw_motion(np.random.default_rng((seed, 0)), duration=duration, rate_hz=rate_hz, along_x=along_x)


@lru_cache(maxsize=4)  # what the sizes of effects and their visibility are measured against
def _without_effects(session: ContactSession, base: tuple[tuple[str, float], ...]) -> tuple[Array, Array]:
    numbers = linear_object(dict(base))
    (reading,), body = tangential_readings(numbers, Sensor(), session.motion, (1,), QUICK_STEP_S, session.plant)
    return reading, body


def draw_session(rng: np.random.Generator, plant: Plant = OWN) -> ContactSession:
    """A session with this plant: mostly 30 s at 1 kHz with all columns, now and then longer, slower or with less."""
    return ContactSession(
        seed=int(rng.integers(2**31)),
        noise=round(float(rng.uniform(0.01, 0.03)), 4),
        duration=30.0 if rng.random() < 0.8 else float(rng.choice([20.0, 45.0])),
        rate_hz=1000.0 if rng.random() < 0.9 else 500.0,
        velocity=bool(rng.random() < 0.75),
        in_contact=bool(rng.random() < 0.9),
        still_x_alive=bool(rng.random() < 0.5),
        plant=plant,
    )


def tangential_readings(
    physics: Physics,
    sensor: Sensor,
    motion: ProbeMotion,
    axes: Sequence[int] = (1,),
    step: float = STEP_S,
    plant: Plant = OWN,
) -> tuple[list[Array], Array]:
    """Tangential axes without noise or clipping: their readings, each (n,) [N], and the body's motion (n, 2).

    Args:
        physics, sensor: with their effects.
        motion: of the probe.
        axes: 0 and 1 for x and y; the body's motion is along the last of them.
        step: longest time step [s].
        plant: what simulates the object.
    """
    arrived, body = arrived_forces(physics, sensor, motion, axes, step, plant)
    return [sensor.tangential(motion.time, arrived[i], arrived[2]) for i in axes], body


def arrived_forces(
    physics: Physics, sensor: Sensor, motion: ProbeMotion, axes: Sequence[int], step: float = STEP_S, plant: Plant = OWN
) -> tuple[Array, Array]:
    """What arrives of the forces (3, n) [N] in the frame of the sensor, 0 along axes left out, and the body's motion.

    Args:
        physics, sensor, motion, axes, step, plant: as of `tangential_readings`.
    """
    time = motion.time
    fine_forces, body = plant.forces(physics, motion, axes, math.ceil((time[1] - time[0]) / step))
    fine, arrived = np.linspace(time[0], time[-1], len(fine_forces)), np.zeros((3, len(time)))
    for axis, fine_force in zip(axes, fine_forces.T, strict=True):
        arrived[axis] = sensor.arrival(fine, fine_force, time)
    arrived[2] = sensor.arrival(time, normal_force(physics, motion), time)
    if sensor.carried > 0.0:
        for i in range(3):
            arrived[i] -= sensor.carried * sensor.arrival(time, np.gradient(motion.velocity[:, i], time), time)
    return sensor.turned(arrived), body


def normal_force(physics: Physics, motion: ProbeMotion) -> Array:
    """The true force (n,) along the surface normal [N]."""
    z, vz = motion.position[:, 2], motion.velocity[:, 2]
    return np.where(motion.contact, -physics.normal_k * z - physics.normal_b * vz, 0.0)
