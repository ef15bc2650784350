"""Measurements in the frame of the surface, in which an object that slides along it is one that slides on a table."""

import numpy as np
from numba import njit

from mmt_drake.model.local_contact import Facet, axes_of
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.numeric.vectors import UP, Vector, dot, get, minus, put
from mmt_drake.systems.kernel_system import KernelSystem

_FORCES = ("estimated_force", "filtered_force")
_TIP, _WAY, _NORMAL, _BEGUN, _SIZE = map(Layout(), (3, 2, 4, 1, 0))


@njit(cache=True)
def _frame(memory: Array, facet: Array) -> tuple[Vector, Vector, Vector, float]:
    """The axes of the plane, its normal, and n . x of its points: the last one where none is told."""
    n, c = get(facet, 0), facet[3]
    if not abs(dot(n, n) - 1.0) < 1e-3:  # nor is NaN
        n, c = (get(memory, _NORMAL), memory[_NORMAL + 3]) if memory[_BEGUN] != 0.0 else (UP, 0.0)
    first, second = axes_of(Facet(n, c, 1.0, 0.0))
    return first, second, n, c


@njit(cache=True)
def to_local(memory: Array, measurement: Array, facet: Array, local: Array, now: Array) -> None:
    """A measurement in the frame of the plane under the tip.

    Args:
        memory: (10,) of the last tick: tip, way gone along both axes, plane, whether it has begun.
        measurement: (9,) position [m], velocity [m/s], force [N], table frame.
        facet: (4,) the plane: n, and n . x of its points [m]; zeros: the last one.
        local: (9,) the same along the plane's two axes and its normal, to be filled.
        now: (10,) the new memory.
    """
    first, second, n, c = _frame(memory, facet)
    tip = get(measurement, 0)
    if memory[_BEGUN] == 0.0:
        now[_WAY], now[_WAY + 1] = tip[0], tip[1]
    else:
        step = minus(tip, get(memory, _TIP))
        now[_WAY], now[_WAY + 1] = memory[_WAY] + dot(first, step), memory[_WAY + 1] + dot(second, step)
    put(now, _TIP, tip)
    put(now, _NORMAL, n)
    now[_NORMAL + 3], now[_BEGUN] = c, 1.0
    local[0], local[1], local[2] = now[_WAY], now[_WAY + 1], dot(n, tip) - c
    for i in range(3, 9, 3):
        value = get(measurement, i)
        local[i], local[i + 1], local[i + 2] = dot(first, value), dot(second, value), dot(n, value)


class LocalFrame(KernelSystem):
    """Turns a measurement into the frame of the plane under the tip (thesis, section 3.2), and forces back.

    Its z is the height above the surface along the normal. Its x and y are those of the table on a level surface; on
    another they are turned the shortest way, and count the way that the tip has gone along them, tick by tick: there an
    object that slides along a surface obeys the equations of one on a table, whatever the shape.

    .. pydrake_system::

        name: LocalFrame
        input_ports:
        - raw_measurement
        - facet
        - estimated_force
        - filtered_force
        output_ports:
        - measurement
        - estimated
        - filtered

    - ``raw_measurement`` (9): position [m], velocity [m/s], force [N], table frame.
    - ``facet`` (4): the plane that touches the surface: outward unit normal n, n · x of its points [m]; zeros: the
      last.
    - ``estimated_force`` (3): what an estimator says in the local frame [N]; may stay unconnected.
    - ``filtered_force`` (3): the force that it sees, in the local frame [N]; may stay unconnected.
    - ``measurement`` (9): position [m], velocity [m/s], force [N] in the local frame.
    - ``estimated`` (3): the estimated force in the table frame [N].
    - ``filtered`` (3): the filtered force in the table frame [N].

    The measurement does not wait for the update: it belongs to the inputs at the same instant (direct feedthrough).

    Args:
        period: of the ticks [s].
    """

    def __init__(self, *, period: float = 1e-3) -> None:
        super().__init__()
        self.declare_inputs("raw_measurement", "facet", *_FORCES, optional=_FORCES)
        self._told = ("raw_measurement", "facet")
        self.declare_memory(np.zeros(_SIZE), period)
        self.declare_computed("measurement", 9, self._local, self._told)
        self.declare_computed("estimated", 3, self._in_table, ("facet", "estimated_force"))
        self.declare_computed("filtered", 3, self._in_table, ("facet", "filtered_force"))
        self.compile_kernels()

    def _local(self, t: float, memory: Array, out: Array, measurement: Array, facet: Array) -> None:
        to_local(memory, measurement, facet, out, np.empty(_SIZE))

    def _in_table(self, t: float, memory: Array, out: Array, facet: Array, force: Array | None) -> None:
        _to_table(memory, facet, np.zeros(3) if force is None else force, out)

    def _step(self, t: float, memory: Array, measurement: Array, facet: Array, *forces: Array | None) -> None:
        now = np.empty(_SIZE)
        to_local(memory, measurement, facet, np.empty(9), now)
        assign(memory, now)


@njit(cache=True)
def _to_table(memory: Array, facet: Array, force: Array, out: Array) -> None:
    first, second, n, _ = _frame(memory, facet)
    for i in range(3):
        out[i] = force[0] * first[i] + force[1] * second[i] + force[2] * n[i]
