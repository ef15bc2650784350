"""The memory of a body's laws, four numbers: its arithmetic, and where it stands in a state."""

from numba import njit

from mmt_drake.model.laws import Memory
from mmt_drake.numeric.arrays import Array


@njit(error_model="numpy", forceinline=True)
def moved(q: Memory, h: float, rate: Memory) -> Memory:
    """The memory after h [s] at these rates."""
    return q[0] + h * rate[0], q[1] + h * rate[1], q[2] + h * rate[2], q[3] + h * rate[3]


@njit(error_model="numpy", forceinline=True)
def both(a: Memory, b: Memory) -> Memory:
    """The sum of two."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]


@njit(error_model="numpy", forceinline=True)
def after_step(q: Memory, h: float, r1: Memory, r2: Memory, r3: Memory, r4: Memory) -> Memory:
    """The memory after a Runge-Kutta step of h [s] whose stages have these rates."""
    return moved(moved(q, h / 6.0, both(r1, r4)), h / 3.0, both(r2, r3))


@njit(error_model="numpy", forceinline=True)
def between(a: Memory, b: Memory, part: float) -> Memory:
    """The memory at this part of the way from one to the other."""
    return moved(a, part, (b[0] - a[0], b[1] - a[1], b[2] - a[2], b[3] - a[3]))


@njit(error_model="numpy", forceinline=True)
def read_memory(state: Array, at: int) -> Memory:
    """The memory that begins at `at` in the state."""
    return state[at], state[at + 1], state[at + 2], state[at + 3]


@njit(error_model="numpy", forceinline=True)
def write_memory(state: Array, at: int, q: Memory) -> None:
    """Put the memory where it begins at `at` in the state."""
    state[at], state[at + 1], state[at + 2], state[at + 3] = q
