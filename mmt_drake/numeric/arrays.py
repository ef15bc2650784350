"""Array operations as numpy has them, cheap to compile."""

from typing import Any

from numba import njit
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy import bool_, float64
from numpy.typing import NDArray

Array = NDArray[float64]
Flags = NDArray[bool_]
fixed_tuple: Any = to_fixed_tuple
"""In a kernel, the first so many numbers of an array as a tuple: `fixed_tuple(array, 3)`."""


@njit(cache=True)
def assign(target: Array, values: Array) -> None:
    """`target[:] = values`, of one length. numba's own takes half a second to compile, the first in a process eight.

    Raises:
        ValueError: the lengths differ.
    """
    if target.shape[0] != values.shape[0]:
        raise ValueError("lengths differ")
    for i in range(values.shape[0]):
        target[i] = values[i]
