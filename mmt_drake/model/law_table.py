"""The laws of a model as they stand in its kernel vector, and the kernels that call them there."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from mmt_drake.model.laws import (
    AT_TYPE,
    CURVE_LENGTH,
    LAW_PARAMETERS,
    NOTHING,
    NUMBERS_TYPE,
    OWN_TYPE,
    RESULT_TYPE,
    ActiveLaw,
    At,
    Memory,
    Result,
    Slot,
    number_at,
)
from mmt_drake.numeric.arrays import Array

_BYTES = 8  # of a number

# The table in a kernel vector: its head, an entry for each law in the order of the slots, the curves.
# The head: for each slot where in the vector its entries begin, then where those of the last slot end; whether a law on
# the body has a memory, and whether one reads what the other axis of the plane does.
_REMEMBERS = len(Slot) + 1
_IN_PLANE = _REMEMBERS + 1
HEAD = _IN_PLANE + 1
# An entry. An address is a whole number below 2^53, which float64 holds exactly; _CURVE is where the curve begins in
# the vector, or 0; SHARE is that of its force which acts (of what is added: the sensor's laws know none).
_SLOT, ADDRESS, MEMORY, _CURVE, _STORED, SHARE, VALUES = range(7)
ENTRY = VALUES + LAW_PARAMETERS


def table(laws: tuple[ActiveLaw, ...], start: int) -> Array:
    """The laws as numbers for the end of a kernel vector: a head, ENTRY for each, then their curves.

    Args:
        laws: in any order, at most MOST_REMEMBERING with a memory on the body and as many in the sensor.
        start: where in the vector the table begins.
    """
    ordered = sorted(laws, key=lambda active: (active.law.slot, active.law.order))
    head, entries = np.zeros(HEAD), np.zeros((len(laws), ENTRY))
    slots = [active.law.slot for active in ordered]
    head[:_REMEMBERS] = start + HEAD + ENTRY * np.searchsorted(slots, range(_REMEMBERS))
    head[_REMEMBERS] = any(active.law.remembers and active.law.slot != Slot.SENSOR for active in laws)
    head[_IN_PLANE] = any(active.law.in_plane for active in laws)
    curves: list[float] = []
    taken = {True: 0, False: 0}
    for row, active in zip(entries, ordered, strict=True):
        row[_SLOT], row[ADDRESS], row[MEMORY] = active.law.slot, active.law.address, -1.0
        row[_STORED], row[SHARE] = active.law.stored_address, 1.0
        row[VALUES : VALUES + len(active.values)] = active.values
        if active.curve:
            row[_CURVE] = start + HEAD + entries.size + len(curves)
            row[VALUES + CURVE_LENGTH] = len(active.curve)
            curves += [number for column in zip(*active.curve, strict=True) for number in column]
        if active.law.remembers:
            sensor = active.law.slot == Slot.SENSOR
            row[MEMORY] = 2.0 * taken[sensor]
            taken[sensor] += 1
    return np.concatenate([head, entries.ravel(), curves])


def _typed_call(typingctx: Any, address: Any, at: Any, q: Any, p: Any) -> Any:
    """Call the law at an address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in (AT_TYPE, OWN_TYPE, NUMBERS_TYPE)]
        function = ir.FunctionType(context.get_value_type(RESULT_TYPE), kinds)
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), arguments[1:])

    return RESULT_TYPE(types.int64, AT_TYPE, OWN_TYPE, NUMBERS_TYPE), codegen


call_law: Any = intrinsic(_typed_call)


# The kernels below take the address of the kernel vector: an array as an argument would be counted as a reference to
# it, by an atomic operation that costs as much as a law.


@njit(error_model="numpy")
def entries_of(first: int, last: int, vector: int, start: int) -> tuple[int, int]:
    """Begin and end of the entries of the laws in slots `first` to `last`, ENTRY apart.

    Args:
        first, last: slots.
        vector: address of a kernel vector.
        start: where in it the table of laws begins.
    """
    return int(number_at(vector, start + first)), int(number_at(vector, start + last + 1))


@njit(error_model="numpy")
def remembers(vector: int, start: int) -> bool:
    """True where a law on the body has a memory; arguments as of `entries_of`."""
    return bool(number_at(vector, start + _REMEMBERS) != 0.0)


@njit(error_model="numpy")
def read_the_plane(vector: int, start: int) -> bool:
    """True where a law reads what the other axis of the plane does; arguments as of `entries_of`."""
    return bool(number_at(vector, start + _IN_PLANE) != 0.0)


@njit(error_model="numpy")
def slot_of(vector: int, entry: int) -> int:
    """Slot of the law whose entry begins at `entry` in the kernel vector at an address."""
    return int(number_at(vector, entry + _SLOT))


@njit(error_model="numpy")
def memory_of(vector: int, entry: int) -> int:
    """Index at which the memory of the law begins, 0 or 2; -1: it has none."""
    return int(number_at(vector, entry + MEMORY))


@njit(error_model="numpy")
def share_of(vector: int, entry: int) -> float:
    """The share of the law's force that acts."""
    return float(number_at(vector, entry + SHARE))


@njit(error_model="numpy")
def evaluate(vector: int, entry: int, at: At, q: Memory, across: Memory) -> Result:
    """Call the law whose entry begins at `entry`, with its part of the memory `q` and of that of the other axis."""
    return _called(int(number_at(vector, entry + ADDRESS)), vector, entry, at, q, across)


@njit(error_model="numpy")
def stored_by(vector: int, entry: int, at: At, q: Memory, across: Memory) -> float:
    """The energy that the law holds, with its share [J]; arguments as of `evaluate`."""
    address = int(number_at(vector, entry + _STORED))
    if address == 0:
        return 0.0
    energy, _, _, _ = _called(address, vector, entry, at, q, across)
    return energy * share_of(vector, entry)


@njit(error_model="numpy")
def _called(address: int, vector: int, entry: int, at: At, q: Memory, across: Memory) -> Result:
    k = memory_of(vector, entry)
    own = NOTHING
    if k == 0:
        own = (q[0], q[1], across[0], across[1])
    elif k == 2:
        own = (q[2], q[3], across[2], across[3])
    values = vector + _BYTES * (entry + VALUES)
    last = number_at(values, 5)
    curve = int(number_at(vector, entry + _CURVE))
    if curve != 0:
        last = float(vector + _BYTES * curve)
    numbers = (number_at(values, 0), number_at(values, 1), number_at(values, 2), number_at(values, 3))
    result: Result = call_law(address, at, own, (*numbers, number_at(values, 4), last))
    return result
