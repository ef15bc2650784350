"""The operator's own copy of the object: one compiled tick of the force renderer (thesis, section 3.1.1 and D.4)."""

import math

import numpy as np
from numba import njit

from mmt_drake.model import flexible_box as box
from mmt_drake.model.body import AXIS_SIZE, MODE, POSITION, VELOCITY
from mmt_drake.model.energy import stored_energy
from mmt_drake.model.held_body import watch
from mmt_drake.model.local_contact import Facet
from mmt_drake.model.on_surface import advance_on, begin_on, put_facet
from mmt_drake.model.theta import NO_FLAW, flaw_of_theta, write_theta
from mmt_drake.model.theta import TOO_STIFF as STIFF_THETA
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.numeric.vectors import UP, dot, get
from mmt_drake.rendering import updates
from mmt_drake.rendering.finite import HOLD_S, LET_GO_S, all_finite, share_held
from mmt_drake.rendering.held_body import bring, distance
from mmt_drake.rendering.laws import adopt_laws, align
from mmt_drake.rendering.status import (
    APPROACHING,
    NO_MODEL,
    NOT_FELT,
    NOT_FINITE,
    RENDERING,
    TOO_FAST,
    TOO_STIFF,
    UNSTABLE,
    WAITING,
)
from mmt_drake.told_laws import (
    NO_LAWS,
    NUMBER,
    REFUSED,
    TOLD_SIZE,
    VECTOR_SIZE,
    forget,
    put_laws,
    silence,
    step_with_laws,
    tells_any,
)

# The memory.
_next = Layout()
_STATE = _next.part(box.STATE_SIZE)  # of the object
_HELD = _next(VECTOR_SIZE)  # what is rendered, as a kernel vector with room for laws
_TARGET = _next(VECTOR_SIZE)  # the latest good set, likewise
_KNOWN = _next()  # 1 once a good set has arrived
_RESERVE = _next()  # see `updates`
_SINCE = _next(3)  # when the body came to where it is, along x and y, and the contact began or ended
_SEEN = _next(3)  # where the hand was when that was known last
_FELT, _LEFT = _next(3), _next()  # the force on it then, and what is left of that
_UNSEEN = _next()  # ticks since then
THING = _next()  # identity of the object that is rendered; 0: nobody has said
_LAWS = _next(TOLD_SIZE)  # what the last good message tells of laws
MEMORY_SIZE = _next.size

#: A model so stiff that it needs more substeps than this for one of the settings' own is not rendered.
MOST_SUBSTEPS = 100

#: What a tick puts out, one after the other; the memory stands behind it.
PORT_SIZES = {"force": 3, "status": 1, "update_jump": 3, "stored_energy": 1}
READOUT_SIZES = (*PORT_SIZES.values(), MEMORY_SIZE)
_, _STATUS, _JUMP, _ENERGY, _MEMORY = map(Layout(), READOUT_SIZES)
#: Where in that there is a 1 once there is a model, and a 0 while nothing is rendered.
MODEL_KNOWN = _MEMORY + _KNOWN
#: Where the time [s] of the last motion stands that could be used.
MODEL_TIME = _MEMORY + box.TIME
NO_PLANE = np.zeros(4)
"""Stands for a plane that nobody tells: the last one, which was level at first."""


@njit(cache=True)
def _verdict(theta: Array, stable: float, known: bool, least_step: float) -> float:
    """The status that a set gets; RENDERING for a good one."""
    if not stable > 0.0:  # nor is NaN
        return UNSTABLE if known else WAITING
    flaw = flaw_of_theta(theta, least_step)
    if flaw == NO_FLAW:
        return RENDERING
    return TOO_STIFF if flaw == STIFF_THETA else NO_MODEL


@njit(cache=True)
def _put_in(now: Array, hand: Array) -> float:
    """Energy [J] that the hand has put in since it was seen last: a device holds the force of a tick until the next.

    Of the time in which it was not seen only the ends are known. It counts as gone straight from one to the other, and
    as met by that force between the first and the last which is less to its credit.
    """
    given = 0.0
    for i in range(3):
        step = -now[_FELT + i] * (hand[i] - now[_SEEN + i])
        given += step if step < 0.0 else now[_LEFT] * step
        now[_SEEN + i] = hand[i]
    return given


