"""What the output-error estimator is tested on: strokes over an object, with the noise of set-up 1."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import MAX_STEP, BoxParameters, FlexibleBoxModel
from mmt_drake.model.plane_call import planar
from mmt_drake.model.theta import adopt_theta
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.numeric.arrays import Array
from mmt_drake.told_laws import NO_LAWS, VECTOR_SIZE, put_laws, step_with_laws

STEP = 1e-3
OBJECT = FlexibleBoxModel(BoxParameters(m=0.8, k1=60.0, k2=700.0, b1=20.0, b2=30.0, Fc=0.4))


@dataclass(frozen=True)
class Contact:
    """A measured contact: times (n,), measurement (n, 9), the flag (n,), and the force without noise (n, 3)."""

    time: Array
    measurement: Array
    in_contact: Array
    force: Array


@cache
def contact(seconds: float = 6.0, noise: float = 1.0, model: FlexibleBoxModel = OBJECT, lifts: int = 0) -> Contact:
    """Strokes; `noise` is over that of set-up 1."""
    n = round(seconds / STEP)
    time = np.arange(n) * STEP
    position, velocity = scripted_motion("strokes", duration=max(seconds, 4.0 * (lifts + 1)), lifts=lifts).sample(time)
    force, body = np.empty((n, 3)), np.empty((n, 4))
    box.replay(time, position, velocity, np.full(n, box.CONTACT_BY_GEOMETRY), model.kernel_vector(), force, body)
    deviation = noise * np.repeat([1e-5, 5e-4, 0.02], 3)
    measurement = np.hstack([position, velocity, force]) + deviation * np.random.default_rng(0).standard_normal((n, 9))
    return Contact(time, measurement, (position[:, 2] < 0.0).astype(float), force)


def assert_settles_by_itself(theta: Array) -> None:
    """Every set (n, 10) has poles left of the imaginary axis, in contact and free (unless loose), and a surface."""
    for m, k1, k2, b1, b2, _, normal_k, normal_b, *_ in np.unique(theta, axis=0):
        assert (np.roots([m, b1 + b2, k1 + k2]).real < 0.0).all()
        assert k1 == 0.0 or (np.roots([m, b1, k1]).real < 0.0).all()
        assert np.roots([normal_b, normal_k]).real < 0.0 if normal_b > 0.0 else normal_k > 0.0


def free_running_error(theta: Array, seen: Contact, start: float = 0.0, laws: Array = NO_LAWS) -> float:
    """Error of the force of one theta and laws, running freely from rest, over the force's RMS, from `start` [s] on."""
    p = np.zeros(VECTOR_SIZE)
    assert adopt_theta(theta, np.inf, 1e-5, planar("vector"), p)
    put_laws(laws, p)
    p[MAX_STEP] = step_with_laws(p)
    n = len(seen.time)
    n_force, body = np.empty((n, 3)), np.empty((n, 4))
    motion = contact_motion(n)
    box.replay(seen.time, *motion, np.full(n, box.CONTACT_BY_GEOMETRY), p, n_force, body)
    chosen = seen.time >= start
    difference = (n_force - seen.force)[chosen, :2]
    return float(np.sqrt((difference**2).sum() / (seen.force[chosen, :2] ** 2).sum()))


def contact_motion(n: int) -> tuple[Array, Array]:
    """Position and velocity of the strokes, without noise."""
    time = np.arange(n) * STEP
    return scripted_motion("strokes", duration=max(n * STEP, 4.0), lifts=0).sample(time)
