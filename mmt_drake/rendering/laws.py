"""Laws of the rendered object: what a message tells of them, and how they enter, change and leave while it is felt.

A rendered kernel vector has room for `MOST_EFFECTS` laws behind its numbers. A law enters with a share of 0 of its
force and an empty memory; the policy (`updates`) takes the share to 1 as it takes numbers up. The force and the energy
of a law grow linearly with its share, and a share of a passive law is passive. A law that is told no more leaves in the
same way before another one enters. Laws that stay keep share and memory and move to their new values. The body's
position and velocity carry over.
"""

import math
from functools import lru_cache

import numpy as np
from numba import njit

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.body import AXIS_SIZE
from mmt_drake.model.body import MEMORY as BODY_MEMORY
from mmt_drake.model.flexible_box import BODY, force_on_probe
from mmt_drake.model.law_table import ADDRESS, ENTRY, HEAD, MEMORY, SHARE, VALUES, table
from mmt_drake.model.laws import LAW_PARAMETERS
from mmt_drake.model.memory import read_memory, write_memory
from mmt_drake.model.parameters import B1, B2, FD, FS, K1, K2, KERNEL_SIZE, LAW_TABLE, LAWS, VD, M
from mmt_drake.model_message import MOST_EFFECTS, ModelMessage, NotFelt
from mmt_drake.numeric.arrays import Array, assign, fixed_tuple
from mmt_drake.numeric.layout import Layout
from mmt_drake.rendering.status import NOT_FELT, UNKNOWN_MODEL

_TABLE_SIZE = HEAD + MOST_EFFECTS * ENTRY

# A rendered kernel vector: with room for a table of laws, and for what they add at most to the body's stiffness [N/m]
# and damping [N s/m].
STIFFNESS = KERNEL_SIZE + _TABLE_SIZE
DAMPING = STIFFNESS + 1
RENDERED_SIZE = DAMPING + 1

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
    """`told_by` the message of a vector in bytes; one that is refused tells the status that says so."""
    try:
        message = ModelMessage.from_vector(np.frombuffer(vector))
        return NO_LAWS if message is None else told_by(message)
    except BadInput as error:
        told = np.zeros(TOLD_SIZE)
        told[REFUSED] = NOT_FELT if isinstance(error, NotFelt) else UNKNOWN_MODEL
        return told


@njit(cache=True)
def adopt_laws(known: Array, told: Array) -> float:
    """Make what is told what is known, unless it is refused or older; 0, or the status that says so.

    Args:
        known, told: (TOLD_SIZE,) of the last good message, and of the latest.
    """
    if told[REFUSED] != 0.0:
        return told[REFUSED]
    if told[NUMBER] > known[NUMBER]:
        assign(known, told)
    elif told[NUMBER] != 0.0 and told[NUMBER] < known[NUMBER]:
        return UNKNOWN_MODEL
    return known[REFUSED]


@njit(cache=True)
def put_laws(known: Array, p: Array) -> None:
    """Put the laws that are known into a rendered kernel vector that theta has made."""
    p[LAWS] = known[COUNT]
    if known[COUNT] == 0.0:
        return
    assign(p[KERNEL_SIZE:STIFFNESS], known[_TABLE:_BOUNDS])
    p[STIFFNESS], p[DAMPING] = known[_BOUNDS], known[_BOUNDS + 1]
    for i in range(int(known[COUNT])):
        for k in range(LAW_PARAMETERS):
            stands = int(known[_USES + i * LAW_PARAMETERS + k])
            if stands >= 0:
                p[_entry(i) + VALUES + k] = p[stands]
    for i in range(MOST_EFFECTS * _MOST_REPLACED):
        if known[_REPLACED + i] >= 0.0:
            p[int(known[_REPLACED + i])] = 0.0


@njit(error_model="numpy", forceinline=True)
def _entry(i: int) -> int:
    return LAW_TABLE + HEAD + i * ENTRY


@njit(cache=True)
def soften_laws(p: Array, part: float) -> None:
    """Leave all laws this part of their share."""
    for i in range(int(p[LAWS])):
        p[_entry(i) + SHARE] *= part


@njit(error_model="numpy")
def _has(p: Array, address: float) -> bool:
    found = False
    for i in range(int(p[LAWS])):
        found = found or p[_entry(i) + ADDRESS] == address
    return found


