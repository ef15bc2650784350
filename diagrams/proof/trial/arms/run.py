"""The trial of arms from end to end: drawn, sealed, diagnosed, scored."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from mmt_drake.analysis.page import Section
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.arms.arm_file import load_arm_model
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import load_joint_log
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.result import Number
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Report, Study
from mmt_drake.diagrams.proof.trial.arms.cases import EFFECTS, ArmTrialCase, draw_case
from mmt_drake.diagrams.proof.trial.arms.engine import Concealment
from mmt_drake.diagrams.proof.trial.sealing import canonical, seal


@dataclass(frozen=True)
class NamedThing:
    """An effect that was found: name, family, place, and how deep it is certain; None: it is not."""

    name: str
    family: str
    block: str
    where: str
    certain: str | None


@dataclass(frozen=True)
class ArmScore:
    """One case, scored.

    Attributes:
        case: its name.
        truth: names and places.
        named: what was named with certainty.
        unsure: what was found, and is not certain.
        told: places where something is missing for sure.
        verdict: of the diagnosis.
        places, families, laws: concealed effects whose place was told; of which a name in the right family; of the
            right law, called certain; was found at that place.
        called: of the names of a concealed effect's place and family, those called certain to the law.
        false: names that are wrong at the depth called certain.
        mass_off: of a payload, relative; None where none was concealed or found.
        seconds: it took.
    """

    case: str
    truth: tuple[tuple[str, str], ...]
    named: tuple[NamedThing, ...]
    unsure: tuple[NamedThing, ...]
    told: tuple[str, ...]
    verdict: str
    places: int
    families: int
    laws: int
    called: int
    false: tuple[NamedThing, ...]
    mass_off: float | None
    seconds: float


@dataclass(frozen=True)
class ArmAnswer:
    """What a diagnosis said of a case.

    Attributes:
        things: that were found.
        places: where something is missing for sure.
        verdict: of the diagnosis.
        payload_kg: None where none was found.
        seconds: it took.
    """

    things: tuple[NamedThing, ...]
    places: tuple[str, ...]
    verdict: str
    payload_kg: float | None
    seconds: float


def diagnosed(folder: Path) -> ArmAnswer:
    """The diagnosis of a case's folder, which has no truth in it."""
    begun = time.perf_counter()
    model = load_arm_model(folder / "model.yaml")
    arm = ArmPlant.of(model)
    found = diagnose_arm([load_joint_log(folder / "log.npz", model, arm.joints)], model)
    named = tuple(NamedThing(e.name, e.family, e.block, e.where, e.certain) for e in found.effects)
    mass = next((e.numbers["m"] for e in found.effects if e.name == "payload"), None)
    kg = mass.value if isinstance(mass, Number) else None
    return ArmAnswer(named, found.places, found.verdict, kg, time.perf_counter() - begun)


def scored(case: ArmTrialCase, answer: ArmAnswer) -> ArmScore:
    """A diagnosis held against the truth."""
    named, unsure = (tuple(n for n in answer.things if bool(n.certain) == sure) for sure in (True, False))
    mass = answer.payload_kg
    truth = [(c, ARM_EFFECTS[c.name]) for c in case.concealed]
    places = sum(c.where in answer.places for c, _ in truth)
    families = sum(any(n.where == c.where and n.family == e.family for n in named) for c, e in truth)
    sure = [n for n in named if n.certain == "law"]
    laws = sum(any(n.where == c.where and n.name == c.name for n in sure) for c, _ in truth)
    called = sum(any(n.where == c.where and n.family == e.family for n in sure) for c, e in truth)
    false = tuple(n for n in named if not _is_true(n, case.concealed))
    payload = next((c.numbers["m"] for c in case.concealed if c.name == "payload"), None)
    off = abs(mass / payload - 1.0) if mass is not None and payload is not None else None
    concealed = tuple((c.name, c.where) for c in case.concealed)
    counts = (places, families, laws, called)
    told, verdict = answer.places, answer.verdict
    return ArmScore(case.name, concealed, named, unsure, told, verdict, *counts, false, off, answer.seconds)


def _is_true(named: NamedThing, concealed: Sequence[Concealment]) -> bool:
    """Whether a name is right at the depth that it is called certain to."""
    here = [ARM_EFFECTS[c.name] for c in concealed if c.where == named.where]
    if named.certain == "law":
        return any(e.name == named.name or named.name in e.holds for e in here)
    if named.certain == "family":
        return any(e.family == named.family for e in here)
    return any(e.block == named.block for e in here)


