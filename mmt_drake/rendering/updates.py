"""Policies by which a model that is being felt takes up parameters that arrive.

The object's motion carries over, but its force and its energy change with the numbers. Let p be what is rendered and p*
the latest set. In every tick p moves a share s of the way to p*, and a policy says which:

- at once: s = 1. The force jumps by dF = F(p*) - F(p), and the energy in store by dE = E(p*) - E(p).
- rate-limited: s = min(1, r T / |dF|) for a rate r [N/s] and a period T; dF grows linearly with s.
- blended: s = 1 - exp(-T / tau).
- as energy permits: s = min(1, R / dE) where dE > 0, R being energy that the model has burnt and the hand was not given
  back; dE grows linearly with s too. Dampers and friction hold no energy and wait for none. Both are rate-limited, too.
  Laws (`mmt_drake.rendering.laws`) wait as springs do, whatever they hold. With them dF is no line in s: s is shortened
  until the force has changed by no more than r T.

Every p on the way is stable: that m, b1 + b2 and k1 + k2 are positive holds between two sets for which it holds. The
first set is approached from the same body without a contact, whose force is zero.

The reserve R is an energy tank (Franken, Stramigioli, Misra, Secchi, Macchelli: "Bilateral telemanipulation with time
delays: a two-layer approach combining passivity and transparency", IEEE Trans. Robotics 27(4), 2011). What a model with
fixed, passive numbers is given and does not hold, it has burnt; if updates add no more than that, the hand never gets
out more than it has put in. On updates in model-mediated teleoperation: Xu, Cizmeci, Schuwerk, Steinbach,
"Model-mediated teleoperation: toward stable and transparent teleoperation systems", IEEE Access 4, 2016.

That holds while the model is passive, and with a velocity that is dead or wrong it is not: its damper pushes. But
what the hand has put in, -sum F dx, is known from its positions, and what it may take out in the next tick is bounded
by its last step and by what it can accelerate. The force is scaled down to what is left for that: time-domain
passivity control (Hannaford, Ryu: "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics and
Automation 18(1), 2002) by a gain instead of a damper, which would need the velocity.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Final, get_args

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput, check_number
from mmt_drake.model.energy import stored_energy
from mmt_drake.model.flexible_box import force_on_probe
from mmt_drake.model.parameters import B1, B2, FD, FS, K1, K2, LAWS, MAX_STEP, NORMAL_B, NORMAL_K, VD, InPlane, M
from mmt_drake.model.plane_call import planar
from mmt_drake.numeric.arrays import Array, assign, fixed_tuple
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Checked, Quantity, Time
from mmt_drake.rendering.laws import add_laws, bend, laws_apart, move_laws, soften_laws
from mmt_drake.told_laws import VECTOR_SIZE, silence, sound, step_with_laws


@dataclass(frozen=True)
class AtOnce:
    """The latest set is rendered as it comes."""

    name = "at_once"


@dataclass(frozen=True)
class RateLimited(Checked):
    """An update changes the force at a limited rate.

    Attributes:
        rate: the fastest change of the force that updates make [N/s], > 0.

    Raises:
        BadInput: a rate outside this range.
    """

    rate: Annotated[float, Quantity("N/s", positive=True)] = 5.0
    name = "rate_limited"
    CALLED: ClassVar = "updates"


@dataclass(frozen=True)
class Blended(Checked):
    """The rendered numbers follow the latest ones with a lag of first order.

    Attributes:
        time: time constant [s], > 0.

    Raises:
        BadInput: a time outside this range.
    """

    time: Time = 0.1
    name = "blended"
    CALLED: ClassVar = "updates"


@dataclass(frozen=True)
class EnergyPermitting(Checked):
    """No update adds more energy than the model has burnt before, nor changes the force faster than at a rate.

    Numbers that the estimator is not sure of are taken up more slowly: before it has told them, and where its model
    does not explain the force or the object is another one (`model_status`).

    What a touch that is reported late would add is held back in the same way. A negative stiffness or damping, which
    makes energy out of nothing, counts as 0. The hand never gets out more energy than it has put in, whatever
    parameters, contact and velocity say, as long as its positions are right and it accelerates by `HAND_ACCELERATION`
    at most. While its position is not finite and the force is let go (`finite`), nobody knows what it takes: it counts
    as moving straight to where it is seen next.

    Attributes:
        reserve: the most that is kept of what was burnt [J], > 0. A small reserve holds back more; a large one lets
            what was burnt long ago hide what is added now.
        rate: the fastest change of the force that updates make [N/s], > 0.
        unsure_rate: the same while the estimator is not sure of what it says [N/s], > 0; more than `rate` is `rate`.

    Raises:
        BadInput: a number outside these ranges.
    """

    reserve: Annotated[float, Quantity("J", positive=True)] = 0.05
    rate: Annotated[float, Quantity("N/s", positive=True)] = 50.0
    unsure_rate: Annotated[float, Quantity("N/s", positive=True)] = 30.0
    name = "energy_permitting"
    CALLED: ClassVar = "updates"

    @property
    def while_unsure(self) -> "EnergyPermitting":
        """The policy while the estimator is not sure."""
        return replace(self, rate=min(self.rate, self.unsure_rate))


Policy = AtOnce | RateLimited | Blended | EnergyPermitting

HAND_ACCELERATION: Final = 50.0
"""What no hand exceeds [m/s^2]."""
_OVERDRAFT: Final = 5e-6
"""Energy [J] without which no touch could begin: a force has to be there before the hand can work against it."""
_AHEAD: Final = 0.01
"""Time [s] for which the energy has to last at the present power, so that it runs out gently."""

# What an update may make felt; the rest of a kernel vector is zero in a renderer.
_HOLDING_ENERGY = (M, K1, K2, NORMAL_K)
_BURNING_ENERGY = (B1, B2, NORMAL_B, FS, FD, VD)
_NUMBERS = _HOLDING_ENERGY + _BURNING_ENERGY
_ALIKE = 1e-6  # of each number
# Where the force is not linear in the share, a share that would change it too much is tried again, shorter.
TRIES, SHORTER, ROUNDING = 20, 0.9, 1.0 + 1e-9


# A rule, a policy in the form that the compiled step takes: a vector, since a named tuple costs it a microsecond.
_next = Layout()
SHARE = _next()  # of the way that is made in a tick
CHANGE = _next()  # of the force at most that an update makes in a tick [N]
RESERVE = _next()  # at most [J]; 0: nobody asks for energy
STRAY = _next()  # by how much a hand's next step may differ from its last [m]
TICKS_AHEAD = _next()  # for which the energy has to last
LONGEST_STEP = _next()  # upper bound on the integration step [s]
IN_PLANE = _next()  # of friction: `Constants.planar` of the kernel vector


def rule(policy: Policy, period: float, max_step: float, in_plane: InPlane = "vector") -> Array:
    """A policy's rule (7,) for ticks of a period [s], steps of at most `max_step` [s] and friction in the plane."""
    share = -math.expm1(-period / policy.time) if isinstance(policy, Blended) else 1.0
    change = policy.rate * period if isinstance(policy, RateLimited | EnergyPermitting) else math.inf
    reserve = policy.reserve if isinstance(policy, EnergyPermitting) else 0.0
    ahead = HAND_ACCELERATION * period**2, max(_AHEAD / period, 1.0)
    return np.array([share, change, reserve, *ahead, max_step, planar(in_plane)])


