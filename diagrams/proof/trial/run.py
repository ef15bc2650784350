"""A trial from end to end: its cases drawn, sealed, written, diagnosed; the truths opened only then, and scored."""

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cache, partial
from itertools import combinations, cycle
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mmt_drake.diagrams.proof.studies import Asked, Report, Study
from mmt_drake.diagrams.proof.studies.study import Progress
from mmt_drake.diagrams.proof.trial.cases import Case, draw_plain, draw_several, draw_single
from mmt_drake.diagrams.proof.trial.laws import INSIDE, OUTSIDE
from mmt_drake.diagrams.proof.trial.other_cases import (
    DRIVEN,
    MATERIAL,
    TRANSMISSION,
    draw_driven,
    draw_material,
    draw_transmission,
)
from mmt_drake.diagrams.proof.trial.palpation import EFFECTS as PALPATED
from mmt_drake.diagrams.proof.trial.palpation import PALPATION, draw_palpation
from mmt_drake.diagrams.proof.trial.plants import OWN, PLANTS, Plant
from mmt_drake.diagrams.proof.trial.remainder import REMAINDERS, draw_beneath
from mmt_drake.diagrams.proof.trial.score import score
from mmt_drake.diagrams.proof.trial.sealing import canonical, seal
from mmt_drake.diagrams.proof.trial.summary import confusion_picture, document, effects_table, rates_table
from mmt_drake.errors import BadInput, Interrupted, MmtError, check_number
from mmt_drake.recording import save
from mmt_drake.recording.atomic import replacing, writing

RECORDING, MODEL = "recording.npz", "model.yaml"
"""What a case's folder holds."""

Diagnose = Callable[[Path], Mapping[str, Any]]
"""From a case's folder (`RECORDING`, `MODEL`) to its `diagnosis.json`."""
Diagnosed = tuple[Mapping[str, Any], float]
Spread = Callable[[Callable[[Case], Diagnosed], Sequence[Case]], Iterable[Diagnosed]]
"""Applies a function to every case, in order: `map`, or a pool of workers."""


def draw_trial(seed: int = 0, per_effect: int = 4, remainder: float = 0.0, plant: str = "own") -> list[Case]:
    """All cases of a trial, in an order and under names that say nothing.

    Args:
        seed: the same one gives the same cases.
        per_effect: cases per effect of the library, their sizes spread over the whole range. Effects outside the
            library, pairs, clean recordings, wrong parameters, the other structures and triples follow in
            proportion.
        remainder: where it is not 0, every case is one plain effect above a remainder that is so large
            (`remainder.draw_beneath`), the laws of it in turn.
        plant: of `PLANTS`, or `PALPATION`. The foreign one simulates flexible objects alone, with the effects that it
            has; palpation is tips on surfaces alone.

    Raises:
        BadInput: fewer than one case per effect, a negative seed, or no such plant.
    """
    check_number("trial", "seed", seed, least=0)
    check_number("trial", "per-effect", per_effect, least=1)
    check_number("trial", "remainder", remainder, least=0.0)
    if plant not in (*PLANTS, PALPATION):
        raise BadInput("trial", at="plant", found=plant, expected=" or ".join((*PLANTS, PALPATION)))
    if plant == PALPATION and remainder:
        raise BadInput("trial", at="remainder", found=f"{remainder:g} with {plant}", expected="no remainder there")
    rng = np.random.default_rng((seed, 7))
    if plant == PALPATION:
        cases = list(_palpated(rng, per_effect))
    elif remainder:
        cases = list(_beneath(rng, per_effect, remainder, PLANTS[plant]))
    else:
        cases = list(_ordered(rng, per_effect, PLANTS[plant]))
    order = rng.permutation(len(cases))
    return [replace(cases[i], name=f"case-{number:04d}") for number, i in enumerate(order, 1)]


def _ordered(rng: np.random.Generator, per_effect: int, plant: Plant) -> Iterator[Case]:
    for effect in filter(plant.effects.__contains__, INSIDE):
        for size in _sizes(rng, per_effect):
            yield draw_single(rng, effect, effect, size, plant)
    few = (per_effect + 1) // 2
    for effect in filter(plant.effects.__contains__, OUTSIDE):
        for size in _sizes(rng, few):
            yield draw_single(rng, effect, effect, 0.4 + 0.6 * size, plant)
    for _ in range(5 * per_effect):
        yield draw_several(rng, "pair", 2, plant)
        yield draw_plain(rng, "clean", wrong=False, plant=plant)
        yield draw_plain(rng, "wrong", wrong=True, plant=plant)
    if plant is OWN:
        yield from _of_other_structures(rng, per_effect)
    for _ in range(3 * per_effect):
        yield draw_several(rng, "triple", 3, plant)


