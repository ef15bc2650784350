"""Friction in the plane, compiled once and called by its address.

Compiled into every kernel that moves a flexible box, it would double the time that these take to compile.
"""

from functools import cache
from typing import Any

from llvmlite import ir
from numba import cfunc, types
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, read_motion, write_motion
from mmt_drake.model.forces import Spring, Surroundings, constants
from mmt_drake.model.hermite import Cubic
from mmt_drake.model.parameters import InPlane
from mmt_drake.model.plane import advance_axes

_kinds: Any = types
_POINTER = _kinds.CPointer(types.float64)
_CUBIC = _kinds.NamedUniTuple(types.float64, 4, Cubic)
_NUMBER = types.float64
_SPRINGS = (_NUMBER, _NUMBER, _CUBIC, _NUMBER, _NUMBER, _CUBIC)
_MOTION = (_POINTER, _NUMBER, _NUMBER, _CUBIC, _CUBIC, _CUBIC, _NUMBER, _NUMBER)
_SIGNATURE = _NUMBER(*(*_MOTION, *_SPRINGS, _POINTER, types.int64))


def _advanced(
    state: Any,
    s: float,
    s_end: float,
    along: Cubic,
    across: Cubic,
    height: Cubic,
    contact: float,
    start: float,
    k_along: float,
    b_along: float,
    push_along: Cubic,
    k_across: float,
    b_across: float,
    push_across: Cubic,
    vector: Any,
    size: int,
) -> float:
    """Whether it failed: no error leaves what is called by its address."""
    both, p = carray(state, 2 * AXIS_SIZE), constants(carray(vector, size))
    first, second = Spring(k_along, b_along, push_along), Spring(k_across, b_across, push_across)
    around = Surroundings(along, height, both[ANCHOR], contact != 0.0, start, first)
    beside = Surroundings(across, height, both[AXIS_SIZE + ANCHOR], contact != 0.0, start, second)
    try:
        x, y = advance_axes(read_motion(both, 0), read_motion(both, AXIS_SIZE), s, s_end, around, beside, p)
    except Exception:  # compiled code knows no other
        return 1.0
    write_motion(both, 0, x)
    write_motion(both, AXIS_SIZE, y)
    return 0.0


@cache
def _compiled() -> Any:
    return cfunc(_SIGNATURE, cache=True, error_model="numpy")(_advanced)


def planar(in_plane: InPlane) -> float:
    """`Constants.planar` of a kernel vector: the address, in this process, of what `advance_both` calls; 0: per axis.

    It is compiled at first use and cached on disk.
    """
    return float(_compiled().address) if in_plane == "vector" else 0.0


def _typed_call(
    typingctx: Any,
    function: Any,
    state: Any,
    s: Any,
    s_end: Any,
    along: Any,
    across: Any,
    height: Any,
    contact: Any,
    start: Any,
    k_along: Any,
    b_along: Any,
    push_along: Any,
    k_across: Any,
    b_across: Any,
    push_across: Any,
    vector: Any,
    size: Any,
) -> Any:
    """Call the function at an address, with addresses in the place of pointers."""
    expected = [types.int64 if kind == _POINTER else kind for kind in _SIGNATURE.args]

    def codegen(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in _SIGNATURE.args]
        called = ir.FunctionType(context.get_value_type(_SIGNATURE.return_type), kinds).as_pointer()
        arguments = [
            builder.inttoptr(value, kind) if isinstance(kind, ir.PointerType) else value
            for value, kind in zip(given[1:], kinds, strict=True)
        ]
        return builder.call(builder.inttoptr(given[0], called), arguments)

    return _SIGNATURE.return_type(types.int64, *expected), codegen


advance_both: Any = intrinsic(_typed_call)
"""`advance_axes` of the two axes of a body, by its address: compiled once, and not into every kernel.

Args:
    function: the address that a kernel vector has where friction is a vector.
    state: address of the first axis; the other follows.
    s, s_end: the stretch of time within the sample interval [s].
    along, across, height: of the probe.
    contact: 1.0 where it holds the contact spring, else 0.0.
    start: time of the first of the two samples since the first of all [s].
    k_along, b_along, push_along, k_across, b_across, push_across: of the springs of both axes (`forces.Spring`).
    vector, size: address and length of the kernel vector.

Returns:
    Not 0 where `advance_axes` has failed.
"""
