"""The environment whose object may be gripped, lifted, carried and put down."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np
from numba import njit
from pydrake.systems.framework import Context, DiscreteValues

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.foreign import grasped as foreign
from mmt_drake.model import carried
from mmt_drake.model import grasped_box as own
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Additions, Friction
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Checked, Quantity
from mmt_drake.random import fill_normal
from mmt_drake.systems.flexible_box import SensorNoise
from mmt_drake.systems.surface_system import BODY, CONTACT, FORCE, SurfaceSystem
from mmt_drake.systems.surface_system import PORT_SIZES as OF_A_SURFACE

_PORT_SIZES = {**OF_A_SURFACE, "held": 4}
_, _, _, _, _HELD, _MEMORY = map(Layout(), (*_PORT_SIZES.values(), 0))
_STATE = max(own.GRASPED_SIZE, foreign.ROD_SIZE)
# The memory: the object's state, a count of updates, for the noise, and whether it has begun.
_, _TICK, _STARTED, _SIZE = map(Layout(), (_STATE, 1, 1, 0))


@dataclass(frozen=True)
class Hang(Checked):
    """How an object hangs in a grip (`mmt_drake.model.carried`).

    Attributes:
        centre: its centre of mass below the grip [m].
        swing: damping ratio of its free swing.
        mu: friction of the grip.

    Raises:
        BadInput: a value out of range.
    """

    centre: Annotated[float, Quantity("m", 0.005, 0.5)] = 0.05
    swing: Annotated[float, Quantity("", 0.0, 1.0)] = 0.05
    mu: Annotated[float, Quantity("1", positive=True)] = 0.6

    CALLED: ClassVar = "hang"


@njit(cache=True)
def _read(
    memory: Array,
    t: float,
    motion: Array,
    grip: float,
    is_foreign: bool,
    box_p: Array,
    p: Array,
    sigma: Array,
    seed: int,
    out: Array,
) -> None:
    """Bring the memory to time t with the probe at `motion`; write readout and new memory to `out`."""
    now = out[_MEMORY:]
    assign(now, memory)
    begins = memory[_STARTED] == 0.0
    now[_STARTED] = 1.0
    force, body, held = out[FORCE : FORCE + 3], out[BODY : BODY + 4], out[_HELD : _HELD + 4]
    numbers = p[: carried.NUMBERS]
    if is_foreign:
        state = now[: foreign.ROD_SIZE]
        if begins:
            foreign.stand(state, t, motion, p)
        foreign.move(state, t, motion, grip, p)
        out[CONTACT] = foreign.look(state, p, force, body, held)
    else:
        grasped = now[: own.GRASPED_SIZE]
        if begins:
            own.begin_grasped(grasped, t, motion, box_p)
        own.advance_grasped(grasped, t, motion, grip, box_p, numbers, p[-1])
        out[CONTACT] = own.read_grasped(grasped, box_p, numbers, force, body, held)
    fill_normal(seed, int(now[_TICK]), out[:FORCE])
    for i in range(3):
        out[i] = motion[i] + sigma[0] * out[i]
        out[3 + i] = motion[3 + i] + sigma[1] * out[3 + i]
        out[6 + i] = force[i] + sigma[2] * out[6 + i]


class GraspableBox(SurfaceSystem):
    """A flexible object on a table that a grip may lift, carry and put down (`mmt_drake.model.grasped_box`).

    On the table and with an open grip it is `FlexibleBox`, or by the other simulation (`mmt_drake.foreign.grasped`) a
    rod that stands there.

    .. pydrake_system::

        name: GraspableBox
        input_ports:
        - motion
        - grip
        output_ports:
        - measurement
        - force
        - in_contact
        - body
        - held
        - readout
        - point_cloud

    Ports (table frame):

    - `motion` (6): probe position [m] and velocity [m/s].
    - `grip` (1): force of the grip [N]; it is closed from `LEAST_GRIP` on.
    - `measurement` (9): position [m], velocity [m/s] and force [N] as the sensors read them, with noise.
    - `force` (3): force on the probe [N] as it is.
    - `in_contact` (1): 1 where the tip touches or holds the object.
    - `body` (4): displacement of the body in x and y [m], then its velocity [m/s].
    - `held` (4): what the grip has (0 nothing, 1 the object, 2 it has slipped out), how far the grip has slipped up the
      object and in all since it closed [m], as its own sensors tell; how high the object is off the table [m], as it
      is.
    - `readout` (the five above, the memory): for a diagram that wants all of them at every tick.
    - `point_cloud` (abstract, `Cloud`): the surface, which goes with the body; renewed at the cloud's period.

    Args:
        model: structure, friction and normal contact; no effects.
        hang: how it hangs in the grip.
        laws: `own`, or `foreign`: of the simulation that shares no physics with the model.
        period: of the updates [s].
        noise: of the sensors.
        surface: the cloud of the undisplaced surface; by default none is seen.
        cloud_period: time between clouds [s].
        cloud_noise: standard deviation of each coordinate of each point, fresh for every cloud [m].

    Raises:
        BadInput: effects, a period that is not positive, or an object too light for the other simulation's steps.
    """

    def __init__(
        self,
        model: FlexibleBoxModel,
        hang: Hang | None = None,
        *,
        laws: Literal["own", "foreign"] = "own",
        period: float = 1e-3,
        noise: SensorNoise | None = None,
        surface: Cloud | None = None,
        cloud_period: float = 1.0 / 30.0,
        cloud_noise: float = 0.0,
    ) -> None:
        super().__init__()
        hang, noise = hang or Hang(), noise or SensorNoise()
        check_number("environment", "period", period, least=0.0, open_interval=True)
        if model.additions != Additions():
            expected = "none: what is carried is a rod without them"
            raise BadInput("environment", at="object.effects", found="effects", expected=expected)
        body, normal = model.parameters, model.normal
        rubs = model.friction or Friction.coulomb(body.Fc)
        numbers = (body.m, body.k2, body.b2, normal.k, normal.b, hang.centre, hang.swing, rubs.Fd, hang.mu)
        # The grip sits at the rod's end, where its mass counts a quarter.
        rate = max(body.b2, normal.b) / (0.25 * body.m) + np.sqrt(max(body.k2, normal.k) / (0.25 * body.m))
        if laws == "foreign" and rate * foreign.STEP > 1.0:
            expected = f"a heavier body, or a softer hold: steps of {foreign.STEP:g} s cannot follow it"
            raise BadInput("environment", at="object.parameters.m", found=body.m, expected=expected)
        self._box, self._p = model.kernel_vector(), np.array(numbers)
        self._foreign = laws == "foreign"
        self._sigma = np.array([noise.position, noise.velocity, noise.force])
        self._seed = int(noise.seed)
        self.declare_inputs("motion", "grip")
        self.declare_readout(_PORT_SIZES, np.zeros(_SIZE), period)
        self.declare_surface(surface, cloud_period, cloud_noise, self._seed + 1, _MEMORY + _TICK)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array, grip: Array) -> None:
        _read(memory, t, motion, grip[0], self._foreign, self._box, self._p, self._sigma, self._seed, out)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        super()._update(context, state)
        state.get_mutable_value()[_TICK] += 1.0

    def _height(self, readout: Array) -> float:
        return float(readout[_HELD + 3])
