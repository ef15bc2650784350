"""The environment of set-up 1: the probe's position drives the surface of a flexible object."""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
from numba import njit
from pydrake.systems.framework import Context, DiscreteValues

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.model import body
from mmt_drake.model import flexible_box as box
from mmt_drake.model.local_contact import Facet
from mmt_drake.model.on_surface import advance_on, begin_on, predicted
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Additions
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.numeric.vectors import Vector, dot, get
from mmt_drake.quantities import Checked, Quantity, Seed
from mmt_drake.random import fill_normal
from mmt_drake.surfaces import Shape, locate
from mmt_drake.surfaces.layout import MU, WORLD
from mmt_drake.systems.surface_system import BODY, CONTACT, FORCE, OWN, PORT_SIZES, SurfaceSystem

# The memory: the object's state, a count of updates, for the noise, and whether it has begun.
_, _TICK, _STARTED, _MEMORY_SIZE = map(Layout(), (box.STATE_SIZE, 1, 1, 0))

_MEMORY = OWN  # in the readout


@dataclass(frozen=True)
class SensorNoise(Checked):
    """White Gaussian noise of the telerobot's sensors, per axis and sample.

    Attributes:
        force: standard deviation [N].
        position: standard deviation [m].
        velocity: standard deviation [m/s].
        seed: of the noise.

    Raises:
        BadInput: a standard deviation that is negative or not finite.
    """

    force: Annotated[float, Quantity("N")] = 0.0
    position: Annotated[float, Quantity("m")] = 0.0
    velocity: Annotated[float, Quantity("m/s")] = 0.0
    seed: Seed = 0

    CALLED: ClassVar = "noise"


@njit(cache=True)
def _facet(surface: Array, at: Vector, held: Vector) -> Facet:
    depth, n = locate(surface, at, held)
    return Facet(n, depth + dot(n, at), surface[WORLD], surface[MU])


@njit(cache=True)
def put_measurement(motion: Array, noisy: float, sigma: Array, seed: int, count: int, out: Array) -> None:
    """Write what the sensors read to a readout: motion, and force, which stands where the true force belongs.

    Args:
        motion: (6,) of the probe [m], [m/s].
        noisy: whether there is noise.
        sigma: (3,) its standard deviations: position [m], velocity [m/s], force [N].
        seed: of the noise.
        count: of updates.
        out: the readout, changed.
    """
    read = out[FORCE : FORCE + 3]
    if noisy:
        fill_normal(seed, count, out[:FORCE])
        for i in range(3):
            out[i] = motion[i] + sigma[0] * out[i]
            out[3 + i] = motion[3 + i] + sigma[1] * out[3 + i]
            out[6 + i] = read[i] + sigma[2] * out[6 + i]
    else:
        assign(out[:6], motion)
        assign(out[6:FORCE], read)


@njit(cache=True)
def _read(
    memory: Array, t: float, motion: Array, contact: float, p: Array, noisy: float, sigma: Array, seed: int, out: Array
) -> None:
    """Bring the memory to time t with the probe at `motion`; write readout and new memory to `out`."""
    now = out[_MEMORY:]
    assign(now, memory)
    if memory[_STARTED] == 0.0:
        box.begin(now, t, motion, contact, p)
    else:
        box.advance(now, t, motion, contact, p)
    _put_readout(now, motion, p, noisy, sigma, seed, out)


@njit(cache=True)
def _read_on(
    memory: Array,
    t: float,
    motion: Array,
    contact: float,
    p: Array,
    surface: Array,
    noisy: float,
    sigma: Array,
    seed: int,
    out: Array,
) -> None:
    """`_read` under a surface of some shape; apart, as it takes long to compile and most surfaces are level."""
    now = out[_MEMORY:]
    assign(now, memory)
    if memory[_STARTED] == 0.0:
        begin_on(now, t, motion, contact, _facet(surface, get(motion, 0), (0.0, 0.0, 0.0)), p)
    else:
        held = get(now, box.FACET) if now[box.CONTACT] != 0.0 else (0.0, 0.0, 0.0)
        advance_on(now, t, motion, contact, _facet(surface, predicted(now, t, motion, surface[WORLD]), held), p)
    _put_readout(now, motion, p, noisy, sigma, seed, out)