@njit(error_model="numpy")
def _same_laws(p: Array, target: Array) -> bool:
    same = p[LAWS] == target[LAWS]
    for i in range(int(p[LAWS])):
        same = same and p[_entry(i) + ADDRESS] == target[_entry(i) + ADDRESS]
    return same


@njit(cache=True)
def align(state: Array, p: Array, target: Array) -> None:
    """Give what is rendered and the latest set the same laws at the same places.

    While a law has a share that is told no more the target is what is rendered without it; when that is gone, those of
    the target enter what is rendered.

    Args:
        state: of the object, whose memory of laws is changed in place.
        p, target: (RENDERED_SIZE,) of what is rendered and of the latest set.
    """
    if (p[LAWS] == 0.0 and target[LAWS] == 0.0) or _same_laws(p, target):
        return
    first, second, leaving = 1.0, 1.0, False
    for i in range(int(p[LAWS])):
        if not _has(target, p[_entry(i) + ADDRESS]):
            first, second = (0.0, second) if i == 0 else (first, 0.0)
            leaving = leaving or p[_entry(i) + SHARE] > 0.0
    if leaving:
        assign(target[KERNEL_SIZE:], p[KERNEL_SIZE:])
        target[LAWS] = p[LAWS]
        target[_entry(0) + SHARE], target[_entry(1) + SHARE] = first, second
    else:
        _enter(state, p, target)


@njit(error_model="numpy")
def _enter(state: Array, p: Array, target: Array) -> None:
    count = int(p[LAWS])
    old = (fixed_tuple(p[_entry(0) : _entry(1)], ENTRY), fixed_tuple(p[_entry(1) : STIFFNESS], ENTRY))
    x, y = BODY + BODY_MEMORY, BODY + AXIS_SIZE + BODY_MEMORY
    of_x, of_y = read_memory(state, x), read_memory(state, y)
    write_memory(state, x, (0.0, 0.0, 0.0, 0.0))
    write_memory(state, y, (0.0, 0.0, 0.0, 0.0))
    assign(p[KERNEL_SIZE:], target[KERNEL_SIZE:])
    p[LAWS] = target[LAWS]
    soften_laws(p, 0.0)
    for i in range(int(p[LAWS])):
        at = _entry(i)
        for j in range(count):
            was = old[j]
            if was[ADDRESS] != p[at + ADDRESS]:
                continue
            p[at + SHARE] = was[SHARE]
            for k in range(LAW_PARAMETERS):
                p[at + VALUES + k] = was[VALUES + k]
            if was[MEMORY] >= 0.0:
                to, since = int(p[at + MEMORY]), int(was[MEMORY])
                state[x + to], state[x + to + 1] = of_x[since], of_x[since + 1]
                state[y + to], state[y + to + 1] = of_y[since], of_y[since + 1]


@njit(cache=True)
def laws_apart(p: Array, target: Array, alike: float) -> bool:
    """True where a share or a number of aligned laws differs by more than `alike` of it."""
    for i in range(int(p[LAWS])):
        for k in range(SHARE, ENTRY):
            wanted = target[_entry(i) + k]
            if abs(wanted - p[_entry(i) + k]) > alike * abs(wanted):
                return True
    return False


@njit(cache=True)
def move_laws(p: Array, target: Array, share: float) -> None:
    """Move shares and numbers of aligned laws a share of the way."""
    for i in range(int(p[LAWS])):
        for k in range(_entry(i) + SHARE, _entry(i) + ENTRY):
            p[k] = target[k] if share == 1.0 else p[k] + share * (target[k] - p[k])
    for k in range(STIFFNESS, RENDERED_SIZE):
        p[k] = target[k] if share == 1.0 else max(p[k], target[k])


@njit(cache=True)
def add_laws(state: Array, p: Array, share: float, force: Array) -> None:
    """Add a share of the force of the laws of p to the (3,) force."""
    x, y, z = force[0], force[1], force[2]
    force_on_probe(state, p, force)
    with_x, with_y, count = force[0], force[1], p[LAWS]
    p[LAWS] = 0.0
    force_on_probe(state, p, force)
    p[LAWS] = count
    force[0], force[1], force[2] = x + share * (with_x - force[0]), y + share * (with_y - force[1]), z
