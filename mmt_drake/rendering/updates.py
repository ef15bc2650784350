"""Policies by which a model that is being felt takes up parameters that arrive.

The object's motion carries over, but its force and its energy change with the numbers. Let p be what is rendered and p*
the latest set. In every tick p moves a share s of the way to p*, and a policy says which:

- at once: s = 1. The force jumps by dF = F(p*) - F(p), and the energy in store by dE = E(p*) - E(p).
- rate-limited: s = min(1, r T / |dF|) for a rate r [N/s] and a period T; dF grows linearly with s.
- blended: s = 1 - exp(-T / tau).
- as energy permits: s = min(1, R / dE) where dE > 0, R being energy that the model has burnt and the hand was not given
  back; dE grows linearly with s too. Dampers and friction hold no energy and are taken up at once.

Every p on the way is stable: that m, b1 + b2 and k1 + k2 are positive holds between two sets for which it holds. The
first set is approached from the same body without a contact, whose force is zero.

The reserve R is an energy tank (Franken, Stramigioli, Misra, Secchi, Macchelli: "Bilateral telemanipulation with time
delays: a two-layer approach combining passivity and transparency", IEEE Trans. Robotics 27(4), 2011). What a model with
fixed, passive numbers is given and does not hold, it has burnt; if updates add no more than that, the hand never gets
out more than it has put in. On updates in model-mediated teleoperation: Xu, Cizmeci, Schuwerk, Steinbach,
"Model-mediated teleoperation: toward stable and transparent teleoperation systems", IEEE Access 4, 2016.
"""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, get_args

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput, check_number
from mmt_drake.model.flexible_box import force_on_probe, stored_energy
from mmt_drake.model.parameters import (
    B1,
    B2,
    FD,
    FS,
    K1,
    K2,
    MAX_STEP,
    NORMAL_B,
    NORMAL_K,
    VD,
    InPlane,
    M,
    accurate_step,
)
from mmt_drake.model.plane_call import planar
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Checked, Quantity, Time


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
    """No update adds more energy than the model has burnt before.

    What a touch that is reported late would add is held back in the same way. A negative stiffness or damping, which
    makes energy out of nothing, counts as 0. While the hand's position is not finite and the force is let go
    (`finite`), nobody knows what it takes: it counts as moving straight to where it is seen next.

    Attributes:
        reserve: the most that is kept of what was burnt [J], > 0. A small reserve holds back more; a large one lets
            what was burnt long ago hide what is added now.

    Raises:
        BadInput: a reserve outside this range.
    """

    reserve: Annotated[float, Quantity("J", positive=True)] = 0.05
    name = "energy_permitting"
    CALLED: ClassVar = "updates"


Policy = AtOnce | RateLimited | Blended | EnergyPermitting

_AT_ONCE, RATE_LIMITED, BLENDED, ENERGY_PERMITTING = range(4)

# What an update may make felt; the rest of a kernel vector is zero in a renderer.
_HOLDING_ENERGY = (M, K1, K2, NORMAL_K)
_BURNING_ENERGY = (B1, B2, NORMAL_B, FS, FD, VD)
_NUMBERS = _HOLDING_ENERGY + _BURNING_ENERGY
_ALIKE = 1e-6  # of each number


# A rule, a policy in the form that the compiled step takes: a vector, since a named tuple costs it a microsecond.
_next = Layout()
KIND = _next()  # of the policy
AMOUNT = _next()  # its number: the change of force [N] in a period, the share of the way, or the reserve [J]
LONGEST_STEP = _next()  # upper bound on the integration step [s]
IN_PLANE = _next()  # of friction: `Constants.planar` of the kernel vector


def rule(policy: Policy, period: float, max_step: float, in_plane: InPlane = "per_axis") -> Array:
    """A policy's rule (4,) for ticks of a period [s], steps of at most `max_step` [s] and friction in the plane."""
    further = max_step, planar(in_plane)
    if isinstance(policy, RateLimited):
        return np.array([RATE_LIMITED, policy.rate * period, *further])
    if isinstance(policy, Blended):
        return np.array([BLENDED, -math.expm1(-period / policy.time), *further])
    if isinstance(policy, EnergyPermitting):
        return np.array([ENERGY_PERMITTING, policy.reserve, *further])
    return np.array([_AT_ONCE, 0.0, *further])


def renderer_rule(policy: Policy | None, period: float, substeps: int, in_plane: InPlane = "per_axis") -> Array:
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


@njit(cache=True)
def without_contact(target: Array, p: Array) -> None:
    """Make `p` the body of a model, (KERNEL_SIZE,) each, that nothing connects with the probe."""
    assign(p, target)
    p[K2] = p[B2] = p[NORMAL_K] = p[NORMAL_B] = 0.0


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
    reserve = min(reserve - (after - before), rule[AMOUNT])
    if reserve < 0.0:
        k2, normal_k = p[K2], p[NORMAL_K]
        p[K2] = p[NORMAL_K] = 0.0
        in_springs = after - stored_energy(state, p)
        softer = max(1.0 + reserve / in_springs, 0.0) if in_springs > 0.0 else 1.0
        p[K2], p[NORMAL_K] = softer * k2, softer * normal_k
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
    return apart <= 0.0


@njit(cache=True)
def take_up(state: Array, p: Array, target: Array, reserve: float, rule: Array, force: Array) -> tuple[float, float]:
    """Move p a share of the way to the latest set, in place.

    Args:
        state: of the object.
        p, target: kernel vectors, (KERNEL_SIZE,), of what is rendered and of the latest set.
        reserve: energy that may be added [J]; only for that policy.
        rule: of the policy.
        force: (3,) scratch.

    Returns:
        The share of the way, and the reserve that is left [J].
    """
    share = 1.0
    if rule[KIND] == RATE_LIMITED:
        force_on_probe(state, p, force)
        x, y, z = force[0], force[1], force[2]
        force_on_probe(state, target, force)
        jump = math.sqrt((force[0] - x) ** 2 + (force[1] - y) ** 2 + (force[2] - z) ** 2)
        share = share_within(jump, rule[AMOUNT])
    elif rule[KIND] == BLENDED:
        share = 1.0 if _alike(p, target) else rule[AMOUNT]
    elif rule[KIND] == ENERGY_PERMITTING:
        added = stored_energy(state, target) - stored_energy(state, p)
        share = share_within(added, max(reserve, 0.0))
        reserve = min(reserve - share * added, rule[AMOUNT])
    for i in _HOLDING_ENERGY:
        p[i] = target[i] if share == 1.0 else p[i] + share * (target[i] - p[i])
    burning = 1.0 if rule[KIND] == ENERGY_PERMITTING else share
    for i in _BURNING_ENERGY:
        p[i] = target[i] if burning == 1.0 else p[i] + burning * (target[i] - p[i])
    p[MAX_STEP] = min(rule[LONGEST_STEP], accurate_step(p[M], p[K1], p[K2], p[B1], p[B2]))
    return share, reserve