def arm_study(per_effect: int, remainder: float) -> Study:
    """The trial as a study.

    Args:
        per_effect: cases whose first concealed effect is each; one in eight conceals nothing.
        remainder: see `draw_case`.
    """
    firsts: list[str | None] = [effect for effect in EFFECTS for _ in range(per_effect)]
    firsts += [None] * max(1, len(firsts) // 7)

    def run(asked: Asked, progress: Progress) -> Report:
        draws = [
            partial(draw_case, asked.out, f"case-{number:04d}", asked.seed, number, first, remainder)
            for number, first in enumerate(firsts)
        ]
        cases = results_of(draws, asked.jobs, lambda done: progress(0.3 * done))
        sealed = seal(cases)
        asked.say(f"sealed: {sealed}")
        tasks = [partial(diagnosed, case.folder) for case in cases]
        answers = results_of(
            tasks, asked.jobs, lambda done: progress(0.3 * len(cases) + 0.7 * done), compile_first=True
        )
        (asked.out / "truths.json").write_text(canonical(cases))
        scores = [scored(case, answer) for case, answer in zip(cases, answers, strict=True)]
        return report_of(scores, sealed, asked.seed, remainder)

    return Study("cases of arms", ("seed",), lambda asked: float(len(firsts)), run)


def report_of(scores: Sequence[ArmScore], sealed: str, seed: int, remainder: float) -> Report:
    """What a trial comes to."""
    effects = sum(len(score.truth) for score in scores)
    named = sum(len(score.named) for score in scores)
    false = [(score, thing) for score in scores for thing in score.false]
    called = sum(score.called for score in scores)
    clean = [score for score in scores if not score.truth]
    told = [place in {where for _, where in s.truth} for s in scores for place in s.told]
    by_name = sum(any(n.where == where for n in s.named) for s in scores for _, where in s.truth)
    unsure = [thing.where in {where for _, where in s.truth} for s in scores for thing in s.unsure]
    masses = sorted(score.mass_off for score in scores if score.mass_off is not None)
    seconds = sorted(score.seconds for score in scores)
    rows: list[list[Cell]] = [
        ["right place", f"{sum(s.places for s in scores)} of {effects}", 0.95],
        ["... by a name that is sure", f"{by_name} of {effects}", None],
        ["places told where nothing is concealed", f"{told.count(False)} of {len(told)}", None],
        ["names that are not sure, where nothing is concealed", f"{unsure.count(False)} of {len(unsure)}", None],
        ["right family or deeper", f"{sum(s.families for s in scores)} of {effects}", 0.92],
        ["law called certain is right", f"{sum(s.laws for s in scores)} of {called}", 0.80],
        ["names false at the depth called certain", f"{len(false)} of {named}", 0.01],
        ["arms with nothing concealed that got a name", f"{sum(bool(s.named) for s in clean)} of {len(clean)}", 0.0],
        ["payload's mass off, median", None if not masses else masses[len(masses) // 2], 0.02],
        ["time of a diagnosis, median [s]", seconds[len(seconds) // 2], 60.0],
    ]
    table = Table(("figure", "measured", "to reach"), rows, f"{len(scores)} cases, remainder {remainder:g}.", digits=3)
    by = [_row(effect, scores) for effect in EFFECTS]
    effects_table = Table(("concealed", "times", "place", "family", "law, certain"), by, "By concealed effect.")
    sentences = [
        f"{score.case}: {thing.name} on {thing.where or 'the arm'}, certain: {thing.certain}; concealed "
        + (", ".join(f"{name} on {where or 'the arm'}" for name, where in score.truth) or "nothing")
        for score, thing in false
    ]
    data: dict[str, Any] = {"trial": "arms", "seal_sha256": sealed, "seed": seed, "remainder": remainder}
    data["cases"] = [
        {
            "case": s.case,
            "truth": [list(pair) for pair in s.truth],
            "verdict": s.verdict,
            "effects": [vars(thing) for thing in s.named],
            "false_name": bool(s.false),
            "seconds": s.seconds,
        }
        for s in scores
    ]
    data["summary"] = {str(row[0]): row[1] for row in rows}
    sections = [Section("Figures", table=table), Section("By effect", table=effects_table)]
    lead = (
        "A Panda and a UR5 simulated by MuJoCo, tracking drawn motions for 30 s, logged at 125 to 500 Hz with an "
        "uneven clock, noise and quantisation. One to three effects are concealed from the model handed in, beside "
        "what is nameless; one arm in eight has nothing concealed."
    )
    return Report(data, "Trial of arms", lead, "Arms", [table, effects_table], sentences, sections, ())


def _row(effect: str, scores: Sequence[ArmScore]) -> list[Cell]:
    family = ARM_EFFECTS[effect].family
    having = [(s, where) for s in scores for name, where in s.truth if name == effect]
    place = sum(where in s.told for s, where in having)
    kin = sum(any(n.where == where and n.family == family for n in s.named) for s, where in having)
    law = sum(any(n.where == where and n.name == effect and n.certain == "law" for n in s.named) for s, where in having)
    return [effect, len(having), place, kin, law]
