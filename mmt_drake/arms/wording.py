"""A diagnosis of an arm in words."""

from __future__ import annotations

from collections.abc import Iterable

from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.result import ArmDiagnosis, ArmEffectFound, Number
from mmt_drake.diagnosis.tell.summary import untried_of
from mmt_drake.effects.wording import words

_LISTED = 4


def summary(diagnosis: ArmDiagnosis) -> str:
    """What was found, in a paragraph that a person can act on, and what goes with it."""
    return " ".join([found(diagnosis), *diagnosis.notes])


def found(diagnosis: ArmDiagnosis) -> str:
    """The same without the notes."""
    moving = [joint for joint in diagnosis.joints if joint.budget]
    before, after = (
        (sum(getattr(joint, name) ** 2 for joint in moving) / max(len(moving), 1)) ** 0.5
        for name in ("nominal", "augmented")
    )
    said = [_VERDICTS[diagnosis.verdict]]
    sure = [effect for effect in diagnosis.effects if effect.certain]
    named = {effect.where for effect in sure}
    for name in dict.fromkeys(effect.name for effect in sure):
        same = [effect for effect in sure if effect.name == name]
        said.append(_named(same, len(moving)))
    if diagnosis.parameters:
        links = _listed(list(diagnosis.parameters))
        if diagnosis.verdict in ("parameters", "missing_physics"):
            said.append(f"Inertial numbers of {links} are others than the file says.")
        else:
            said.append(f"Inertial numbers of {links} were fitted too: they may stand for what has no name.")
    for place in diagnosis.places:
        if place not in named:
            here = [e for e in diagnosis.effects if e.where == place]
            laws = dict.fromkeys(words(name) for e in here for name in (e.name, *e.instead))
            said.append(f"On {place} something is missing for sure, and this motion does not tell what: {_or(laws)}.")
    unsure = [e for e in diagnosis.effects if not e.certain and (e.where not in diagnosis.places or e.where in named)]
    if unsure:
        them = _listed([f"{words(e.name)} on {e.where or 'the whole arm'}" for e in unsure])
        said.append(f"In the model that is delivered, but not sure: {them}.")
    said.append(
        f"Error of the torque on stretches that were not fitted, in parts of its spread: {before:.3g} with the model "
        f"handed in, {after:.3g} with what was found."
    )
    return " ".join(part for part in (*said, untried_of(diagnosis.untried)) if part)


def headline(diagnosis: ArmDiagnosis) -> str:
    """The verdict in a sentence."""
    sure = list(dict.fromkeys(words(effect.name) for effect in diagnosis.effects if effect.certain))
    return f"{_VERDICTS[diagnosis.verdict].rstrip('.')}: {_listed(sure)}" if sure else _VERDICTS[diagnosis.verdict]


_VERDICTS = {
    "no_mismatch": "The model explains the torques to their noise.",
    "parameters": "The structure is right, inertial numbers were not.",
    "missing_physics": "Physics is missing, and named.",
    "partly_explained": "Physics is missing; part of it is named.",
    "ambiguous": "Physics is missing, and this motion does not tell which law it is.",
    "unexplained": "Something is missing that no effect explains.",
}


def _named(same: list[ArmEffectFound], moving: int) -> str:
    first = same[0]
    title = words(first.name)[0].upper() + words(first.name)[1:]
    where = "on every joint that moves" if len(same) == moving > 1 else f"on {_listed([e.where for e in same])}"
    numbers = f" ({told(first)})" if len(same) == 1 else ""
    sure = {str(effect.certain) for effect in same}
    depth = f"; certain is the {sure.pop()}" if len(sure) == 1 else ""
    return f"{title} {where if first.where else 'of the whole arm'}{numbers}{depth}."


def told(effect: ArmEffectFound) -> str:
    """An effect's numbers: `Fc = 13.9 N m`."""
    parts = []
    for symbol, number in effect.numbers.items():
        if symbol in ARM_EFFECTS[effect.name].optional:
            continue  # the report has them
        if isinstance(number, Number):
            parts.append(f"{symbol} = {number.value:.3g}" + (f" {number.unit}" if number.unit != "1" else ""))
        else:
            parts.append(f"with {number}")
    return ", ".join(parts)


def _or(names: Iterable[str]) -> str:
    every = list(names)
    return f"{', '.join(every[:-1])} or {every[-1]}" if len(every) > 1 else every[0]


def _listed(names: list[str]) -> str:
    shown = names[:_LISTED]
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(shown) + more