def renderer_rule(policy: Policy | None, period: float, substeps: int, in_plane: InPlane = "vector") -> Array:
    """The rule of a policy, at once by default, for a period of ticks [s] and so many steps in each at least.

    Raises:
        BadInput: a period that is not positive or less than one substep; no such friction.
    """
    if in_plane not in get_args(InPlane):
        raise BadInput("renderer", at="in_plane", found=in_plane, expected=f"one of {', '.join(get_args(InPlane))}")
    check_number("renderer", "period", period, least=0.0, open_interval=True)
    if not (isinstance(substeps, int) and substeps >= 1):
        raise BadInput("renderer", at="substeps", found=substeps, expected="a whole number >= 1")
    # The margin keeps rounding from adding a substep.
    return rule(policy or AtOnce(), period, period / substeps * (1.0 + 1e-9), in_plane)


def renderer_rules(
    policy: Policy | None, period: float, substeps: int, in_plane: InPlane = "vector"
) -> tuple[Array, Array]:
    """`renderer_rule` while the estimator is sure of what it says, and while it is not.

    Raises:
        BadInput: as there.
    """
    unsure = policy.while_unsure if isinstance(policy, EnergyPermitting) else policy
    return renderer_rule(policy, period, substeps, in_plane), renderer_rule(unsure, period, substeps, in_plane)


