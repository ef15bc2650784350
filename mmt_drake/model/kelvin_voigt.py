"""A spring and a damper between the probe and the world, and what effects add.

With d = x - x0 the force on the probe is::

    F = F0 - (k d + b d' + contact laws) + laws on the body - friction, which opposes v

The probe's motion is given, so there is nothing to integrate but the memory of laws; the body of `mmt_drake.model.body`
is the probe itself, and the spring to the world its contact.
"""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

import numpy as np
from numba import njit

from mmt_drake.model.body import (
    AXIS_SIZE,
    MODE,
    POSITION,
    READING,
    VELOCITY,
    advance_memory,
    read_motion,
    sense,
    settle,
)
from mmt_drake.model.forces import ALONE, BodyMotion, Surroundings, constants, deflection, forces, level_spring
from mmt_drake.model.hermite import Cubic, cubic
from mmt_drake.model.over import take_course
from mmt_drake.model.parameters import COURSE, Constants, kernel_vector
from mmt_drake.model.structure import Friction, Structure
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Damping, Quantity, Stiffness


@dataclass(frozen=True)
class KelvinVoigt(Structure):
    """F = F0 - k (x - x0) - b v: the contact in the normal axis, a damper, a tissue.

    Attributes:
        k: stiffness [N/m], >= 0.
        b: damping [N s/m], >= 0.
        x0: rest position [m].
        F0: force at rest [N].
        additions: what effects add.

    Raises:
        BadInput: a negative stiffness or damping, a value that is not finite.
    """

    k: Stiffness = 0.0
    b: Damping = 0.0
    x0: Annotated[float, Quantity("m", -math.inf)] = 0.0
    F0: Annotated[float, Quantity("N", -math.inf)] = 0.0

    NAME: ClassVar = "kelvin_voigt"
    BLOCKS: ClassVar = ("friction", "contact", "force_sensor", "channel")
    SYMBOLS: ClassVar = {"b": "b", "k": "k", "k2": "k", "b2": "b", "normal_k": "k", "normal_b": "b"}

    def value(self, symbol: str) -> float:
        """See `Structure.value`; Coulomb friction is nothing that the structure has by itself."""
        if symbol == "Fc" and self.additions.friction is not None:
            return self.additions.friction.Fd
        return super().value(symbol)

    def with_value(self, symbol: str, value: float) -> Self:
        """See `Structure.with_value`."""
        if symbol == "Fc":
            return self.with_additions(friction=Friction.coulomb(value) if value != 0.0 else None)
        return super().with_value(symbol, value)

    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions read, see `FlexibleBoxModel.kernel_vector`."""
        hold = {"k1": self.k, "b2": self.b, "rest": self.x0, "offset": self.F0}
        friction = self.additions.friction or Friction()
        return kernel_vector(self.additions, friction, **hold, driven=1.0, normal_k=-1.0, max_step=max_step)


# Layout of the state vector.
_next = Layout()
TIME = _next()  # [s] of the latest sample
LOAD = _next()  # [N], at that sample
BEGAN = _next()  # [s], time of the first sample
BODY = _next(AXIS_SIZE)
STATE_SIZE = _next.size


@njit(error_model="numpy", forceinline=True)
def spring_force(probe: BodyMotion, load: float, t: float, c: Constants) -> float:
    """Force on the probe [N] where it is, under a normal load [N], t [s] after the first sample."""
    nothing, over = Cubic(0.0, 0.0, 0.0, 0.0), Cubic(load, 0.0, 0.0, 0.0)
    around = Surroundings(nothing, over, c.rest, True, t, level_spring(c))
    acting = forces(probe, 0.0, around, c, ALONE)
    _, d_rate, _, _ = deflection(probe.x, probe.v, 0.0, around, c, ALONE)
    return acting.drive - c.b2 * d_rate - probe.mode * acting.sliding


@njit(error_model="numpy", forceinline=True)
def _force(state: Array, c: Constants) -> float:
    """Force on the probe at the latest sample [N]."""
    return spring_force(read_motion(state, BODY), state[LOAD], state[TIME] - state[BEGAN], c)


@njit(cache=True, error_model="numpy")
def force_on_probe(state: Array, p: Array) -> float:
    """Force on the probe at the latest sample [N], as it is and not as it is read."""
    return _force(state, constants(p))


@njit(error_model="numpy")
def _take(state: Array, t: float, position: float, velocity: float, load: float, h: float, c: Constants) -> None:
    """Make a sample the latest one; h [s] after the one before."""
    state[TIME], state[LOAD] = t, load
    state[BODY + POSITION], state[BODY + VELOCITY] = position, velocity
    if abs(velocity) > c.v_d:
        state[BODY + MODE] = math.copysign(1.0, velocity)
    sense(state, BODY, _force(state, c), load, velocity, t - state[BEGAN], h, c)


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, position: float, velocity: float, load: float, p: Array) -> None:
    """The contact at the probe's first sample, all laws at rest and what relaxes relaxed; fills `state` (STATE_SIZE,).

    Args as `advance`.
    """
    state[:] = 0.0
    state[BEGAN] = t
    take_course(p, p[COURSE], 0.0)
    c, nothing = constants(p), Cubic(0.0, 0.0, 0.0, 0.0)
    around = Surroundings(nothing, Cubic(load, 0.0, 0.0, 0.0), c.rest, True, 0.0, level_spring(c))
    settle(state, BODY, position, around, c)
    _take(state, t, position, velocity, load, 0.0, c)


@njit(cache=True, error_model="numpy")
def advance(state: Array, t: float, position: float, velocity: float, load: float, p: Array) -> None:
    """Bring the contact to the probe's next sample, in place; in between the motion is a cubic, the load linear.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: time of the sample [s]; equal to the state's time only replaces the sample.
        position, velocity: of the probe [m], [m/s].
        load: normal load [N].
        p: kernel vector of a `KelvinVoigt`.
    """
    take_course(p, p[COURSE], t - state[BEGAN])
    h, c = t - state[TIME], constants(p)
    if h > 0.0 and c.remembers:
        path = cubic(state[BODY + POSITION], state[BODY + VELOCITY], position, velocity, h)
        line = Cubic(state[LOAD], (load - state[LOAD]) / h, 0.0, 0.0)
        nothing = Cubic(0.0, 0.0, 0.0, 0.0)
        around = Surroundings(nothing, line, c.rest, True, state[TIME] - state[BEGAN], level_spring(c))
        advance_memory(state, BODY, h, path, around, c)
    _take(state, t, position, velocity, load, h, c)


@njit(cache=True, error_model="numpy", nogil=True)
def replay(time: Array, position: Array, velocity: Array, load: Array, p: Array, force: Array) -> None:
    """The force over a whole recording.

    Args:
        time: (n,) sample times [s], increasing.
        position, velocity: (n,) of the probe [m], [m/s].
        load: (n,) normal load [N]; zeros where there is none.
        p: kernel vector of a `KelvinVoigt`.
        force: (n,) to be filled with the force that the sensor reads [N].
    """
    state = np.empty(STATE_SIZE)
    for k in range(len(time)):
        if k == 0:
            begin(state, time[k], position[k], velocity[k], load[k], p)
        else:
            advance(state, time[k], position[k], velocity[k], load[k], p)
        force[k] = state[BODY + READING]
