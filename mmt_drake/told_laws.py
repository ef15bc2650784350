"""Laws beside the numbers of a model, as a message tells them and as kernels that know the numbers alone take them.

A kernel vector of `VECTOR_SIZE` has room for `MOST_EFFECTS` laws behind its numbers. Renderer and estimator put there
what is known, anew with each set of numbers.
"""

import math
from functools import lru_cache

import numpy as np
from numba import njit

from mmt_drake.effects import LIBRARY
from mmt_drake.model.law_table import ENTRY, HEAD, VALUES, table
from mmt_drake.model.laws import LAW_PARAMETERS
from mmt_drake.model.message_layout import MOST_EFFECTS
from mmt_drake.model.parameters import B1, B2, FD, FS, K1, K2, KERNEL_SIZE, LAW_TABLE, LAWS, VD, M, accurate_step
from mmt_drake.model_message import ModelMessage
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout

_TABLE_SIZE = HEAD + MOST_EFFECTS * ENTRY

# A kernel vector: with room for a table of laws, and for what they add at most to the body's stiffness [N/m]
# and damping [N s/m].
STIFFNESS = KERNEL_SIZE + _TABLE_SIZE
DAMPING = STIFFNESS + 1
VECTOR_SIZE = DAMPING + 1

# What a message tells of laws, as the kernels take it: addresses of this process in the place of names.
_MOST_REPLACED = 3
_next = Layout()
NUMBER = _next()  # of the message; 0: there is none
REFUSED = _next()  # 0, or the status that says why it is passed over
COUNT = _next()  # of laws
_TABLE = _next(_TABLE_SIZE)
_BOUNDS = _next(2)  # stiffness and damping
_USES = _next(MOST_EFFECTS * LAW_PARAMETERS)  # where in a kernel vector a number of a law stands; -1: it is its own
_REPLACED = _next(MOST_EFFECTS * _MOST_REPLACED)  # numbers of a kernel vector whose place a law takes; -1: none
TOLD_SIZE = _next.size

NO_LAWS = np.zeros(TOLD_SIZE)
"""Nothing is told; writable as the arrays of ports are, and never written to."""

_STANDS = {"m": M, "k": K1, "k2": K2, "b": B1, "b2": B2, "Fc": FD}
"""Common symbol -> where its number stands in a kernel vector; others do not change with theta."""
_TAKEN = {"Fc": (FS, FD, VD), "b": (B1,)}
"""Common symbol -> the numbers that go where a law replaces it."""


def told_by(message: ModelMessage) -> Array:
    """(TOLD_SIZE,) what a message tells of laws."""
    told, laws = np.zeros(TOLD_SIZE), message.laws
    told[NUMBER], told[COUNT] = message.number, len(laws)
    if not laws:
        return told
    entries = table(laws, LAW_TABLE)
    told[_TABLE : _TABLE + len(entries)] = entries
    told[_BOUNDS] = math.fsum(law.stiffness for law in laws)
    told[_BOUNDS + 1] = math.fsum(law.damping for law in laws)
    told[_USES:] = -1.0
    order = sorted(range(len(laws)), key=lambda i: (laws[i].law.slot, laws[i].law.order))  # as in the table
    for place, i in enumerate(order):
        effect = LIBRARY[message.effects[i].name]
        uses = _USES + place * LAW_PARAMETERS + len(effect.parameters)
        told[uses : uses + len(effect.uses)] = [_STANDS.get(symbol, -1) for symbol in effect.uses]
        taken = _TAKEN[effect.replaces] if effect.replaces is not None else ()
        at = _REPLACED + place * _MOST_REPLACED
        told[at : at + len(taken)] = taken
    return told


@lru_cache(maxsize=64)
def told_by_bytes(vector: bytes) -> Array:
    """`told_by` the message of a vector (MESSAGE_SIZE,) in bytes; `NO_LAWS` where there is none yet.

    Raises:
        BadInput: as `ModelMessage.from_vector`.
    """
    message = ModelMessage.from_vector(np.frombuffer(vector))
    return NO_LAWS if message is None else told_by(message)


@njit(cache=True)
def put_laws(known: Array, p: Array) -> None:
    """Put the laws that are known into a kernel vector (VECTOR_SIZE,) that theta has made."""
    p[LAWS] = known[COUNT]
    if known[COUNT] == 0.0:
        return
    assign(p[KERNEL_SIZE:STIFFNESS], known[_TABLE:_BOUNDS])
    p[STIFFNESS], p[DAMPING] = known[_BOUNDS], known[_BOUNDS + 1]
    for i in range(int(known[COUNT])):
        for k in range(LAW_PARAMETERS):
            stands = int(known[_USES + i * LAW_PARAMETERS + k])
            if stands >= 0:
                p[entry_of(i) + VALUES + k] = p[stands]
    for i in range(MOST_EFFECTS * _MOST_REPLACED):
        if known[_REPLACED + i] >= 0.0:
            p[int(known[_REPLACED + i])] = 0.0


@njit(error_model="numpy", forceinline=True)
def entry_of(i: int) -> int:
    """Where in a kernel vector the entry of law `i` begins."""
    return LAW_TABLE + HEAD + i * ENTRY


@njit(cache=True)
def step_with_laws(p: Array) -> float:
    """The longest step that is accurate [s], with laws as stiff and strongly damped as they may be."""
    k, b = (p[STIFFNESS], p[DAMPING]) if p[LAWS] != 0.0 else (0.0, 0.0)
    return accurate_step(p[M], p[K1] + k, p[K2], p[B1] + b, p[B2])