@njit(cache=True)
def _put_readout(now: Array, motion: Array, p: Array, noisy: float, sigma: Array, seed: int, out: Array) -> None:
    now[_STARTED] = 1.0
    read = out[FORCE : FORCE + 3]  # first what the sensor reads, in the end the force itself
    box.reading(now, p, read)
    put_measurement(motion, noisy, sigma, seed, int(now[_TICK]), out)
    box.force_on_probe(now, p, read)
    out[CONTACT] = now[box.CONTACT]
    for i in range(2):
        out[BODY + i] = now[box.BODY + body.AXIS_SIZE * i + body.POSITION]
        out[BODY + 2 + i] = now[box.BODY + body.AXIS_SIZE * i + body.VELOCITY]


class FlexibleBox(SurfaceSystem):
    """A flexible object that slides on a table under the probe's tip (thesis, section 4.1 and D.1).

    Where the tip is below z = 0 it holds the object's surface: F_z = -k z - b v_z and, in x and y,
    m v_m' = k2 d + b2 (v - v_m) - k1 x_m - b1 v_m - friction. Elsewhere the force is zero and the body moves on under
    k1, b1 and friction. At each touch the contact spring starts unstretched. See `mmt_drake.model.flexible_box`. On a
    surface of another shape the same contact acts in the frame of the plane that touches it under the tip
    (`mmt_drake.model.local_contact`).

    All outputs belong to the input at the same instant; between updates they are integrated up to the Context's time.

    .. pydrake_system::

        name: FlexibleBox
        input_ports:
        - motion
        - contact
        output_ports:
        - measurement
        - force
        - in_contact
        - body
        - readout
        - point_cloud

    Ports (table frame):

    - `motion` (6): probe position [m] and velocity [m/s].
    - `contact` (1): 1 where the tip holds the surface; there only with `told_contact`.
    - `measurement` (9): position [m], velocity [m/s] and force [N] as the sensors read them: with what effects make of
      the force, and with noise.
    - `force` (3): force on the probe [N] as it is.
    - `in_contact` (1): 1 where the tip is below the surface.
    - `body` (4): displacement of the body in x and y [m], then its velocity [m/s].
    - `readout` (74): the four above in that order, then the system's memory.
    - `point_cloud` (abstract, `Cloud`): the surface, which moves with the body unless its shape is fixed to the world;
      renewed at the cloud's period.

    Args:
        model: structure, friction, normal contact and effects. A delay (`Additions.delay`) is for the one who drives
            the system to put before its input.
        period: of the updates [s]; 0 updates at every step of the Simulator (for unevenly sampled motions).
        noise: of the sensors.
        told_contact: take contact from the input `contact` (a recording that knows it) instead of from z < 0.
        surface: the cloud of the undisplaced surface; by default none is seen.
        shape: of the surface; level, z = 0 without end, by default.
        cloud_period: time between clouds [s].
        cloud_noise: standard deviation of each coordinate of each point, fresh for every cloud [m].

    Raises:
        BadInput: a parameter without physical meaning, or effects under a surface that is not level.
    """

    def __init__(
        self,
        model: FlexibleBoxModel,
        *,
        period: float = 1e-3,
        noise: SensorNoise | None = None,
        told_contact: bool = False,
        surface: Cloud | None = None,
        shape: Shape | None = None,
        cloud_period: float = 1.0 / 30.0,
        cloud_noise: float = 0.0,
    ) -> None:
        super().__init__()
        noise = noise or SensorNoise()
        check_number("environment", "period", period, least=0.0)
        if shape is not None and replace(model.additions, delay=0.0) != Additions():
            expected = "none under a surface of a shape: they are laws of a level one"
            raise BadInput("environment", at="object.effects", found="effects", expected=expected)
        self._p = model.kernel_vector()
        self._shape = np.zeros(0) if shape is None else shape.packed()
        sigma = np.array([noise.position, noise.velocity, noise.force])
        self._sensors = (bool(sigma.any()), sigma, int(noise.seed))
        self.declare_inputs("motion", contact=1 if told_contact else 0)
        self.declare_readout(PORT_SIZES, np.zeros(_MEMORY_SIZE), period)
        moves = shape is None or shape.fixed_to == "body"
        self.declare_surface(surface, cloud_period, cloud_noise, int(noise.seed) + 1, _MEMORY + _TICK, moves)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array, contact: Array | None) -> None:
        touching = box.CONTACT_BY_GEOMETRY if contact is None else contact[0]
        if len(self._shape):
            _read_on(memory, t, motion, touching, self._p, self._shape, *self._sensors, out)
        else:
            _read(memory, t, motion, touching, self._p, *self._sensors, out)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        super()._update(context, state)
        state.get_mutable_value()[_TICK] += 1.0