@njit(cache=True)
def _feel(memory: Array, hand: Array, energy: float, rule: Array, out: Array) -> bool:
    """Let the hand feel as much of the force in `out` as it has paid for; True for all of it."""
    now, share = out[_MEMORY:], 1.0
    if rule[updates.RESERVE] > 0.0:
        taken, ticks = math.inf if memory[_KNOWN] == 0.0 else 0.0, 1.0 + memory[_UNSEEN]
        for i in range(_STATUS):  # at first nobody knows how fast it is, and after a gap only how fast it was
            taken += out[i] * (hand[i] - memory[_SEEN + i]) / ticks
        share = updates.covered(out[:_STATUS], taken, ticks, energy + now[_RESERVE], rule)
    for i in range(_STATUS):
        out[i] *= share
    assign(now[_FELT:_LEFT], out[:_STATUS])
    now[_LEFT], now[_UNSEEN] = 1.0, 0.0
    return share == 1.0


@njit(cache=True)
def _let_go(memory: Array, t: float, hand: Array, seen: bool, rule: Array, out: Array) -> None:
    """Hold the force of the memory, and let it go by time t; the object catches up with no more than that."""
    now = out[_MEMORY:]
    out[:_MEMORY] = 0.0
    out[_STATUS] = NOT_FINITE
    if now[_KNOWN] == 0.0:
        return
    state, p = now[_STATE], now[_HELD:_TARGET]
    state[box.TIME] = max(state[box.TIME], t - HOLD_S - LET_GO_S)
    box.force_on_probe(state, p, out[:_STATUS])
    left = share_held(t - state[box.TIME])
    for i in range(_STATUS):
        out[i] *= left
    out[_ENERGY] = stored_energy(state, p)
    if seen:
        _feel(memory, hand, out[_ENERGY], rule, out)
    else:
        now[_LEFT], now[_UNSEEN] = left, memory[_UNSEEN] + 1.0


@njit(cache=True)
def meet(memory: Array, thing: float) -> bool:
    """Begin another object: its body rests and counts from where it is. False: it is the same, or one is still held.

    Args:
        memory: (MEMORY_SIZE,), changed in place.
        thing: identity of the object that the hand is over; 0: nobody knows.
    """
    state = memory[_STATE]
    if not thing > 0.0 or thing == memory[THING] or state[box.CONTACT] != 0.0:
        return False
    memory[THING] = thing
    for at in (box.BODY, box.BODY + AXIS_SIZE):
        state[at + POSITION] = state[at + VELOCITY] = state[at + MODE] = 0.0
    return True


@njit(cache=True)
def drop_laws(memory: Array, number: float) -> bool:
    """Leave the laws that a memory has out as too fast, until a later message tells some; False: it has none.

    Args:
        memory: (MEMORY_SIZE,), changed in place.
        number: of the latest message.
    """
    if not tells_any(memory[_LAWS:MEMORY_SIZE]):
        return False
    silence(memory[_HELD:_TARGET])
    silence(memory[_TARGET:_KNOWN])
    forget(memory[_LAWS:MEMORY_SIZE])
    memory[_LAWS + NUMBER], memory[_LAWS + REFUSED] = max(memory[_LAWS + NUMBER], number), TOO_FAST
    return True


@njit(error_model="numpy")
def _put_laws(known: Array, target: Array, firm: bool, least_step: float) -> float:
    """Put the laws that are known into the latest set; 0, or the status that says why that goes without."""
    if not tells_any(known):
        return 0.0
    if not firm:
        return NOT_FELT
    put_laws(known, target)
    if step_with_laws(target) >= least_step:
        return 0.0
    silence(target)
    return TOO_FAST


@njit(error_model="numpy")
def _facet_now(state: Array, told: Array, world: float, mu: float) -> Facet:
    """The plane under the hand, as the object takes it whose state at the last tick is given; the rest as told."""
    size = told[0] * told[0] + told[1] * told[1] + told[2] * told[2]
    if not (all_finite(told) and abs(size - 1.0) < 1e-3):
        if state[box.FACET + 5] == 0.0:  # nothing has begun
            return Facet(UP, 0.0, world, mu)
        return Facet(get(state, box.FACET), state[box.FACET + 3], world, mu)
    n = get(told, 0)
    return Facet(n, told[3] - (0.0 if world != 0.0 else dot(n, box.body_of(state)[0])), world, mu)


