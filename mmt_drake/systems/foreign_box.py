"""The foreign object as a system: ports as `FlexibleBox` has, none of its physics, sensors with errors of their own."""

import math
from typing import Any

import numpy as np
from numba import njit

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.foreign import plant
from mmt_drake.foreign.numbers import Numbers
from mmt_drake.foreign.options import ForeignSensors
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.random import fill_normal
from mmt_drake.systems.flexible_box import SensorNoise
from mmt_drake.systems.surface_system import BODY, CONTACT, FORCE, OWN, PORT_SIZES, SurfaceSystem

# The memory: the plant's state, a count of updates, whether it has begun, then of every tick in turn the force after
# its low pass, and of every tick in turn the measured position.
_, _TICK, _STARTED, _HISTORY = map(Layout(), (plant.STATE_SIZE, 1, 1, 0))

# In the readout, scratch and the memory are the system's own.
_WORK, _MEMORY = OWN, OWN + plant.WORK_SIZE

_NO_FORCES = np.zeros((0, 3))


@njit(cache=True)
def _late(memory: Array, now: Array, t: float, slots: int, sensors: Array, period: float, out: Array) -> None:
    """The force (3) that arrives at time t [N]: between two of those kept, or the last of these and what is now."""
    since, delay = t - memory[plant.TIME], sensors[0]
    newest = int(memory[_TICK]) % slots
    if delay <= since:
        part = delay / since if since > 0.0 else 0.0
        for i in range(3):
            new, old = now[plant.LOW + i], memory[_HISTORY + 3 * newest + i]
            out[i] = new + part * (old - new)
        return
    back = (delay - since) / period
    whole = min(int(back), slots - 2)
    first, second = (newest - whole) % slots, (newest - whole - 1) % slots
    for i in range(3):
        new, old = memory[_HISTORY + 3 * first + i], memory[_HISTORY + 3 * second + i]
        out[i] = new + min(back - whole, 1.0) * (old - new)


@njit(cache=True)
def _stepped(value: float, resolution: float) -> float:
    return resolution * math.floor(value / resolution + 0.5) if resolution > 0.0 else value


@njit(cache=True)
def _read(
    memory: Array,
    t: float,
    motion: Array,
    numbers: Any,
    sensors: Array,
    period: float,
    slots: tuple[int, int],
    sigma: Array,
    seed: int,
    out: Array,
    none: Array,
) -> None:
    """Bring the memory to time t with the probe at `motion`; write readout and new memory to `out`."""
    now, tick = out[_MEMORY:], int(memory[_TICK])
    assign(now, memory)
    fill_normal(seed, tick, out[:FORCE])
    for i in range(3):
        out[i] = _stepped(motion[i] + sigma[0] * out[i], sensors[2])
    positions = _HISTORY + 3 * slots[0]
    begins = memory[_STARTED] == 0.0
    if begins:
        plant.begin(now, t, motion, numbers)
        now[_STARTED] = 1.0
        for j in range(slots[0]):
            assign(now[_HISTORY + 3 * j : _HISTORY + 3 * j + 3], now[plant.LOW : plant.LOW + 3])
        for j in range(slots[1]):
            assign(now[positions + 3 * j : positions + 3 * j + 3], out[:3])
    else:
        plant.advance(now, t, motion, numbers, plant.STEP_S, out[_WORK : _WORK + plant.WORK_SIZE], none, 0)
    came = out[FORCE : FORCE + 3]  # first what has come of the force, in the end the force itself
    _late(now if begins else memory, now, t, slots[0], sensors, period, came)
    since = 0.0 if begins else t - memory[plant.TIME]
    back = slots[1] - 2 if since > 0.0 else slots[1] - 1  # of the positions that are kept
    before = positions + 3 * ((tick - back) % slots[1])
    for i in range(3):
        if slots[1] > 1:
            old = now[before + i]
            out[3 + i] = (out[i] - old) / (since + back * period)
        else:
            out[3 + i] = motion[3 + i] + sigma[1] * out[3 + i]
        out[6 + i] = _stepped(came[i] + sigma[2] * out[6 + i], sensors[1])
    assign(came, now[plant.FORCE : plant.FORCE + 3])
    out[CONTACT] = now[plant.TOUCHES]
    assign(out[BODY : BODY + 4], now[plant.BODY : plant.BODY + 4])
    now[_TICK] += 1.0
    force_at, position_at = _HISTORY + 3 * ((tick + 1) % slots[0]), positions + 3 * ((tick + 1) % slots[1])
    assign(now[force_at : force_at + 3], now[plant.LOW : plant.LOW + 3])
    assign(now[position_at : position_at + 3], out[:3])


