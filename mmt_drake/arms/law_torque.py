"""The torque that laws of the library take from a joint: of friction, drag, springs and ripples."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numba import njit

from mmt_drake.arms.joint_motion import JointMotion
from mmt_drake.effects import LIBRARY, Effect
from mmt_drake.model.law_table import call_law
from mmt_drake.model.laws import LAW_PARAMETERS, At, Slot
from mmt_drake.numeric.arrays import Array


@njit(cache=True, error_model="numpy")
def _along(
    address: int,
    levels: bool,
    step: float,
    q: Array,
    v: Array,
    load: Array,
    rest: float,
    p: tuple[float, ...],
    out: Array,
) -> None:
    """The torque that a law takes from a joint (n,), into `out`.

    Args:
        address: of the law's machine code.
        levels: whether it tells the level of friction, not a force.
        step: sampling interval [s].
        q, v: (n,) position and velocity.
        load: (n,) what friction grows with.
        rest: a joint slower than this turns over from one direction to the other.
        p: its numbers.
        out: (n,).
    """
    z = 0.0
    for i in range(len(v)):
        direction = min(1.0, max(-1.0, v[i] / rest))
        side = math.copysign(1.0, direction)
        at = At(i * step, q[i], v[i], q[i], v[i], load[i], side, 0.0, 0.0, step, 0.0, 0.0, 0.0)
        force, z_rate, _, slip = call_law(address, at, (z, 0.0, 0.0, 0.0), p)
        out[i] = abs(direction) * side * force if levels else -force
        # Exact for a law that decays evenly over a sample.
        z += z_rate * (step if slip * step < 1e-9 else -math.expm1(-slip * step) / slip)


def along(name: str, motion: JointMotion, numbers: Mapping[str, float]) -> Array:
    """The torque that a drive has to give against a law of the library (n,).

    Args:
        name: of the law.
        motion: of the joint.
        numbers: of the effect and, of the structure, those that it reads, by symbol.
    """
    effect = LIBRARY[name]
    law = effect.law
    if law is None:  # one number of the structure, which it adds to
        (value,) = numbers.values()
        carried = {"Fc": motion.direction, "b": motion.v, "k": motion.q}[str(effect.adds_to)]
        return value * carried
    own = _numbers(effect, numbers)
    p = (*own, *[0.0] * (LAW_PARAMETERS - len(own)))
    out = np.empty(len(motion.v))
    levels = law.slot == Slot.FRICTION
    _along(law.address, levels, motion.step, motion.q, motion.v, motion.load, motion.rest, p, out)
    return out


def _numbers(effect: Effect, numbers: Mapping[str, float]) -> tuple[float, ...]:
    """What a law reads: its effect's numbers, then those of the structure; a joint has a gain of 1, and 0 of others."""
    uses = {"gain": 1.0, **numbers}
    return (*(numbers[p.symbol] for p in effect.parameters), *(uses.get(symbol, 0.0) for symbol in effect.uses))


def instant(
    name: str, numbers: Mapping[str, float], q: float, v: float, load: float, z: float, rest: float
) -> tuple[float, float]:
    """The torque that an effect takes from a joint now [N m], and the rate of its memory.

    Args:
        name: of an effect of the library.
        numbers: all of it, by symbol.
        q, v: position and velocity of the joint.
        load: what friction may grow with [N m].
        z: its memory.
        rest: a joint slower than this turns over from one direction to the other.
    """
    effect = LIBRARY[name]
    direction = min(1.0, max(-1.0, v / rest))
    if name == "static_friction":
        return direction * numbers["Fs" if abs(v) < numbers["v_d"] else "Fd"], 0.0
    if effect.law is None:
        (value,) = numbers.values()
        return value * {"Fc": direction, "b": v, "k": q}[str(effect.adds_to)], 0.0
    side = math.copysign(1.0, direction)
    at = At(0.0, q, v, q, v, load, side, 0.0, 0.0, 0.0)
    result = effect.law(at, (z, 0.0, 0.0, 0.0), _numbers(effect, numbers))
    if effect.law.slot == Slot.FRICTION:
        return abs(direction) * side * result[0], 0.0
    return -result[0], result[1]
