"""The tip of an arm under impedance control, without the arm: a mass that is pulled to where it should be."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput, check_number
from mmt_drake.model.second_order import exact_step
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Checked, Mass
from mmt_drake.random import fill_normal
from mmt_drake.rendering.finite import all_finite
from mmt_drake.systems.cartesian_impedance import Impedance
from mmt_drake.systems.flexible_box import SensorNoise
from mmt_drake.systems.kernel_system import KernelSystem

_GRAVITY = 9.81
_, _TICK, _MEMORY_SIZE = map(Layout(), (6, 1, 0))  # position, velocity, then the ticks so far, for the noise
_STIFFNESS, _DAMPING, _MASS, _PROBE_MASS = range(4)


@dataclass(frozen=True)
class WristSensor:
    """What measures beside the probe: its force sensor, and the arm's joints.

    Attributes:
        offset: what the force sensor reads without a load, along x, y and z of the table frame [N].
        drift: of the offset along each axis [N/s].
        noise: of the force, and of the arm's position and velocity.
    """

    offset: tuple[float, float, float] = (0.4, -0.7, 1.1)
    drift: float = 0.002
    noise: SensorNoise = SensorNoise(force=0.02, position=1e-5, velocity=5e-4)

    def errors(self, t: float, sample: int) -> Array:
        """(9) what is added to position [m], velocity [m/s] and force [N] at time t [s], in sample number `sample`."""
        wrong = np.empty(9)
        _errors(self.noise.seed, sample, t, *self.kernel_vectors(), wrong)
        return wrong

    def kernel_vectors(self) -> tuple[Array, Array]:
        """(9) standard deviations, and (4) offset and drift, as the kernels read them."""
        sigma = np.repeat([self.noise.position, self.noise.velocity, self.noise.force], 3)
        return sigma, np.array([*self.offset, self.drift])


@dataclass(frozen=True)
class TipSettings(Checked):
    """The tip and what it holds.

    Attributes:
        mass: apparent mass of arm and probe at the tip [kg]; 2 to 4 kg are a Panda's.
        impedance: of the controller; what it says of rotations and posture has no meaning here.
        probe_mass: beyond the force sensor, a part of `mass` [kg].
        sensor: at the wrist.

    Raises:
        BadInput: a mass that is not above 0, a probe of no mass or more than all.
    """

    mass: Mass = 3.0
    impedance: Impedance = field(default_factory=Impedance)
    probe_mass: float = 0.15
    sensor: WristSensor = field(default_factory=WristSensor)

    CALLED: ClassVar = "tip"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 <= self.probe_mass <= self.mass:
            raise BadInput("tip", at="probe_mass", found=self.probe_mass, expected=f"0 to {self.mass:g} kg, all of it")


@njit(cache=True)
def _errors(seed: int, sample: int, t: float, sigma: Array, offset: Array, out: Array) -> None:
    fill_normal(seed, sample, out)
    for i in range(9):
        out[i] *= sigma[i]
    for i in range(3):
        out[6 + i] += offset[i] + offset[3] * t


@njit(cache=True)
def _pull(memory: Array, commanded: Array, axis: int, gains: Array) -> float:
    """Of the controller's spring and damper along an axis [N]."""
    along, slower = commanded[axis] - memory[axis], commanded[3 + axis] - memory[3 + axis]
    return gains[_STIFFNESS] * along + gains[_DAMPING] * slower


def step_of_tip(settings: TipSettings, period: float) -> tuple[Array, Array, Array]:
    """Gains (4,), and the exact step (2, 2), (2,) of `advance_tip` over a period [s]."""
    given = settings.impedance
    gains = np.array([given.stiffness, given.damping, settings.mass, settings.probe_mass])
    return gains, *exact_step(settings.mass, given.damping, given.stiffness, period)


@njit(cache=True)
def advance_tip(memory: Array, commanded: Array, force: Array, gains: Array, own: Array, forced: Array) -> None:
    """The tip after a period in which command and force are held, in place; where one is not finite it stays.

    Args:
        memory: (7,) position [m], velocity [m/s], and the ticks so far.
        commanded: (6,) where it should be [m], and its velocity [m/s].
        force: (3,) that it meets [N].
        gains, own, forced: `step_of_tip`.
    """
    memory[_TICK] += 1.0
    if not (all_finite(commanded) and all_finite(force)):
        return
    for i in range(3):
        x, v = memory[i], memory[3 + i]
        held = gains[_STIFFNESS] * commanded[i] + gains[_DAMPING] * commanded[3 + i] + force[i]
        memory[i] = own[0, 0] * x + own[0, 1] * v + forced[0] * held
        memory[3 + i] = own[1, 0] * x + own[1, 1] * v + forced[1] * held


@njit(cache=True)
def _measure(
    memory: Array,
    t: float,
    commanded: Array,
    force: Array,
    gains: Array,
    seed: int,
    sigma: Array,
    offset: Array,
    out: Array,
) -> None:
    """What the sensors read; the force is F + m (g - a), and what is wrong with it."""
    _errors(seed, int(memory[_TICK]), t, sigma, offset, out)
    for i in range(6):
        out[i] += memory[i]
    for i in range(3):
        acceleration = (_pull(memory, commanded, i, gains) + force[i]) / gains[_MASS]
        out[6 + i] += force[i] - gains[_PROBE_MASS] * acceleration
    out[8] -= gains[_PROBE_MASS] * _GRAVITY


class CompliantTipSystem(KernelSystem):
    """A mass that a spring and a damper pull to where it is commanded: M a = K (x_d - x) + D (v_d - v) + F.

    This is what an arm under `CartesianImpedance` looks like from its tip, as far as its mass there is the same in all
    directions. The force F that it meets deflects it, as the stiffness says. Its wrist's sensor carries the probe, of
    mass m, and reads F + m (g - a) with offset, drift and noise. A tick with a command or force that is not finite is
    skipped.

    .. pydrake_system::

        name: CompliantTipSystem
        input_ports:
        - commanded
        - force
        output_ports:
        - motion
        - raw_measurement

    Ports (table frame):

    - `commanded` (6): where the tip should be [m], and its velocity [m/s]; held between ticks.
    - `force` (3): what the environment exerts on it [N]; held between ticks.
    - `motion` (6): where it is [m], and its velocity [m/s]; a state.
    - `raw_measurement` (9): what its sensors read: position [m], velocity [m/s] and force [N], the last with the sign
      of a force on the probe.

    Args:
        settings: what is built.
        start: (3) where it is at rest at first [m].
        period: of the updates [s].

    Raises:
        BadInput: a period that is not positive.
    """

    def __init__(self, settings: TipSettings, start: Array, *, period: float = 1e-3) -> None:
        super().__init__()
        check_number("tip", "period", period, least=0.0, open_interval=True)
        self._gains, self._own, self._forced = step_of_tip(settings, period)
        self._sigma, self._offset = settings.sensor.kernel_vectors()
        self._seed = settings.sensor.noise.seed
        self.declare_inputs("commanded", "force")
        memory = np.zeros(_MEMORY_SIZE)
        memory[:3] = start
        self.declare_memory(memory, period)
        self.declare_state_parts({"motion": 6})
        self.declare_computed("raw_measurement", 9, self._measured, ("commanded", "force"))
        self.compile_kernels()

    def _measured(self, t: float, memory: Array, out: Array, commanded: Array, force: Array) -> None:
        _measure(memory, t, commanded, force, self._gains, self._seed, self._sigma, self._offset, out)

    def _step(self, t: float, memory: Array, commanded: Array, force: Array) -> None:
        advance_tip(memory, commanded, force, self._gains, self._own, self._forced)