@njit(cache=True)
def without_contact(target: Array, p: Array) -> None:
    """Make `p` the body of a model, (VECTOR_SIZE,) each, that nothing connects with the probe, without its laws."""
    assign(p, target)
    p[K2] = p[B2] = p[NORMAL_K] = p[NORMAL_B] = 0.0
    soften_laws(p, 0.0)


@njit(cache=True)
def make_passive(p: Array) -> None:
    """Make a kernel vector one that holds and burns energy, and makes none."""
    for i in (K1, K2, NORMAL_K, B1, B2, NORMAL_B):
        p[i] = max(p[i], 0.0)


@njit(cache=True)
def account(state: Array, p: Array, before: float, reserve: float, rule: Array) -> float:
    """The reserve [J] after a tick in which nothing was updated.

    A touch that is reported late finds the normal spring compressed, with energy that nobody put in; and a spring whose
    force is held from tick to tick gives back a little more than it takes. Where the reserve does not cover that, the
    contact's springs are softened.

    Args:
        state, p: of the object now; p changes where its springs are softened.
        before: stored energy at the last tick [J].
        reserve: at the last tick, with what the hand has put in since [J].
        rule: of the policy.
    """
    after = stored_energy(state, p)
    reserve = min(reserve - (after - before), rule[RESERVE])
    if reserve < 0.0:
        k2, normal_k, laws = p[K2], p[NORMAL_K], silence(p)
        p[K2] = p[NORMAL_K] = 0.0
        in_springs = after - stored_energy(state, p)
        softer = max(1.0 + reserve / in_springs, 0.0) if in_springs > 0.0 else 1.0
        p[K2], p[NORMAL_K] = softer * k2, softer * normal_k
        sound(p, laws)
        soften_laws(p, softer)
        reserve += (1.0 - softer) * in_springs
    return reserve


@njit(cache=True)
def share_within(change: float, limit: float) -> float:
    """Share of the way that can be gone where all of it would make a change, and this one is allowed."""
    return 1.0 if change <= limit else limit / change


@njit(cache=True)
def _alike(p: Array, target: Array) -> bool:
    """True where two kernel vectors are so near to each other that no hand could notice."""
    apart = 0.0
    for i in _NUMBERS:
        apart = max(apart, abs(target[i] - p[i]) - _ALIKE * abs(target[i]))
    return apart <= 0.0 and not laws_apart(p, target, _ALIKE)


@njit(cache=True)
def take_up(state: Array, p: Array, target: Array, reserve: float, rule: Array, force: Array) -> tuple[float, float]:
    """Move p a share of the way to the latest set, in place.

    Args:
        state: of the object.
        p, target: kernel vectors, (VECTOR_SIZE,), of what is rendered and of the latest set, with the same laws
            (`laws.align`).
        reserve: energy that may be added [J]; only for that policy.
        rule: of the policy.
        force: (3,) scratch.

    Returns:
        The share of the way, and the reserve that is left [J].
    """
    share = 1.0 if rule[SHARE] == 1.0 or _alike(p, target) else rule[SHARE]
    before, added, paid = 0.0, 0.0, 1.0
    if rule[RESERVE] > 0.0:
        before = stored_energy(state, p)
        added = stored_energy(state, target) - before
        paid = share_within(added, max(reserve, 0.0))
    if math.isfinite(rule[CHANGE]):
        share = share_within(_change(state, p, target, paid, force), rule[CHANGE])
    left = reserve - share * paid * added
    bends = bend(p) or bend(target)
    if not bends or not math.isfinite(rule[CHANGE]):
        _move(p, target, share, paid)
    else:
        share = _move_within(state, p, target, share, paid, rule[CHANGE], force)
    if bends and rule[RESERVE] > 0.0:
        # Between two sets of its numbers the energy of a law need not grow linearly.
        left = reserve - (stored_energy(state, p) - before)
    p[MAX_STEP] = min(rule[LONGEST_STEP], step_with_laws(p))
    return share * paid, min(left, rule[RESERVE])


