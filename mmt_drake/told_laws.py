"""Laws beside the numbers of a model, as a message tells them and as kernels that know the numbers alone take them.

A kernel vector of `VECTOR_SIZE` has room for `MOST_EFFECTS` laws behind its numbers. Renderer and estimator put there
what is known, anew with each set of numbers. All laws stand in one table, those along the surface first. The normal
axis (`mmt_drake.model.normal_axis`) is the vector's end, without entries: its head tells where in the table its own
begin.
"""

import math
from functools import lru_cache

import numpy as np
from numba import njit

from mmt_drake.errors import MmtError
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.law_table import ENTRY, HEAD, MEMORY, VALUES, table
from mmt_drake.model.laws import LAW_PARAMETERS, ActiveLaw
from mmt_drake.model.message_layout import MOST_EFFECTS
from mmt_drake.model.normal_axis import replay_normal
from mmt_drake.model.parameters import (
    B1,
    B2,
    FD,
    FS,
    GAP,
    K1,
    K2,
    KERNEL_SIZE,
    LAW_TABLE,
    LAWS,
    NORMAL_AXIS,
    NORMAL_B,
    NORMAL_K,
    THETA_AT,
    VD,
    M,
    accurate_step,
)
from mmt_drake.model.turned import TURN_SIZE, rotation
from mmt_drake.model_message import ModelMessage
from mmt_drake.numeric.arrays import Array, Flags, assign
from mmt_drake.numeric.layout import Layout

_TABLE_SIZE = HEAD + MOST_EFFECTS * ENTRY

# A kernel vector: with room for a table of laws, and for what they add at most to the body's stiffness [N/m]
# and damping [N s/m].
STIFFNESS = KERNEL_SIZE + _TABLE_SIZE
DAMPING = STIFFNESS + 1
_NORMAL = DAMPING + 1
_NORMAL_SIZE = TURN_SIZE + KERNEL_SIZE + HEAD
VECTOR_SIZE = _NORMAL + _NORMAL_SIZE

# What a message tells of laws, as the kernels take it: addresses of this process in the place of names.
_MOST_REPLACED = 3
_next = Layout()
NUMBER = _next()  # of the message; 0: there is none
REFUSED = _next()  # 0, or the status that says why it is passed over
COUNT = _next()  # of laws
ALONG_NORMAL = _next()  # of these, along the surface normal
CLEARANCE = _next()  # of the contact spring [m], which is no law of a table
_TABLE = _next(_TABLE_SIZE)
_BOUNDS = _next(2)  # stiffness and damping
_NORMAL_PART = _next(_NORMAL_SIZE)
_USES = _next(MOST_EFFECTS * LAW_PARAMETERS)  # where in a kernel vector a number of a law stands; -1: it is its own
_REPLACED = _next(MOST_EFFECTS * _MOST_REPLACED)  # numbers of a kernel vector whose place a law takes; -1: none
TOLD_SIZE = _next.size

NO_LAWS = np.zeros(TOLD_SIZE)
"""Nothing is told; writable as the arrays of ports are, and never written to."""

_STANDS = {"m": M, "k": K1, "k2": K2, "b": B1, "b2": B2, "Fc": FD, "normal_k": NORMAL_K, "normal_b": NORMAL_B}
"""Common symbol -> where its number stands in a kernel vector; others do not change with theta."""
_TAKEN = {"Fc": (FS, FD, VD), "b": (B1,), "normal_k": (NORMAL_K,)}
"""Common symbol -> the numbers that go where a law replaces it."""
REPLACED = tuple(number for numbers in _TAKEN.values() for number in numbers)
"""Where in a kernel vector numbers stand whose place a law may take."""


