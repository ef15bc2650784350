"""Laws of the rendered object (`mmt_drake.told_laws`): how they enter, change and leave while it is felt.

A law enters with a share of 0 of its
force and an empty memory; the policy (`updates`) takes the share to 1 as it takes numbers up. The force and the energy
of a law grow linearly with its share, and a share of a passive law is passive. A law that is told no more leaves in the
same way before another one enters. Laws that stay keep share and memory and move to their new values, and a clearance
does from 0 or to it. The body's position and velocity carry over.
"""

from functools import lru_cache

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput
from mmt_drake.model.body import AXIS_SIZE
from mmt_drake.model.body import MEMORY as BODY_MEMORY
from mmt_drake.model.flexible_box import BODY, NORMAL, force_on_probe
from mmt_drake.model.law_table import ADDRESS, ENTRY, MEMORY, SHARE, VALUES
from mmt_drake.model.laws import LAW_PARAMETERS
from mmt_drake.model.memory import read_memory, write_memory
from mmt_drake.model.parameters import GAP, KERNEL_SIZE, LAWS, NORMAL_AXIS
from mmt_drake.model_message import NotFelt
from mmt_drake.numeric.arrays import Array, assign, fixed_tuple, same
from mmt_drake.rendering.status import NOT_FELT, UNKNOWN_MODEL
from mmt_drake.told_laws import (
    CLEARANCE,
    DAMPING,
    NUMBER,
    REFUSED,
    REPLACED,
    STIFFNESS,
    TOLD_SIZE,
    acts_along_normal,
    entry_of,
    silence,
    sound,
    told_by_bytes,
)

_WIDE = 1e-3
"""A clearance is alike to a part of this [m]."""


@lru_cache(maxsize=64)
def felt_by_bytes(vector: bytes, level: bool = True) -> Array:
    """`told_by_bytes` of a vector; one that is refused tells the status that says so.

    Args:
        vector: in bytes.
        level: whether the surface is level, wherever the probe is: no clearance acts on another one.
    """
    try:
        told = told_by_bytes(vector)
        if told[CLEARANCE] != 0.0 and not level:
            raise NotFelt("model message", found="a clearance", expected="none: the surface need not be level")
        return told
    except BadInput as error:
        told = np.zeros(TOLD_SIZE)
        told[REFUSED] = NOT_FELT if isinstance(error, NotFelt) else UNKNOWN_MODEL
        return told


@njit(cache=True)
def adopt_laws(known: Array, told: Array) -> float:
    """Make what is told what is known, unless it is refused, older or another of the same number: who counts anew.

    Args:
        known, told: (TOLD_SIZE,) of the last good message, and of the latest.
    """
    if told[REFUSED] != 0.0:
        return told[REFUSED]
    if told[NUMBER] > known[NUMBER]:
        assign(known, told)
    elif told[NUMBER] != 0.0 and (told[NUMBER] < known[NUMBER] or (known[REFUSED] == 0.0 and not same(told, known))):
        return UNKNOWN_MODEL
    return known[REFUSED]


@njit(error_model="numpy")
def bend(p: Array) -> bool:
    """Whether laws, or a clearance, keep the force from being linear in the numbers and in where the body is."""
    return bool(p[LAWS] != 0.0 or p[GAP] != 0.0)


@njit(cache=True)
def soften_laws(p: Array, part: float) -> None:
    """Leave all laws this part of their share."""
    for i in range(int(p[LAWS])):
        p[entry_of(i) + SHARE] *= part


@njit(error_model="numpy")
def _is_law(p: Array, i: int, address: float, along_normal: bool) -> bool:
    return p[entry_of(i) + ADDRESS] == address and acts_along_normal(p, i) == along_normal


@njit(error_model="numpy")
def _has(p: Array, address: float, along_normal: bool) -> bool:
    found = False
    for i in range(int(p[LAWS])):
        found = found or _is_law(p, i, address, along_normal)
    return found


@njit(error_model="numpy")
def _same_laws(p: Array, target: Array) -> bool:
    same = p[LAWS] == target[LAWS]
    for i in range(int(p[LAWS])):
        same = same and _is_law(target, i, p[entry_of(i) + ADDRESS], acts_along_normal(p, i))
    return same


