"""Several flexible objects on a table under one probe, as a system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, State

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.model import flexible_box as box
from mmt_drake.model import on_table
from mmt_drake.model.body import AXIS_SIZE, POSITION, VELOCITY
from mmt_drake.model.parameters import FlexibleBoxModel, M
from mmt_drake.model.scene_layout import MOST
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.random import fill_normal
from mmt_drake.systems.flexible_box import SensorNoise, put_measurement
from mmt_drake.systems.kernel_system import KernelSystem
from mmt_drake.systems.surface_system import BODY, CONTACT, FORCE
from mmt_drake.systems.surface_system import OWN as TOUCHED

_COLLISION_RATE = 300.0  # [rad/s] of the lightest pair: a collision lasts some milliseconds


@dataclass(frozen=True)
class OnTable:
    """An object on the table.

    Attributes:
        model: its structure and numbers.
        at: x, y of the middle of its top before it is moved [m].
        size: its sides along x and y, and its height [m]; of a cylinder the first is the diameter.
        round: it is a cylinder.
        top: height of its top in the table frame [m].
    """

    model: FlexibleBoxModel
    at: tuple[float, float]
    size: tuple[float, float, float]
    round: bool
    top: float

    def row(self) -> Array:
        """(on_table.ROW,) as the kernels read it."""
        across = self.size[0] if self.round else self.size[1]
        return np.array([*self.at, self.top, 0.5 * self.size[0], 0.5 * across, float(self.round)])

    def points(self, spacing: float) -> Array:
        """(n, 3) points of its top, a square lattice [m]."""
        x, y = (
            np.linspace(-0.5, 0.5, max(2, round(side / spacing) + 1)) * side
            for side in (self.size[0], self.size[0] if self.round else self.size[1])
        )
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        if self.round:
            grid = grid[np.hypot(*grid.T) <= 0.5 * self.size[0]]
        return np.column_stack([grid + self.at, np.full(len(grid), self.top)])


@njit(cache=True)
def _read(
    memory: Array,
    t: float,
    motion: Array,
    rows: Array,
    p: Array,
    k: float,
    noisy: float,
    sigma: Array,
    seed: int,
    bodies: int,
    out: Array,
) -> None:
    """Bring the memory to time t with the probe at `motion`; write readout and new memory to `out`."""
    n = len(rows)
    places = bodies + 4 * n
    work = out[places + 2 * MOST :]
    moved, push, now = work[:6], work[6 : 6 + 2 * n].reshape(n, 2), work[6 + 2 * n :]
    assign(now, memory)
    states = now[: n * box.STATE_SIZE].reshape(n, box.STATE_SIZE)
    own = now[n * box.STATE_SIZE :]  # count of updates, whether it has begun, the object that is held, the last one
    if own[1] == 0.0:
        on_table.begin(states, t, motion, rows, p, moved)
        own[1], own[2], own[3] = 1.0, on_table.NONE, 0.0
    else:
        own[2] = on_table.advance(states, int(own[2]), t, motion, rows, p, k, moved, push)
        own[3] = own[2] if own[2] != on_table.NONE else own[3]
    last = int(own[3])
    read = out[FORCE : FORCE + 3]  # first what the sensor reads, in the end the force itself
    box.reading(states[last], p[last], read)
    put_measurement(motion, noisy, sigma, seed, int(own[0]), out)
    box.force_on_probe(states[last], p[last], read)
    out[CONTACT] = states[last, box.CONTACT]
    out[TOUCHED] = own[2] + 1.0
    for i in range(n):
        for axis in range(2):
            at = box.BODY + AXIS_SIZE * axis
            out[bodies + 4 * i + axis] = states[i, at + POSITION]
            out[places + 2 * i + axis] = rows[i, on_table.MIDDLE + axis] + states[i, at + POSITION]
            out[bodies + 4 * i + 2 + axis] = states[i, at + VELOCITY]
    for i in range(2 * n, 2 * MOST):
        out[places + i] = 0.0
    assign(out[BODY : BODY + 4], out[bodies + 4 * last : bodies + 4 * last + 4])


class ObjectsOnTable(KernelSystem):
    """Objects that slide on a table, one of which the probe's tip may hold; they push each other where they meet.

    Each is a `FlexibleBox` under a level top of its own height and footprint. See `mmt_drake.model.on_table` for what
    is touched and how they collide. All outputs belong to the input at the same instant.

    .. pydrake_system::

        name: ObjectsOnTable
        input_ports:
        - motion
        output_ports:
        - measurement
        - force
        - in_contact
        - body
        - touched
        - bodies
        - places
        - readout
        - point_cloud

    Ports (table frame):

    - `motion` (6): probe position [m] and velocity [m/s].
    - `measurement` (9): position [m], velocity [m/s] and force [N] as the sensors read them, with noise.
    - `force` (3): force on the probe [N] as it is.
    - `in_contact` (1): 1 where the tip holds an object.
    - `body` (4): displacement of the one that is held, or was last, in x and y [m], then its velocity [m/s].
    - `touched` (1): which one is held, counted from 1 in their order [1]; 0: none.
    - `bodies` (four an object): displacements in x and y [m] and velocities [m/s] of all, in their order.
    - `places` (12): x, y of the middles of their tops [m], in their order; zeros for those that there are not.
    - `readout` (the seven above in that order, scratch, the memory): all of it.
    - `point_cloud` (abstract, `Cloud`): all tops, renewed at the cloud's period.

    Args:
        things: the objects.
        period: of the updates [s].
        noise: of the sensors.
        spacing: between the points of a top [m]; 0: none is seen.
        cloud_period: time between clouds [s].
        cloud_noise: standard deviation of each coordinate of each point, fresh for every cloud [m].

    Raises:
        BadInput: there is none, two overlap, or one has a parameter without physical meaning.
    """

    def __init__(
        self,
        things: Sequence[OnTable],
        *,
        period: float = 1e-3,
        noise: SensorNoise | None = None,
        spacing: float = 0.0,
        cloud_period: float = 1.0 / 30.0,
        cloud_noise: float = 0.0,
    ) -> None:
        super().__init__()
        noise = noise or SensorNoise()
        check_number("environment", "period", period, least=0.0, open_interval=True)
        n = len(things)
        if not 0 < n <= MOST:
            raise BadInput("environment", at="things", found=n or "none", expected=f"one object, {MOST} at most")
        self._rows = np.array([thing.row() for thing in things])
        vectors = [thing.model.kernel_vector() for thing in things]
        self._p = np.zeros((n, max(map(len, vectors))))
        for row, vector in zip(self._p, vectors, strict=True):
            row[: len(vector)] = vector
        states = np.zeros((n, box.STATE_SIZE))
        for i in range(n):
            for j in range(i):
                if on_table.overlap(states, self._rows, i, j)[0] > 0.0:
                    found = f"objects {j + 1} and {i + 1} in one place"
                    raise BadInput("environment", at="things", found=found, expected="objects beside each other")
        self._k = float(np.sort(self._p[:, M])[:2].prod() / np.sort(self._p[:, M])[:2].sum()) if n > 1 else 1.0
        self._k *= _COLLISION_RATE**2
        self._sigma = np.array([noise.position, noise.velocity, noise.force])
        self._noisy, self._seed = bool(self._sigma.any()), int(noise.seed)
        sizes = {
            "measurement": 9,
            "force": 3,
            "in_contact": 1,
            "body": 4,
            "touched": 1,
            "bodies": 4 * n,
            "places": 2 * MOST,
        }
        self._bodies = TOUCHED + 1
        own = n * box.STATE_SIZE
        initial = np.zeros(own + 4)
        self.declare_inputs("motion")
        self.declare_readout(sizes, initial, period, memory_at=self._bodies + 6 * n + 6 + 2 * MOST)
        self._count = own
        self._tops = [thing.points(spacing) for thing in things] if spacing > 0.0 else []
        self._cloud_noise = cloud_noise
        cloud = self.DeclareAbstractState(AbstractValue.Make(self._seen(np.zeros(4 * n), 0.0, 0)))
        self.DeclareStateOutputPort("point_cloud", cloud)
        if self._tops:
            self.DeclarePeriodicUnrestrictedUpdateEvent(cloud_period, 0.0, self._update_cloud)
        if cloud_noise > 0.0:
            fill_normal(0, 0, np.zeros(1))  # compiles it
        self.compile_kernels()

    def _compute(self, t: float, memory: Array, out: Array, motion: Array) -> None:
        given = self._rows, self._p, self._k, self._noisy, self._sigma, self._seed, self._bodies
        _read(memory, t, motion, *given, out)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        super()._update(context, state)
        state.get_mutable_value()[self._count] += 1.0

    def _update_cloud(self, context: Context, state: State) -> None:
        bodies = self._readout.Eval(context)[self._bodies :]
        count = int(context.get_discrete_state_vector().value()[self._count])
        state.get_mutable_abstract_state(0).set_value(self._seen(bodies, context.get_time(), count))

    def _seen(self, bodies: Array, t: float, count: int) -> Cloud:
        if not self._tops:
            return Cloud.empty(t)
        moved = [top + np.append(bodies[4 * i : 4 * i + 2], 0.0) for i, top in enumerate(self._tops)]
        points = np.concatenate(moved)
        if self._cloud_noise > 0.0:
            disturbance = np.empty(points.size)
            fill_normal(self._seed + 1, count, disturbance)
            points += self._cloud_noise * disturbance.reshape(points.shape)
        return Cloud(points, stamp=t)