class ForeignBoxSystem(SurfaceSystem):
    """A flexible object that shares no physics with the model that estimators and renderers have of one.

    Friction of the table is a vector, with a spring-slider for a stick rule; the integrator and the way between samples
    of the probe are others; see `mmt_drake.foreign.plant`. Its force sensor may be late, filtered and coarse.

    .. pydrake_system::

        name: ForeignBoxSystem
        input_ports:
        - motion
        output_ports:
        - measurement
        - force
        - in_contact
        - body
        - readout
        - point_cloud

    Ports (table frame):

    - `motion` (6): probe position [m] and velocity [m/s].
    - `measurement` (9): position [m], velocity [m/s] and force [N] as the sensors read them.
    - `force` (3): force on the probe [N] as it is, now.
    - `in_contact` (1): 1 where the tip is below the surface.
    - `body` (4): displacement of the body in x and y [m], then its velocity [m/s].
    - `readout` (the four above, scratch, memory): longer by 3 for every tick that a sensor looks back.
    - `point_cloud` (abstract, `Cloud`): the surface, which moves with the body; renewed at the cloud's period.

    Args:
        numbers: of its laws.
        sensors: of the telerobot.
        noise: of these.
        period: of the updates [s].
        surface: the cloud of the undisplaced surface; by default none is seen.
        cloud_period: time between clouds [s].
        cloud_noise: standard deviation of each coordinate of each point, fresh for every cloud [m].

    Raises:
        BadInput: a number without physical meaning, or a window of velocity that is no whole number of periods.
    """

    def __init__(
        self,
        numbers: Numbers,
        sensors: ForeignSensors | None = None,
        *,
        noise: SensorNoise | None = None,
        period: float = 1e-3,
        surface: Cloud | None = None,
        cloud_period: float = 1.0 / 30.0,
        cloud_noise: float = 0.0,
    ) -> None:
        super().__init__()
        sensors, noise = sensors or ForeignSensors(), noise or SensorNoise()
        check_number("environment", "period", period, least=0.0, open_interval=True)
        window = round(sensors.velocity_window / period)
        if abs(window * period - sensors.velocity_window) > 1e-9:
            expected = f"a whole number of periods of {period:g} s"
            raise BadInput(
                "environment", at="sensors.velocity_window", found=sensors.velocity_window, expected=expected
            )
        self._numbers = numbers._replace(lag=sensors.lag).checked(plant.STEP_S)
        self._sensors = np.array([sensors.delay, sensors.force_resolution, sensors.position_resolution])
        self._slots = math.ceil(sensors.delay / period) + 2, window + 1
        self._sigma, self._seed = np.array([noise.position, noise.velocity, noise.force]), int(noise.seed)
        self._period = period
        self.declare_inputs("motion")
        self.declare_readout(PORT_SIZES, np.zeros(_HISTORY + 3 * sum(self._slots)), period, memory_at=_MEMORY)
        self.declare_surface(surface, cloud_period, cloud_noise, self._seed + 1, _MEMORY + _TICK)
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array) -> None:
        own = self._numbers, self._sensors, self._period, self._slots, self._sigma, self._seed
        _read(memory, t, motion, *own, out, _NO_FORCES)