def told_by(message: ModelMessage) -> Array:
    """(TOLD_SIZE,) what a message tells of laws."""
    told, effects = np.zeros(TOLD_SIZE), message.acting
    told[NUMBER], told[CLEARANCE] = message.number, message.clearance
    if not effects:
        return told
    along = [law for effect, law in effects if not effect.axis]
    normal = [law for effect, law in effects if effect.axis]
    told[COUNT], told[ALONG_NORMAL] = len(effects), len(normal)
    entries = table(tuple(along), LAW_TABLE)
    told[_TABLE : _TABLE + len(entries)] = entries
    if normal:
        of_normal = _normal_part(normal, along)
        told[_NORMAL_PART : _NORMAL_PART + _NORMAL_SIZE] = of_normal[:_NORMAL_SIZE]
        first = _TABLE + len(entries)
        told[first : first + ENTRY * len(normal)] = of_normal[_NORMAL_SIZE:]
    told[_BOUNDS] = math.fsum(law.stiffness for law in along)
    told[_BOUNDS + 1] = math.fsum(law.damping for law in along)
    told[_USES:] = -1.0
    in_table = sorted(effects, key=lambda both: (bool(both[0].axis), both[1].law.slot, both[1].law.order))
    for place, (effect, _) in enumerate(in_table):
        uses = _USES + place * LAW_PARAMETERS + len(effect.parameters)
        told[uses : uses + len(effect.uses)] = [_STANDS.get(symbol, -1) for symbol in effect.uses]
        taken = _TAKEN[effect.replaces] if effect.replaces is not None else ()
        at = _REPLACED + place * _MOST_REPLACED
        told[at : at + len(taken)] = taken
    return told


def _normal_part(laws: list[ActiveLaw], along: list[ActiveLaw]) -> Array:
    """The normal axis' end of a kernel vector, and behind it the entries of its laws, which stand after those along.

    Places in memory are counted on, so that a law that changes place in the table takes its memory along alike on each
    axis.
    """
    found = table(tuple(laws), LAW_TABLE + ENTRY * len(along) - (_NORMAL + TURN_SIZE))
    head, entries = found[:HEAD], found[HEAD:].reshape(-1, ENTRY)
    taken = sum(law.law.remembers for law in along)
    entries[entries[:, MEMORY] >= 0.0, MEMORY] += 2.0 * taken
    own = KelvinVoigt(k=0.0, b=0.0).kernel_vector()
    own[LAWS] = len(laws)
    return np.concatenate([rotation(0.0, 0.0, 0.0), own, head, entries.ravel()])


def without_effect(known: Array) -> Flags:
    """(10,) of theta: whether a law that is known (TOLD_SIZE,) has taken the number's place, and does without it."""
    if known[COUNT] == 0.0:
        return np.zeros(len(THETA_AT), dtype=bool)
    return np.isin(THETA_AT, known[_REPLACED:]) & ~np.isin(THETA_AT, known[_USES:_REPLACED])


def remembers_along_normal(known: Array) -> bool:
    """Whether a law along the normal that is known (TOLD_SIZE,) has a memory."""
    first = _TABLE + HEAD
    entries = known[first : first + int(known[COUNT]) * ENTRY].reshape(-1, ENTRY)
    return bool((entries[len(entries) - int(known[ALONG_NORMAL]) :, MEMORY] >= 0.0).any())


