"""The answer of a diagnosis of an arm, and its document."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.base_parameters import BaseParameters
from mmt_drake.arms.forward import WINDOW_S, ForwardErrors
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.verdict import LEAVES
from mmt_drake.diagnosis.decide.budget import NAMELESS, SHARED, BudgetPart
from mmt_drake.plain import plain

STANDS_OUT = 8.0
"""Where something is missing is sure if what takes part there takes so many times what nobody has named."""


@dataclass(frozen=True)
class Number:
    """A number with its 95 % interval."""

    value: float
    unit: str
    ci95: tuple[float, float] | None = None


@dataclass(frozen=True)
class ArmEffectFound:
    """An effect that was found.

    Attributes:
        name, family, block: of the effect.
        where: joint or link; empty: the whole arm.
        certain: to which depth its name holds; None: it takes part, but others explain as much.
        numbers: by symbol; a joint stands by its name.
        share: of the mismatch of its joint, or of all.
        instead: what would explain as much in its place.
        looks_like: what no log of this kind tells from it, see `ArmEffect.near_equal`.
    """

    name: str
    family: str
    block: str
    where: str
    certain: str | None
    numbers: Mapping[str, Number | str]
    share: float
    instead: tuple[str, ...] = ()
    looks_like: tuple[str, ...] = ()

    def value(self, symbol: str) -> float:
        """One of its numbers."""
        number = self.numbers[symbol]
        assert isinstance(number, Number)  # a joint's name is asked of `numbers`
        return number.value


@dataclass(frozen=True)
class JointReport:
    """One joint.

    Attributes:
        name: of the joint.
        moves: whether it did.
        spread: standard deviation of its torque [N m].
        nominal, refit, augmented: RMS error of the torque over its spread, blocks that no choice has seen; `refit` None
            where there was no time for it.
        noise: the same of the noise of the torque.
        budget: whose the mismatch is.
    """

    name: str
    moves: bool
    spread: float
    nominal: float
    refit: float | None
    augmented: float
    noise: float
    budget: tuple[BudgetPart, ...]


@dataclass(frozen=True)
class ArmDiagnosis:
    """What was found of an arm.

    Attributes:
        verdict: as of every diagnosis.
        summary: in a paragraph.
        joints: each of them.
        effects: that were found, sure ones first.
        parameters: of links whose numbers are others: link -> symbol -> number.
        untold: inertial numbers that this motion does not tell, by link.
        budget: of all joints.
        heldout_s: times that report, (start, end, log).
        model: with what was found.
        recordings: logs.
        seconds: it took.
        forward: simulated under the recorded torque over short windows of the first log, with the model handed in and
            with what was found.
        believed: the belief about the links that was taken: none, refit, payload, ...
        notes: sentences that go with it.
        base: what the motion tells of the inertial numbers.
        untried: what there was no time for.
    """

    verdict: str
    summary: str
    joints: tuple[JointReport, ...]
    effects: tuple[ArmEffectFound, ...]
    parameters: Mapping[str, Mapping[str, Number]]
    untold: Mapping[str, tuple[str, ...]]
    budget: tuple[BudgetPart, ...]
    heldout_s: tuple[tuple[float, float, int], ...]
    model: ArmModel
    recordings: tuple[str, ...]
    seconds: float = 0.0
    forward: tuple[ForwardErrors, ForwardErrors] | None = None
    believed: str = "none"
    notes: tuple[str, ...] = field(default=())
    base: BaseParameters | None = None
    untried: tuple[str, ...] = ()

    @property
    def places(self) -> tuple[str, ...]:
        """Joints and links where something is missing for sure, whether or not its law is; empty: the whole arm.

        So it is where a name is sure. It also is on a joint where what is not sure takes far more than what nobody has
        named, and other numbers of the links alone leave more.
        """
        sure = [effect.where for effect in self.effects if effect.certain]
        for joint in self.joints:
            shares = {part.part: part.share for part in joint.budget}
            unsure = any(effect.where == joint.name and not effect.certain for effect in self.effects)
            stands_out = shares.get(SHARED, 0.0) >= STANDS_OUT * shares.get(NAMELESS, 0.0)
            alone = math.inf if joint.refit is None else (joint.refit / max(joint.augmented, 1e-12)) ** 2
            if unsure and stands_out and alone > LEAVES["family"]:
                sure.append(joint.name)
        return tuple(dict.fromkeys(sure))


def as_json(diagnosis: ArmDiagnosis, model: str) -> dict[str, Any]:
    """The document of a diagnosis.

    Args:
        diagnosis: what was found.
        model: name of the file with the augmented model.
    """

    def shares(budget: tuple[BudgetPart, ...]) -> list[dict[str, Any]]:
        return [{"part": part.part, "share": part.share} for part in budget]

    def effect(one: ArmEffectFound) -> dict[str, Any]:
        place = ARM_EFFECTS[one.name].place
        return {
            "name": one.name,
            "family": one.family,
            "block": one.block,
            **({} if place == "arm" else {place: one.where}),
            "certain": one.certain,
            "share": one.share,
            "parameters": one.numbers,
        }

    document: dict[str, Any] = {
        "schema": "mmt_drake.diagnosis/2",
        "structure": "multibody",
        "verdict": diagnosis.verdict,
        "summary": diagnosis.summary,
        "budget": shares(diagnosis.budget),
        "effects": [effect(e) for e in diagnosis.effects if e.certain],
        "unsure": [{**effect(e), "instead": e.instead} for e in diagnosis.effects if not e.certain],
        "alternatives": [
            {"name": name, "where": e.where, "indistinguishable": True, "in_place_of": e.name}
            for e in diagnosis.effects
            for name in (*e.instead, *e.looks_like)
        ],
        "parameters": {
            f"{link}.{symbol}": n for link, some in diagnosis.parameters.items() for symbol, n in some.items()
        },
        "places": diagnosis.places,
        "untold": diagnosis.untold,
        "base_parameters": diagnosis.base.to_data() if diagnosis.base else None,
        "joints": [
            {
                "joint": j.name,
                "moves": j.moves,
                "torque_spread": j.spread,
                "heldout_nrmse": {"nominal": j.nominal, "refit": j.refit, "augmented": j.augmented},
                "noise_floor": j.noise,
                "budget": shares(j.budget),
            }
            for j in diagnosis.joints
        ],
        "forward": _forward(diagnosis),
        "fit": {"heldout_s": [(a, b) for a, b, _ in diagnosis.heldout_s], "band_hz": diagnosis.model.band_hz},
        "untried": diagnosis.untried,
        "notes": diagnosis.notes,
        "recordings": diagnosis.recordings,
        "seconds": diagnosis.seconds,
        "model": model,
    }
    in_words: dict[str, Any] = plain(document)
    return in_words


def _forward(diagnosis: ArmDiagnosis) -> dict[str, Any] | None:
    """RMS of positions simulated over windows, None where a model could not be simulated."""
    if diagnosis.forward is None:
        return None
    before, after = diagnosis.forward
    errors: dict[str, Any] = plain({"nominal": before.rms, "augmented": after.rms}, finite=True)
    return {"window_s": WINDOW_S, "windows": before.windows, "closed_loop": before.closed, "way": before.way, **errors}
