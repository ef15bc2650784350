"""Flexible objects on a table under one probe, which may have a grip, as a system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numba import njit
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, State

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.foreign import grasped as foreign
from mmt_drake.model import flexible_box as box
from mmt_drake.model import grasped_box as own
from mmt_drake.model import on_table
from mmt_drake.model.scene_layout import MOST
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.random import fill_normal
from mmt_drake.systems.flexible_box import SensorNoise, put_measurement
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.systems.on_table import OnTable
from mmt_drake.systems.surface_system import BODY, CONTACT, FORCE, PORT_SIZES

_COLLISION_RATE = 300.0  # [rad/s] of the lightest pair: a collision lasts some milliseconds
_FAR = 1.0  # above the tip: where a rod that it does not touch is told that the tip is [m]
OF_A_BODY = 5
"""Numbers told of each: displacement along x and y, its rates, height off the table."""

# The readout: the ports, of which `bodies` has as many numbers as there are objects, then scratch, then the memory.
# What that has behind the states of the objects: the grasp's, a count of updates, whether it has begun, the object that
# is held, the last one, and the tip's height at the latest sample.
_PORTS = {**PORT_SIZES, "touched": 1, "held": 4, "places": 2 * MOST}
_, _, _, _, _TOUCHED, _HELD, _PLACES, _BODIES = map(Layout(), (*_PORTS.values(), 0))
_GRASP, _COUNT, _BEGUN, _NOW, _LAST, _BEFORE, _OWN = map(Layout(), (own.GRASP_SIZE, 1, 1, 1, 1, 1, 0))


@njit(cache=True)
def _read(
    memory: Array,
    t: float,
    motion: Array,
    grip: float,
    rows: Array,
    p: Array,
    hung: Array,
    k: float,
    noisy: float,
    sigma: Array,
    seed: int,
    out: Array,
) -> None:
    """Bring the memory to time t with the probe at `motion`; write readout and new memory to `out`."""
    n = len(rows)
    work = out[_BODIES + OF_A_BODY * n :]
    moved, push, now = work[:6], work[6 : 6 + 2 * n].reshape(n, 2), work[6 + 2 * n :]
    assign(now, memory)
    states = now[: n * box.STATE_SIZE].reshape(n, box.STATE_SIZE)
    mine = now[n * box.STATE_SIZE :]
    grasp = mine[:_COUNT]
    if mine[_BEGUN] == 0.0:
        on_table.begin(states, t, motion, rows, p, moved)
        mine[_BEGUN], mine[_NOW], mine[_LAST] = 1.0, on_table.NONE, 0.0
    else:
        touched = int(mine[_NOW])
        touched = on_table.advance(states, grasp, touched, t, motion, grip, rows, p, hung, k, moved, push)
        mine[_NOW] = touched
        mine[_LAST] = touched if touched != on_table.NONE else mine[_LAST]
    last = int(mine[_LAST])
    read = out[FORCE : FORCE + 3]  # first what the sensor reads, in the end the force itself
    held, body = out[_HELD : _HELD + 4], out[BODY : BODY + 4]
    own.read_grasped(states[last], grasp, p[last], hung[last], read, body, held)
    if hung[last, 0] == 0.0:
        box.reading(states[last], p[last], read)
    put_measurement(motion, noisy, sigma, seed, int(mine[_COUNT]), out)
    out[CONTACT] = own.read_grasped(states[last], grasp, p[last], hung[last], read, body, held)
    out[_TOUCHED] = mine[_NOW] + 1.0
    for i in range(n):
        own.place_of(states[i], moved[:4])
        _put_body(out, rows, i, moved[:4], held[3] if i == last else 0.0)


@njit(cache=True)
def _read_rods(
    memory: Array,
    t: float,
    motion: Array,
    grip: float,
    rows: Array,
    p: Array,
    hung: Array,
    noisy: float,
    sigma: Array,
    seed: int,
    out: Array,
) -> None:
    """`_read` by the other simulation; `p`: (n, 9) numbers of its rods."""
    n = len(rows)
    work = out[_BODIES + OF_A_BODY * n :]
    moved, now = work[:6], work[6 + 2 * n :]
    assign(now, memory)
    rods, mine = now[: n * foreign.ROD_SIZE].reshape(n, foreign.ROD_SIZE), now[n * foreign.ROD_SIZE :]
    force, body, held = out[FORCE : FORCE + 3], out[BODY : BODY + 4], out[_HELD : _HELD + 4]
    begins, touched = mine[_BEGUN] == 0.0, int(mine[_NOW])
    if begins:
        mine[_BEGUN], mine[_BEFORE], touched = 1.0, motion[2], on_table.NONE
    elif touched != on_table.NONE:
        foreign.look(rods[touched], p[touched], force, body, held)
        free = held[0] != own.HOLDS and held[3] == 0.0
        if free and not _is_in(rows[touched], body, motion):
            rods[touched, foreign.TIP + 2] += _FAR
            touched = on_table.NONE
    else:
        for i in range(n):
            foreign.look(rods[i], p[i], force, body, held)
            if mine[_BEFORE] >= rows[i, on_table.TOP] and _is_in(rows[i], body, motion):
                rods[i, foreign.TIP + 2] -= _FAR
                touched = i
                break
    for i in range(n):
        assign(moved, motion)
        moved[2] += (0.0 if i == touched else _FAR) - rows[i, on_table.TOP]
        if begins:
            foreign.stand(rods[i], t, moved, p[i])
        foreign.move(rods[i], t, moved, grip if i == touched and hung[i, 0] > 0.0 else 0.0, p[i])
        foreign.look(rods[i], p[i], force, body, held)
        _put_body(out, rows, i, body, held[3])
    mine[_NOW], mine[_BEFORE] = touched, motion[2]
    mine[_LAST] = touched if touched != on_table.NONE else mine[_LAST]
    last = int(mine[_LAST])
    out[CONTACT] = foreign.look(rods[last], p[last], force, body, held)
    put_measurement(motion, noisy, sigma, seed, int(mine[_COUNT]), out)
    out[_TOUCHED] = touched + 1.0


@njit(cache=True)
def _is_in(row: Array, body: Array, motion: Array) -> bool:
    """Whether the tip is below the top of an object and within its rim."""
    x, y = motion[0] - row[on_table.MIDDLE] - body[0], motion[1] - row[on_table.MIDDLE + 1] - body[1]
    return motion[2] < row[on_table.TOP] and on_table.is_over(row, x, y)


@njit(cache=True)
def _put_body(out: Array, rows: Array, i: int, body: Array, height: float) -> None:
    """Write where object i is to a readout."""
    if i == 0:
        for place in range(2 * len(rows), 2 * MOST):
            out[_PLACES + place] = 0.0
    for axis in range(2):
        out[_PLACES + 2 * i + axis] = rows[i, on_table.MIDDLE + axis] + body[axis]
    at = _BODIES + OF_A_BODY * i
    assign(out[at : at + 4], body)
    out[at + 4] = height


class ObjectsOnTable(KernelSystem):
    """Objects that slide on a table, one of which the probe's tip may hold; they push each other where they meet.

    Each is a `FlexibleBox` under a level top of its own height and footprint. See `mmt_drake.model.on_table` for what
    is touched and how they collide. One that hangs in a grip as it says may be lifted, carried and put down
    (`mmt_drake.model.grasped_box`). All outputs belong to the input at the same instant.

    By the other simulation (`mmt_drake.foreign.grasped`) each is a rod that stands there, and they do not meet.

    .. pydrake_system::

        name: ObjectsOnTable
        input_ports:
        - motion
        - grip
        output_ports:
        - measurement
        - force
        - in_contact
        - body
        - touched
        - held
        - places
        - bodies
        - readout
        - point_cloud

    Ports (table frame):

    - `motion` (6): probe position [m] and velocity [m/s].
    - `grip` (1): force of the grip [N], closed from `LEAST_GRIP` on; there only with a `hang`.
    - `measurement` (9): position [m], velocity [m/s] and force [N] as the sensors read them, with noise.
    - `force` (3): force on the probe [N] as it is.
    - `in_contact` (1): 1 where the tip touches or holds an object.
    - `body` (4): displacement of the one that is held, or was last, in x and y [m], then its velocity [m/s].
    - `touched` (1): which one is held, counted from 1 in their order [1]; 0: none.
    - `held` (4): what the grip has (0 nothing, 1 the object, 2 it has slipped out), how far the grip has slipped up the
      object and in all since it closed [m], as its own sensors tell; how high the object is off the table [m], as it
      is.
    - `places` (12): x, y of the middles of their tops [m], in their order; zeros for those that there are not.
    - `bodies` (five an object): displacements in x and y [m], velocities [m/s] and heights off the table [m] of all, in
      their order.
    - `readout` (the eight above in that order, scratch, the memory): all of it.
    - `point_cloud` (abstract, `Cloud`): all tops, renewed at the cloud's period.

    Args:
        things: the objects.
        laws: `own`, or `foreign`: of the simulation that shares no physics with the model.
        period: of the updates [s].
        noise: of the sensors.
        spacing: between the points of a top [m]; 0: none is seen but what says its own.
        cloud_period: time between clouds [s].
        cloud_noise: standard deviation of each coordinate of each point, fresh for every cloud [m].

    Raises:
        BadInput: there is none, two overlap, one has a parameter without physical meaning, one that a grip may take has
            effects, or one is what the other simulation does not have: too light for its steps, or with effects.
    """

    def __init__(
        self,
        things: Sequence[OnTable],
        *,
        laws: Literal["own", "foreign"] = "own",
        period: float = 1e-3,
        noise: SensorNoise | None = None,
        spacing: float = 0.0,
        cloud_period: float = 1.0 / 30.0,
        cloud_noise: float = 0.0,
    ) -> None:
        super().__init__()
        noise = noise or SensorNoise()
        check_number("environment", "period", period, least=0.0, open_interval=True)
        check_number("environment", "cloud_noise", cloud_noise, least=0.0)
        check_number("environment", "cloud_period", cloud_period, least=0.0, open_interval=True)
        n = len(things)
        if not 0 < n <= MOST:
            raise BadInput("environment", at="things", found=n or "none", expected=f"one object, {MOST} at most")
        self._rows = np.array([thing.row() for thing in things])
        self._hung = np.array([thing.hung() for thing in things])
        for i in range(n):
            for j in range(i):
                if on_table.overlap(np.zeros((n, box.STATE_SIZE)), self._rows, i, j)[0] > 0.0:
                    places = " and ".join(f"{things[k].name or f'object {k + 1} '}at {things[k].at}" for k in (j, i))
                    expected = "objects beside each other (at is 0, 0 unless given)"
                    raise BadInput("environment", at="things", found=f"{places} in one place", expected=expected)
        self._foreign = laws == "foreign"
        vectors = [thing.rod() if self._foreign else thing.model.kernel_vector() for thing in things]
        self._p = np.zeros((n, max(map(len, vectors))))
        for row, vector in zip(self._p, vectors, strict=True):
            row[: len(vector)] = vector
        masses = np.sort([thing.model.parameters.m for thing in things])[:2]
        self._k = float(masses.prod() / masses.sum()) * _COLLISION_RATE**2 if n > 1 else 1.0
        self._sigma = np.array([noise.position, noise.velocity, noise.force])
        self._noisy, self._seed = bool(self._sigma.any()), int(noise.seed)
        states = n * (foreign.ROD_SIZE if self._foreign else box.STATE_SIZE)
        self.declare_inputs("motion", grip=1 if self._hung.any() else 0)
        sizes = {**_PORTS, "bodies": OF_A_BODY * n}
        memory_at = sum(sizes.values()) + 6 + 2 * n
        self.declare_readout(sizes, np.zeros(states + _OWN), period, memory_at=memory_at)
        self._count, self._count_at = states + _COUNT, memory_at + states + _COUNT
        self._tops = [thing.points(spacing) for thing in things]
        self._surface = things[0].surface if n == 1 else None
        self._cloud_noise = cloud_noise
        cloud = self.DeclareAbstractState(AbstractValue.Make(self._seen(np.zeros(OF_A_BODY * n), 0.0, 0, 0.0)))
        self.DeclareStateOutputPort("point_cloud", cloud)
        if any(len(top) for top in self._tops):
            self.DeclarePeriodicUnrestrictedUpdateEvent(cloud_period, 0.0, self._update_cloud)
        if cloud_noise > 0.0:
            fill_normal(0, 0, np.zeros(1))  # compiles it
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array, grip: Array | None) -> None:
        given = memory, t, motion, 0.0 if grip is None else grip[0], self._rows, self._p, self._hung
        if self._foreign:
            _read_rods(*given, self._noisy, self._sigma, self._seed, out)
        else:
            _read(*given, self._k, self._noisy, self._sigma, self._seed, out)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        super()._update(context, state)
        state.get_mutable_value()[self._count] += 1.0

    def _update_cloud(self, context: Context, state: State) -> None:
        now = self._readout.Eval(context)
        seen = self._seen(now[_BODIES:], context.get_time(), int(now[self._count_at]), self._cloud_noise)
        state.get_mutable_abstract_state(0).set_value(seen)

    def _seen(self, bodies: Array, t: float, count: int, noise: float) -> Cloud:
        by = [bodies[OF_A_BODY * i : OF_A_BODY * (i + 1)][[0, 1, 4]] for i in range(len(self._tops))]
        if self._surface is not None and noise == 0.0:
            return self._surface.moved(by[0], t)
        points = np.concatenate([top + way for top, way in zip(self._tops, by, strict=True)])
        if noise > 0.0 and len(points):
            disturbance = np.empty(points.size)
            fill_normal(self._seed + 1, count, disturbance)
            points += noise * disturbance.reshape(points.shape)
        return Cloud(points, stamp=t) if len(points) else Cloud.empty(t)
