"""A tip on a surface that stays: a contact in three dimensions, in which nothing but the tip moves.

Under the tip p the surface has height h, outward unit normal n and the touching plane at a distance s below the tip,
negative in contact. With the tip's velocity v and its part u across n, in contact::

    N  = -(k s + b n.v)  with what effects add      along n, as of `mmt_drake.model.kelvin_voigt`; k may be k(x, y)
    T  = k D + b u,   D' = u - slip                 across n: D is anchored where the tip touched, and turns with n
    |T| <= mu max(N, 0) + Fc                        and where that is reached the anchor is carried along, along T
    F  = N n - T - c u                              on the tip

Across n the contact is `across` times as stiff as along it, k and b there standing for that (Mindlin 1949: 0.67 to 1
for a sphere). Where there is no friction the tip glides freely. The frame of forces may
be turned against that of positions (`mmt_drake.model.turned`). Where the tip is not where it was recorded, who drives
the contact moves it there (`Additions.tool`).
"""

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, ClassVar

import numpy as np
from numba import njit

from mmt_drake.model import kelvin_voigt as spring
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.local_contact import Touch, carried, let_through, turned
from mmt_drake.model.parameters import MAX_STEP
from mmt_drake.model.place_table import PlaceTable, under
from mmt_drake.model.structure import Structure
from mmt_drake.model.turned import TURN_SIZE, in_force_frame, rotation
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.numeric.vectors import Vector, across, dot, get, length, minus, plus, put, times
from mmt_drake.quantities import Damping, Level, Quantity, Stiffness

# Layout of the kernel vector; behind it the rotation, the surface, perhaps the stiffness, and the kernel vector of the
# spring along n. The step stands where all kernel vectors have it.
_MU, _FC, _C, _K, _B, _ACROSS, _SURFACE, _STIFFNESS, _SPRING = range(9)
_TURN = MAX_STEP + 1
_NOWHERE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SurfaceContact(Structure):
    """A tip that presses into a surface and glides over it.

    Attributes:
        k: stiffness of the contact [N/m], >= 0.
        b: its damping [N s/m], >= 0.
        height: of the surface, while it is level [m].
        mu: friction of the tip on the surface, in proportion to the load N, >= 0.
        Fc: the same, whatever the load [N], >= 0.
        c: drag of the tip along the surface [N s/m], >= 0.
        across: stiffness and damping of the contact along the surface, over those along its normal, >= 0.
        surface: heights [m] in the place of a level one.
        stiffness: k [N/m] over places, in the place of one k.
        additions: what effects add.

    Raises:
        BadInput: a number that is negative or not finite.
    """

    k: Stiffness = 0.0
    b: Damping = 0.0
    height: Annotated[float, Quantity("m", -math.inf)] = 0.0
    mu: Annotated[float, Quantity("1")] = 0.0
    Fc: Level = 0.0
    c: Damping = 0.0
    across: Annotated[float, Quantity("1")] = 1.0
    surface: PlaceTable | None = field(default=None, metadata={"in_files": False})
    stiffness: PlaceTable | None = field(default=None, metadata={"in_files": False})

    NAME: ClassVar = "surface_contact"
    BLOCKS: ClassVar = ("friction", "contact", "channel", "geometry")
    SYMBOLS: ClassVar = {
        **{"k2": "k", "b2": "b", "normal_k": "k", "normal_b": "b"},
        **{"height": "height", "surface": "surface", "mu": "mu", "Fc": "Fc", "b": "c"},
    }
    ALWAYS: ClassVar = ("height",)
    GIVEN: ClassVar = ("across",)
    TAKES: ClassVar = (
        *("probe_slip", "coulomb_friction", "viscous_friction", "surface_shape"),
        *("stiffness_map", "frame_misalignment", "tool_offset", "time_delay"),
        *("nonlinear_stiffness", "stiffness_drift", "hunt_crossley_damping"),
        *("viscoelastic_relaxation", "hardening_relaxation", "hysteresis"),
    )

    def value(self, symbol: str) -> float:
        """See `Structure.value`; it always has a surface."""
        return 1.0 if symbol == "surface" else super().value(symbol)

    def kernel_vector(self, max_step: float = math.inf) -> Array:
        """The vector that the compiled functions read."""
        flat = (0.0, 1.0)
        surface = self.surface or PlaceTable(flat, flat, (self.height,) * 4)
        stiffness = () if self.stiffness is None else self.stiffness.packed()
        packed = np.concatenate([surface.packed(), stiffness])
        p = np.zeros(_TURN)
        p[[_MU, _FC, _C, _K, _B, _ACROSS]] = self.mu, self.Fc, self.c, self.k, self.b, self.across
        p[_SURFACE] = _TURN + TURN_SIZE
        p[_SPRING] = p[_SURFACE] + len(packed)
        p[_STIFFNESS] = p[_SPRING] - len(stiffness)
        own = replace(self.additions, turn=_NOWHERE, tool=_NOWHERE, delay=0.0, friction=None)
        along = KelvinVoigt(k=self.k, b=self.b, additions=own).kernel_vector(max_step)
        p[MAX_STEP] = along[MAX_STEP]
        return np.concatenate([p, rotation(*self.additions.turn), packed, along])