def along_normal(
    known: Array, sample: float, height: Array, rate: Array, contact: Array, changes: Array | None = None
) -> Array:
    """(3, n) force along the normal with the laws that are known: of each unit of its k and b, and the rest [N].

    It is linear in both, be it that a law is in proportion to one of them; a unit of one whose place a law takes makes
    none.
    Of a contact at the first sample what may relax has relaxed, and a loop is in its middle.

    Args:
        known: (TOLD_SIZE,).
        sample: time between samples [s].
        height, rate: (n,) of the probe above the surface [m], [m/s].
        contact: (n,) 0 or 1.
        changes: (c,) times of touch and release after the first sample [s]; the samples at which it is so by default.

    Raises:
        MmtError: a law is too fast to be followed from sample to sample.
    """
    found = np.vstack([-height, -rate, np.zeros(len(height))]) * contact
    if known[ALONG_NORMAL] == 0.0 or not len(height):
        return found
    time: Array = sample * np.arange(len(height), dtype=np.float64)
    changes = time[1:][np.diff(contact) != 0.0] if changes is None else changes
    laws = np.empty((3, len(height)))
    for row, (k, b) in enumerate(((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))):
        p = np.zeros(VECTOR_SIZE)
        p[NORMAL_K], p[NORMAL_B] = k, b
        put_laws(known, p)
        found[row] *= k * p[NORMAL_K] + b * p[NORMAL_B]
        axis = p[_NORMAL + TURN_SIZE :]
        try:
            replay_normal(time, height, rate, bool(contact[0]), changes, axis, laws[row])
        except RuntimeError as error:  # as of a fit along the surface
            raise MmtError(str(error)) from None
    found[:2] += laws[:2] - laws[2]
    found[2] = laws[2]
    return found


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
    p[LAWS], p[GAP] = known[COUNT], known[CLEARANCE]
    if known[COUNT] == 0.0:
        return
    assign(p[KERNEL_SIZE:STIFFNESS], known[_TABLE:_BOUNDS])
    p[STIFFNESS], p[DAMPING] = known[_BOUNDS], known[_BOUNDS + 1]
    if known[ALONG_NORMAL] != 0.0:
        assign(p[_NORMAL:VECTOR_SIZE], known[_NORMAL_PART:_USES])
        p[NORMAL_AXIS] = _NORMAL
    for i in range(int(known[COUNT])):
        for k in range(LAW_PARAMETERS):
            stands = int(known[_USES + i * LAW_PARAMETERS + k])
            if stands >= 0:
                p[entry_of(i) + VALUES + k] = p[stands]
    for i in range(MOST_EFFECTS * _MOST_REPLACED):
        if known[_REPLACED + i] >= 0.0:
            p[int(known[_REPLACED + i])] = 0.0


@njit(cache=True)
def tells_any(known: Array) -> bool:
    """Whether any law is known (TOLD_SIZE,), be it a clearance."""
    return bool(known[COUNT] != 0.0 or known[CLEARANCE] != 0.0)


@njit(cache=True)
def forget(known: Array) -> None:
    """Leave nothing known of laws, but the number of the message."""
    known[COUNT] = known[CLEARANCE] = 0.0


@njit(cache=True)
def silence(p: Array) -> tuple[float, float, float]:
    """Leave a kernel vector without laws, or a clearance; how `sound` brings them back."""
    were = p[LAWS], p[NORMAL_AXIS], p[GAP]
    p[LAWS] = p[NORMAL_AXIS] = p[GAP] = 0.0
    return were


@njit(cache=True)
def sound(p: Array, were: tuple[float, float, float]) -> None:
    """Give a kernel vector the laws back that `silence` has taken."""
    p[LAWS], p[NORMAL_AXIS], p[GAP] = were


@njit(error_model="numpy", forceinline=True)
def entry_of(i: int) -> int:
    """Where in a kernel vector the entry of law `i` begins."""
    return LAW_TABLE + HEAD + i * ENTRY


@njit(error_model="numpy", forceinline=True)
def acts_along_normal(p: Array, i: int) -> bool:
    """Whether law `i` of a kernel vector is one of the normal axis."""
    count = p[_NORMAL + TURN_SIZE + LAWS] if p[NORMAL_AXIS] != 0.0 else 0.0
    return i >= p[LAWS] - count


@njit(cache=True)
def step_with_laws(p: Array) -> float:
    """The longest step that is accurate [s], with laws as stiff and strongly damped as they may be."""
    k, b = (p[STIFFNESS], p[DAMPING]) if p[LAWS] != 0.0 else (0.0, 0.0)
    return accurate_step(p[M], p[K1] + k, p[K2], p[B1] + b, p[B2])
