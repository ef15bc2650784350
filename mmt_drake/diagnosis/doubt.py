"""What a model file gives is believed first: when to doubt it, and when the answer without it is the better one.

The moment of gravity on a pendulum is known from elsewhere. Where it is wrong, forces of the position stand for that.
"""

import math
from typing import Final

from mmt_drake.diagnosis.decide.verdict import NAMING
from mmt_drake.diagnosis.tell.outcome import Outcome

_OF_POSITION: Final = frozenset(("body_force", "contact_stiffness"))
"""Families of which an effect may be what a wrong moment of gravity leaves: it depends on the position alone."""
_MUCH_LESS, _AS_LITTLE = 0.5, 1.25
"""Of the variance that the other answer leaves beyond the noise: what is much less, and what is as little ..."""
_NOISE = 0.5
"""... and so is what is no more than this part of the noise beyond it."""


def is_doubtful(found: Outcome) -> bool:
    """Whether nothing is named, or what a wrong moment of gravity would draw."""
    return not found.diagnosis.effects or _names_a_force_of_position(found)


def is_better(again: Outcome, found: Outcome) -> bool:
    """Whether a diagnosis to which nothing was given is the better one of the same recordings.

    It names something, and leaves much less on held-out data, or as little with fewer of the other's effects. Where
    nothing was named before no force of the position is now: with gravity free as well, two of these draw nearly
    anything.

    Args:
        again: the diagnosis with what is given free.
        found: the one with it as it is given.
    """
    own, others = again.diagnosis.fit, found.diagnosis.fit
    if own is None or others is None or again.diagnosis.verdict not in NAMING:
        return False
    if not found.diagnosis.effects and _names_a_force_of_position(again):
        return False
    floor = own.noise_floor or 0.0
    errors = own.heldout_nrmse.augmented, others.heldout_nrmse.augmented
    left, before = (math.inf if e is None else max(e**2 - floor**2, 0.0) for e in errors)
    names, theirs = ({effect.name for effect in outcome.diagnosis.effects} for outcome in (again, found))
    return left <= _MUCH_LESS * before or (names < theirs and left <= max(_AS_LITTLE * before, (_NOISE * floor) ** 2))


def _names_a_force_of_position(outcome: Outcome) -> bool:
    return any(effect.family in _OF_POSITION for effect in outcome.diagnosis.effects)