@njit(cache=True)
def align(state: Array, p: Array, target: Array) -> None:
    """Give what is rendered and the latest set the same laws at the same places.

    While a law has a share that is told no more the target has what is rendered without it, and no law takes the place
    of a number; when that is gone, those of the target enter what is rendered.

    Args:
        state: of the object, whose memory of laws is changed in place.
        p, target: (VECTOR_SIZE,) of what is rendered and of the latest set.
    """
    if (p[LAWS] == 0.0 and target[LAWS] == 0.0) or _same_laws(p, target):
        return
    first, second, leaving = 1.0, 1.0, False
    for i in range(int(p[LAWS])):
        if not _has(target, p[entry_of(i) + ADDRESS], acts_along_normal(p, i)):
            first, second = (0.0, second) if i == 0 else (first, 0.0)
            leaving = leaving or p[entry_of(i) + SHARE] > 0.0
    if leaving:
        _have_laws_of(target, p)
        for i in REPLACED:  # what a law takes the place of goes when that enters, not before
            if target[i] == 0.0:
                target[i] = p[i]
        target[entry_of(0) + SHARE], target[entry_of(1) + SHARE] = first, second
    else:
        _enter(state, p, target)


@njit(error_model="numpy")
def _have_laws_of(p: Array, other: Array) -> None:
    """Give a kernel vector all of another one that is of laws."""
    assign(p[KERNEL_SIZE:], other[KERNEL_SIZE:])
    p[LAWS], p[NORMAL_AXIS] = other[LAWS], other[NORMAL_AXIS]


@njit(error_model="numpy")
def _enter(state: Array, p: Array, target: Array) -> None:
    count = int(p[LAWS])
    old = (fixed_tuple(p[entry_of(0) : entry_of(1)], ENTRY), fixed_tuple(p[entry_of(1) : STIFFNESS], ENTRY))
    along_normal = (acts_along_normal(p, 0), acts_along_normal(p, 1))
    x, y, z = BODY + BODY_MEMORY, BODY + AXIS_SIZE + BODY_MEMORY, NORMAL + BODY_MEMORY
    memories = (read_memory(state, x), read_memory(state, y), read_memory(state, z))
    for at in (x, y, z):
        write_memory(state, at, (0.0, 0.0, 0.0, 0.0))
    _have_laws_of(p, target)
    soften_laws(p, 0.0)
    for i in range(int(p[LAWS])):
        at = entry_of(i)
        for j in range(count):
            was = old[j]
            if not _is_law(p, i, was[ADDRESS], along_normal[j]):
                continue
            p[at + SHARE] = was[SHARE]
            for k in range(LAW_PARAMETERS):
                p[at + VALUES + k] = was[VALUES + k]
            if was[MEMORY] >= 0.0:
                to, since = int(p[at + MEMORY]), int(was[MEMORY])
                for axis in range(3):
                    at_axis = (x, y, z)[axis]
                    state[at_axis + to], state[at_axis + to + 1] = memories[axis][since], memories[axis][since + 1]


@njit(cache=True)
def laws_apart(p: Array, target: Array, alike: float) -> bool:
    """True where a number of aligned laws differs by more than `alike` of it, or a share by so much."""
    for i in range(int(p[LAWS])):
        for k in range(SHARE, ENTRY):
            wanted = target[entry_of(i) + k]
            size = 1.0 if k == SHARE else abs(wanted)
            if abs(wanted - p[entry_of(i) + k]) > alike * size:
                return True
    return abs(target[GAP] - p[GAP]) > alike * _WIDE


@njit(cache=True)
def move_laws(p: Array, target: Array, share: float) -> None:
    """Move shares and numbers of aligned laws, and the clearance, a share of the way."""
    p[GAP] = target[GAP] if share == 1.0 else p[GAP] + share * (target[GAP] - p[GAP])
    for i in range(int(p[LAWS])):
        for k in range(entry_of(i) + SHARE, entry_of(i) + ENTRY):
            p[k] = target[k] if share == 1.0 else p[k] + share * (target[k] - p[k])
    for k in range(STIFFNESS, DAMPING + 1):
        p[k] = target[k] if share == 1.0 else max(p[k], target[k])


@njit(cache=True)
def add_laws(state: Array, p: Array, share: float, force: Array) -> None:
    """Add a share of the force of the laws of p to the (3,) force."""
    x, y, z = force[0], force[1], force[2]
    force_on_probe(state, p, force)
    with_x, with_y, with_z = force[0], force[1], force[2]
    were = silence(p)
    force_on_probe(state, p, force)
    sound(p, were)
    force[0], force[1] = x + share * (with_x - force[0]), y + share * (with_y - force[1])
    force[2] = z + share * (with_z - force[2])
