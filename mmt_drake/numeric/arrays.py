"""Array operations as numpy has them, cheap to compile."""

from typing import Any

from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array
from numpy import bool_, float64
from numpy.typing import NDArray

Array = NDArray[float64]
Flags = NDArray[bool_]
_types: Any = types
_array: Any = make_array
_pointer: Any = cgutils.get_item_pointer


def _typed_loads(typingctx: Any, array: Any, length: Any) -> Any:
    """Loads, and no bounds are checked."""
    numbers = _types.UniTuple(array.dtype, length.literal_value)

    def codegen(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        holds = _array(array)(context, builder, given[0])
        at = [
            _pointer(context, builder, array, holds, [context.get_constant(_types.intp, i)])
            for i in range(length.literal_value)
        ]
        return context.make_tuple(builder, numbers, [builder.load(one) for one in at])

    return numbers(array, length), codegen


fixed_tuple: Any = intrinsic(prefer_literal=True)(_typed_loads)
"""In a kernel, the first so many numbers of an array as a tuple: `fixed_tuple(array, 3)`.

numba's own `to_fixed_tuple` writes the whole tuple anew for each of its numbers, at the price of a step of the physics.
"""


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


@njit(cache=True)
def same(one: Array, other: Array) -> bool:
    """Whether two vectors of one length are alike to the bit, where neither has NaN."""
    alike = True
    for i in range(one.shape[0]):
        alike = alike and one[i] == other[i]
    return alike