@njit(cache=True)
def render_on(
    memory: Array,
    t: float,
    motion: Array,
    hand: Array,
    theta: Array,
    stable: float,
    in_contact: float,
    rule: Array,
    placed: bool,
    held: Array,
    told: Array,
    world: float,
    mu: float,
    laws: Array,
    out: Array,
) -> None:
    """Bring the memory to time t with the operator at `motion`; write what is put out and the new memory to `out`.

    With a motion or a contact that is not finite the object stays where it is, and the force is let go (`finite`).

    Args:
        memory: (MEMORY_SIZE,) of the last tick; zeros before the first.
        t: [s].
        motion: (6,) position [m] and velocity [m/s] of the probe.
        hand: (6,) position [m] and velocity [m/s] of the hand that feels the force: the probe's, unless something
            yields between them.
        theta: (10,) the latest set.
        stable: 1 if it may be rendered.
        in_contact: 0 or 1.
        rule: how it is taken up, of `renderer_rule`.
        placed: the probe stands still where it is put, throughout the step; its velocity in `motion` has to be zero.
        held: (7,) where friction holds the body (`mmt_drake.model.held_body`); stamped by the operator's clock.
        told: (4,) the plane under the probe: n, and n . x of its points [m], table frame; zeros, or what is not finite:
            it is the last one.
        world: 1 where the surface stays, 0 where the body carries it.
        mu: friction of the probe on it; infinite: it never slips.
        laws: (TOLD_SIZE,) what a message tells of laws (`mmt_drake.rendering.laws`); they act where the surface
            stays and the probe does not slip on it, a clearance on a level surface alone.
        out: (sum(READOUT_SIZES),).
    """
    facet = _facet_now(memory[_STATE], told, world, mu)
    now = out[_MEMORY:]
    assign(now, memory)
    state, p, target = now[_STATE], now[_HELD:_TARGET], now[_TARGET:_KNOWN]
    force, jump, since = out[:_STATUS], out[_JUMP:_ENERGY], now[_SINCE:_SEEN]
    by_energy, seen = rule[updates.RESERVE] > 0.0, all_finite(hand[:3])
    if by_energy and seen:
        now[_RESERVE] += _put_in(now, hand)
    if not (all_finite(hand) and all_finite(motion) and math.isfinite(in_contact)):
        _let_go(memory, t, hand, seen, rule, out)
        return
    known = memory[_KNOWN] != 0.0
    least_step, refused = rule[updates.LONGEST_STEP] / MOST_SUBSTEPS, adopt_laws(now[_LAWS:MEMORY_SIZE], laws)
    status = _verdict(theta, stable, known, least_step)
    firm = facet.world != 0.0 and facet.mu == math.inf
    if not firm:
        silence(p)
        silence(target)
    if status == RENDERING:
        write_theta(theta, rule[updates.LONGEST_STEP], rule[updates.IN_PLANE], target)
        if by_energy:
            updates.make_passive(target)
        passed_over = _put_laws(now[_LAWS:MEMORY_SIZE], target, firm, least_step)
        refused = passed_over if refused == 0.0 else refused
    if known:
        # What lies between the last update and now is integrated with the model as it was then.
        before = stored_energy(state, p)
        if placed:
            assign(state[box.PROBE : box.PROBE + 6], motion)
        if state[box.CONTACT] == 0.0:  # a plane of free space is none that the probe came along
            put_facet(state, facet)
        advance_on(state, t, motion, in_contact, facet, p)
        watch(memory, now, since)
        if by_energy:
            now[_RESERVE] = updates.account(state, p, before, now[_RESERVE], rule)
    elif status == RENDERING:
        now[_KNOWN] = 1.0
        updates.without_contact(target, p)
        begin_on(state, t, motion, in_contact, facet, p)
        since[:] = t
    else:
        out[:_MEMORY] = 0.0
        out[_STATUS] = status
        return
    box.force_on_probe(state, p, jump)
    align(state, p, target)
    share, now[_RESERVE] = updates.take_up(state, p, target, now[_RESERVE], rule, force)
    box.force_on_probe(state, p, force)
    now[_RESERVE] = bring(state, p, held, since, distance(force, jump), now[_RESERVE], rule, force)
    for i in range(3):
        jump[i] = force[i] - jump[i]
    out[_ENERGY] = stored_energy(state, p)
    whole = _feel(memory, hand, out[_ENERGY], rule, out) and share == 1.0
    if status == RENDERING:
        status = refused if refused != 0.0 else RENDERING if whole else APPROACHING
    out[_STATUS] = status


@njit(cache=True)
def render(
    memory: Array,
    t: float,
    motion: Array,
    hand: Array,
    theta: Array,
    stable: float,
    in_contact: float,
    rule: Array,
    placed: bool,
    held: Array,
    out: Array,
) -> None:
    """`render_on` a level surface, without laws."""
    given = (memory, t, motion, hand, theta, stable, in_contact, rule, placed, held)
    render_on(*given, NO_PLANE, 1.0, math.inf, NO_LAWS, out)