def _of_other_structures(rng: np.random.Generator, per_effect: int) -> Iterator[Case]:
    for effects, draw in ((DRIVEN, draw_driven), (MATERIAL, draw_material), (TRANSMISSION, draw_transmission)):
        for name in effects:
            for size in _sizes(rng, (per_effect + 1) // 2):
                yield draw(rng, name, name, size, wrong=bool(rng.random() < 0.5))
        for i in range(per_effect):
            yield draw(rng, "plain", None, 0.0, wrong=i % 2 == 1)


def _beneath(rng: np.random.Generator, per_effect: int, share: float, plant: Plant) -> Iterator[Case]:
    laws = cycle(REMAINDERS)
    for effect in filter(plant.effects.__contains__, INSIDE):
        for size in _sizes(rng, per_effect):
            yield draw_beneath(rng, effect, effect, 0.5 + 0.5 * size, next(laws), share, plant)


def _palpated(rng: np.random.Generator, per_effect: int) -> Iterator[Case]:
    pairs = list(combinations(PALPATED, 2))
    for effect in PALPATED:
        for size in _sizes(rng, per_effect):
            yield draw_palpation(rng, effect, (effect,), size, wrong=bool(rng.random() < 0.5))
    for number in range(2 * per_effect):
        size = 0.6 + 0.4 * float(rng.random())
        yield draw_palpation(rng, "pair", pairs[number % len(pairs)], size, wrong=bool(rng.random() < 0.5))
    for number in range(2 * per_effect):
        yield draw_palpation(rng, "plain", (), 0.0, wrong=number % 2 == 1)


def _sizes(rng: np.random.Generator, count: int) -> list[float]:
    """One size from each of `count` equal parts of the range."""
    return [float((i + rng.random()) / count) for i in range(count)]


def write_case(case: Case, folder: Path) -> Path:
    """Write recording and nominal model into a folder of the case's name below `folder`; its truth stays out.

    Raises:
        BadInput: the operating system refuses.
    """
    own = folder / case.name
    with writing(own):
        own.mkdir(parents=True, exist_ok=True)
    save(case.recording(), own / RECORDING)
    _write(own / MODEL, yaml.safe_dump(dict(case.nominal), sort_keys=False))
    return own


def run_trial(
    cases: Sequence[Case],
    out: Path,
    diagnose: Diagnose,
    *,
    spread: Spread = map,
    announce: Callable[[str], None] = print,
    plant: str = "own",
) -> dict[str, Any]:
    """Run sealed cases through a diagnosis and score them.

    Args:
        cases: of `draw_trial`.
        out: folder for the cases, `diagnoses.json`, `truths.json`, `trial.json` and `confusion.png`.
        diagnose: sees a case's folder and nothing else.
        spread: how the cases are spread over workers; `diagnose` must then be importable there.
        announce: is given the seal before the first diagnosis.
        plant: the cases' own, to be printed.

    Returns:
        The trial's JSON (contract section 6).

    Raises:
        BadInput: the folder cannot be written.
        Interrupted: with the diagnoses by then; the truths stay sealed.
    """
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
    sealed = seal(cases)
    announce(f"sealed {len(cases)} truths, sha256 {sealed}")
    diagnosed = list[Diagnosed]()
    try:
        diagnosed.extend(spread(partial(_one, folder=out / "cases", diagnose=diagnose), cases))
    except KeyboardInterrupt:
        known = {"of": len(cases), "diagnoses": _answers(cases, diagnosed)}
        raise Interrupted(f"{len(diagnosed)} of {len(cases)} diagnosed", known if diagnosed else None) from None
    # The diagnoses are on disk before the truths are.
    answers = _answers(cases, diagnosed)
    _write(out / "diagnoses.json", _indented(answers))
    _write(out / "truths.json", canonical(cases))  # the very text that was sealed
    scores = [score(case.truth(), answer, took) for case, (answer, took) in zip(cases, diagnosed, strict=True)]
    whole = document(sealed, scores, plant)
    _write(out / "trial.json", _indented(whole))
    with replacing(out / "confusion.png") as temporary:
        confusion_picture(scores).savefig(temporary)
    return whole


def _one(case: Case, folder: Path, diagnose: Diagnose) -> Diagnosed:
    """Write a case and diagnose it; one that crashes is counted, not hidden, and does not end the trial."""
    own = write_case(case, folder)
    start = time.perf_counter()
    try:
        answer = diagnose(own)
    except (MmtError, ArithmeticError, ValueError, LookupError, RuntimeError, TypeError) as error:
        answer = {"verdict": "crashed", "summary": f"{type(error).__name__}: {error}"}
    return answer, time.perf_counter() - start


def _answers(cases: Sequence[Case], diagnosed: Sequence[Diagnosed]) -> dict[str, Mapping[str, Any]]:
    """By the name of a case; of the first ones alone where not all are diagnosed."""
    return {case.name: answer for case, (answer, _) in zip(cases, diagnosed, strict=False)}


def _indented(content: Mapping[str, Any]) -> str:
    return json.dumps(content, indent=1, allow_nan=False)


def _write(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def sealed_study(
    per_effect: int,
    remainder: float,
    plant: str,
    diagnose: Diagnose,
    workers: Callable[[], AbstractContextManager[Executor]],
) -> Study:
    """The study that draws sealed cases and has them diagnosed.

    Args:
        per_effect, remainder, plant: of `draw_trial`.
        diagnose: of `run_trial`.
        workers: gives who diagnoses.
    """
    drawn = cache(lambda seed: draw_trial(seed, per_effect, remainder, plant))

    def run(asked: Asked, progress: Progress) -> Report:
        def spread(function: Callable[[Case], Diagnosed], items: Sequence[Case]) -> Iterator[Diagnosed]:
            for done, result in enumerate(executor.map(function, items), 1):
                progress(done)
                yield result

        with workers() as executor:
            cases, say = drawn(asked.seed), asked.say
            whole = run_trial(cases, asked.out, diagnose, spread=spread, announce=say, plant=plant)
        return Report(
            whole,
            title="Concealed effects",
            lead=f"Cases by the {plant} plant, their truths sealed until all are diagnosed; seed {asked.seed}, "
            f"{per_effect} of each effect{f', above a remainder of {remainder:g}' if remainder else ''}.",
            heading="",
            own_tables=[rates_table(whole["summary"]), effects_table(whole["summary"])],
            sentences=[f"{asked.out}: trial.json, truths.json, confusion.png and every case"],
        )

    return Study("trial, cases", ("seed",), lambda asked: len(drawn(asked.seed)), run)
