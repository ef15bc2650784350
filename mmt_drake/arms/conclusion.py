"""What a diagnosis of an arm comes to: budget, verdict and notes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mmt_drake.arms.beliefs import Believed
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.problem import ArmProblem
from mmt_drake.arms.result import ArmEffectFound, JointReport
from mmt_drake.diagnosis.decide.budget import NAMELESS, NOISE, PARAMETERS, SHARED, BudgetPart
from mmt_drake.effects.wording import words

EXPLAINED = 0.02
"""Of the mismatch may be nameless where it is said to be explained ..."""
MOST_LEFT = 0.3
"""... and no joint leaves more than this part of its torque's spread, however far the model was off ..."""
PARTLY = 0.2
"""... and what has names takes at least this part of it, where it is said to be so in part."""
UNTOLD = 0.1
"""Where no more than this is nameless, but most of it could be one law or another, the answer is ambiguous."""
NEAR_ENOUGH = 0.03
"""A model for which nothing is found, and which is off by no more than this part of the torque's spread on most joints,
has nothing missing that shows: smooth motion blurs every reversal."""
FAR = 0.1
"""... unless it is off by more than this part on one joint."""
NOTHING_SHOWS = 1.5
"""A model that leaves no more than so many times the noise of the torque, in RMS, has nothing missing that shows."""


def whole_budget(joints: Sequence[JointReport]) -> tuple[BudgetPart, ...]:
    """The mean of the joints' budgets, each weighed by its nominal error over its spread, squared."""
    shares: dict[str, float] = {}
    moving = [joint for joint in joints if joint.budget]
    total = sum(joint.nominal**2 for joint in moving)
    for joint in moving:
        for part in joint.budget:
            shares[part.part] = shares.get(part.part, 0.0) + part.share * joint.nominal**2 / total
    last = (SHARED, NAMELESS, NOISE)
    names = sorted(shares, key=lambda name: (name in last and last.index(name) + 1, -shares[name]))
    return tuple(BudgetPart(name, shares[name]) for name in names)


def verdict_of(
    found: Believed, joints: Sequence[JointReport], effects: Sequence[ArmEffectFound], budget: Sequence[BudgetPart]
) -> str:
    """What may be said of the model handed in.

    Args:
        found: what is delivered.
        joints: what is left of each.
        effects: that were found in the torque.
        budget: of all joints.
    """
    shares = {part.part: part.share for part in budget}
    moving = [joint for joint in joints if joint.budget]
    named = sum(share for name, share in shares.items() if name not in (PARAMETERS, SHARED, NAMELESS, NOISE))
    if all(joint.nominal <= NOTHING_SHOWS * max(joint.noise, 1e-9) for joint in moving):
        return "no_mismatch"
    is_told = any(effect.certain for effect in effects) or found.fit.belief.name == "refit"
    off = [joint.nominal for joint in moving]
    if not is_told and np.median(off) <= NEAR_ENOUGH and max(off) <= FAR:
        return "no_mismatch"
    nameless, shared = shares.get(NAMELESS, 0.0), shares.get(SHARED, 0.0)
    if shared > named and nameless <= UNTOLD:
        return "ambiguous"
    if any(effect.certain for effect in effects):
        if nameless + shared <= EXPLAINED and max(joint.augmented for joint in moving) <= MOST_LEFT:
            return "missing_physics"
        left = named + shared + nameless
        return "partly_explained" if named >= PARTLY or named >= 0.5 * left else "unexplained"
    if found.fit.belief.name == "refit" and shares.get(PARAMETERS, 0.0) >= 1.0 - PARTLY:
        return "parameters"
    return "unexplained"


def with_look_alikes(effects: Sequence[ArmEffectFound], problem: ArmProblem) -> tuple[ArmEffectFound, ...]:
    """Effects, those that are sure with what looks like them where they are.

    Args:
        effects: that were found.
        problem: the logs.
    """
    gained = {effect.where for effect in effects if effect.name == "torque_gain" and effect.certain}
    every = gained == {problem.arm.joints[j] for j in problem.moving}
    told = []
    for effect in effects:
        applies = {"torque_gain": every, "rotor_inertia": effect.where == problem.arm.joints[0]}
        alike = tuple(ARM_EFFECTS[effect.name].near_equal) if applies.get(effect.name, True) else ()
        told.append(replace(effect, looks_like=alike if effect.certain else ()))
    return tuple(told)


def notes_of(
    found: Believed, problem: ArmProblem, effects: Sequence[ArmEffectFound], factor: Sequence[float] = ()
) -> tuple[str, ...]:
    """What looks alike, and what was not told.

    Args:
        found: what is delivered.
        problem: the logs.
        effects: that were found.
        factor: torque for one unit of the log's, where the model has one.
    """
    notes = []
    if factor and any(effect.name == "payload" for effect in effects):
        notes.append("The payload's mass is as right as `torque: factor`: gains that are 1 % off make it 1 % off.")
    if found.fit.belief.name == "refit":
        notes.append("Inertial numbers of all links scaled, and a gain of every torque, look alike: one is as good.")
    alike: dict[tuple[str, str], list[str]] = {}
    for effect in effects:
        for other in effect.looks_like:
            alike.setdefault((effect.name, other), []).append(effect.where)
    for (effect_name, other), places in alike.items():
        name = words(effect_name) + (f" of {', '.join(places)}" if all(places) else "")
        where = ARM_EFFECTS[effect_name].near_equal[other]
        notes.append(f"{name[0].upper()}{name[1:]} looks like {words(other)} {where}.")
    still = [problem.arm.joints[j] for j in range(len(problem.rows)) if j not in problem.moving]
    if still:
        notes.append(f"Joints that did not move, and of which nothing is told: {', '.join(still)}.")
    return tuple(notes)