# Layout of the state vector.
_next = Layout()
TIME = _next()  # [s] of the latest sample
BEGAN = _next()  # [s], time of the first sample
TOUCHES = _next()  # 1 in contact
PROBE = _next(3)  # [m]
STRETCH = _next(3)  # D [m]
FORCE = _next(3)  # on the probe [N], as the sensor reads it
ALONG = _next()  # N [N]
DEPTH = _next()  # -s [m], 0 off contact
SPEED = _next()  # |u| [m/s]
SPRING = _next(spring.STATE_SIZE)
STATE_SIZE = _next.size


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, motion: Array, p: Array) -> None:
    """The contact at the probe's first sample; fills `state` (STATE_SIZE,). Args as `advance`."""
    state[:] = 0.0
    state[TIME] = state[BEGAN] = t
    put(state, PROBE, get(motion, 0))
    advance(state, t, motion, p)


@njit(cache=True, error_model="numpy")
def advance(state: Array, t: float, motion: Array, p: Array) -> None:
    """Bring the contact to the probe's next sample, in place.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: time of the sample [s]; equal to the state's time only replaces the sample.
        motion: (6,) position [m] and velocity [m/s] of the probe.
        p: kernel vector of a `SurfaceContact`.
    """
    at, rate, h = get(motion, 0), get(motion, 3), t - state[TIME]
    moved = minus(at, get(state, PROBE))
    state[TIME] = t
    put(state, PROBE, at)
    here = under(p[int(p[_SURFACE]) :], at[0], at[1])
    scale = 1.0 / math.sqrt(1.0 + here.hx * here.hx + here.hy * here.hy)
    n: Vector = (-here.hx * scale, -here.hy * scale, scale)
    s = (at[2] - here.h) * scale
    along, own = p[int(p[_SPRING]) :], state[SPRING:STATE_SIZE]
    if s >= 0.0:
        state[TOUCHES] = state[ALONG] = state[DEPTH] = state[SPEED] = 0.0
        put(state, STRETCH, (0.0, 0.0, 0.0))
        put(state, FORCE, (0.0, 0.0, 0.0))
        return
    if state[TOUCHES] == 0.0:
        spring.begin(own, t, s, dot(n, rate), 0.0, along)
        own[spring.BEGAN] = state[BEGAN]
        moved = (0.0, 0.0, 0.0)
    else:
        spring.advance(own, t, s, dot(n, rate), 0.0, along)
    k = p[_K]
    if p[_STIFFNESS] != p[_SPRING]:
        k = under(p[int(p[_STIFFNESS]) :], at[0], at[1]).h
    normal, u = spring.force_on_probe(own, along) - (k - p[_K]) * s, across(rate, n)
    d = plus(turned(get(state, STRETCH), n), across(moved, n))
    along_k, along_b = p[_ACROSS] * k, p[_ACROSS] * p[_B]
    tangential = plus(times(along_k, d), times(along_b, u))
    share = let_through(p[_MU] * max(normal, 0.0) + p[_FC], length(tangential))
    put(state, STRETCH, carried(d, Touch(normal, tangential, share), h, along_k, along_b))
    force = minus(minus(times(normal, n), times(share, tangential)), times(p[_C], u))
    put(state, FORCE, in_force_frame(p, _TURN, force[0], force[1], force[2]))
    state[TOUCHES], state[ALONG], state[DEPTH], state[SPEED] = 1.0, normal, -s, length(u)


@njit(cache=True, error_model="numpy", nogil=True)
def replay(time: Array, position: Array, velocity: Array, p: Array, found: Array) -> None:
    """The contact over a whole recording.

    Args:
        time: (n,) sample times [s], increasing.
        position, velocity: (n, 3) of the probe [m], [m/s].
        p: kernel vector of a `SurfaceContact`.
        found: (n, 6) to be filled with the force that the sensor reads [N], N [N], the depth [m] and the speed at which
            the tip glides [m/s].
    """
    state, motion = np.empty(STATE_SIZE), np.empty(6)
    for k in range(len(time)):
        for i in range(3):
            motion[i], motion[3 + i] = position[k, i], velocity[k, i]
        if k == 0:
            begin(state, time[k], motion, p)
        else:
            advance(state, time[k], motion, p)
        for i in range(6):
            found[k, i] = state[FORCE + i]