@njit(cache=True)
def _move(p: Array, target: Array, share: float, paid: float) -> None:
    """Move p a share of the way to the target, and what holds energy no more than is paid of that."""
    for i in _HOLDING_ENERGY:
        p[i] = target[i] if share * paid == 1.0 else p[i] + share * paid * (target[i] - p[i])
    for i in _BURNING_ENERGY:  # what a law takes the place of goes no faster than that enters
        part = share * paid if target[i] == 0.0 and target[LAWS] != 0.0 else share
        p[i] = target[i] if part == 1.0 else p[i] + part * (target[i] - p[i])
    if bend(p) or bend(target):
        move_laws(p, target, share * paid)


@njit(cache=True)
def _move_within(state: Array, p: Array, target: Array, share: float, paid: float, most: float, force: Array) -> float:
    """`_move` with laws, which may bend within the way: no farther than to where the force has changed by `most` [N].

    Returns:
        The share that was gone.
    """
    force_on_probe(state, p, force)
    x, y, z, was = force[0], force[1], force[2], fixed_tuple(p, VECTOR_SIZE)
    for _ in range(TRIES):
        _move(p, target, share, paid)
        force_on_probe(state, p, force)
        change = math.sqrt((force[0] - x) ** 2 + (force[1] - y) ** 2 + (force[2] - z) ** 2)
        if change <= most * ROUNDING:
            return share
        for i in range(VECTOR_SIZE):
            p[i] = was[i]
        share *= SHORTER * most / change
    return 0.0


@njit(cache=True)
def _change(state: Array, p: Array, target: Array, paid: float, force: Array) -> float:
    """By how much the force would change [N] with the target's dampers, and springs that share of the way to its."""
    force_on_probe(state, p, force)
    x, y, z = force[0], force[1], force[2]
    if paid < 1.0:  # the force is linear in springs and dampers
        k2, normal_k = p[K2], p[NORMAL_K]
        p[K2], p[NORMAL_K] = k2 + paid * (target[K2] - k2), normal_k + paid * (target[NORMAL_K] - normal_k)
        b2, normal_b = p[B2], p[NORMAL_B]
        p[B2], p[NORMAL_B] = target[B2], target[NORMAL_B]
        force_on_probe(state, p, force)
        p[K2], p[NORMAL_K], p[B2], p[NORMAL_B] = k2, normal_k, b2, normal_b
        if bend(p) or bend(target):
            add_laws(state, p, -paid, force)
            add_laws(state, target, paid, force)
    else:
        force_on_probe(state, target, force)
    return math.sqrt((force[0] - x) ** 2 + (force[1] - y) ** 2 + (force[2] - z) ** 2)


@njit(cache=True)
def covered(force: Array, taken: float, ticks: float, energy: float, rule: Array) -> float:
    """The share of a force that the hand may feel until the next tick.

    Args:
        force: (3,) on the hand [N].
        taken: energy that it takes out with all of it, if it moves as in the last tick that is known [J].
        ticks: since then, in which it may have become faster.
        energy: that it has put in and not got back [J].
        rule: of the policy.
    """
    taken *= rule[TICKS_AHEAD] if taken > 0.0 else 1.0
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    return share_within(taken + ticks * size * rule[STRAY], max(energy + _OVERDRAFT, 0.0))
