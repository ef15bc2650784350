"""The whole trial: its cases drawn, sealed, written; the truths opened only after the diagnoses."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mmt_drake.diagrams.trial.cases import Case, draw_pair, draw_plain, draw_single
from mmt_drake.diagrams.trial.laws import INSIDE, OUTSIDE
from mmt_drake.diagrams.trial.one_axis import DRIVEN, MATERIAL
from mmt_drake.diagrams.trial.other_cases import draw_driven, draw_material
from mmt_drake.diagrams.trial.remainder import REMAINDERS, draw_beneath
from mmt_drake.errors import check_number
from mmt_drake.recording import save
from mmt_drake.recording.atomic import replacing, writing

RECORDING, MODEL = "recording.npz", "model.yaml"
"""What a case's folder holds."""


def draw_trial(seed: int = 0, per_effect: int = 4, remainder: float = 0.0) -> list[Case]:
    """All cases of a trial, in an order and under names that say nothing.

    Args:
        seed: the same one gives the same cases.
        per_effect: cases per effect of the library, their sizes spread over the whole range. Effects outside the
            library, pairs, clean recordings, wrong parameters and the other structures follow in proportion.
        remainder: where it is not 0, every case is one plain effect above a remainder that is so large
            (`remainder.draw_beneath`), the laws of it in turn.

    Raises:
        BadInput: fewer than one case per effect, or a negative seed.
    """
    check_number("trial", "seed", seed, least=0)
    check_number("trial", "per-effect", per_effect, least=1)
    check_number("trial", "remainder", remainder, least=0.0)
    rng = np.random.default_rng((seed, 7))
    cases = list(_beneath(rng, per_effect, remainder) if remainder else _ordered(rng, per_effect))
    order = rng.permutation(len(cases))
    return [replace(cases[i], name=f"case-{number:04d}") for number, i in enumerate(order, 1)]


def _ordered(rng: np.random.Generator, per_effect: int) -> Iterator[Case]:
    for effect in INSIDE:
        for size in _sizes(rng, per_effect):
            yield draw_single(rng, effect, effect, size)
    few = (per_effect + 1) // 2
    for effect in OUTSIDE:
        for size in _sizes(rng, few):
            yield draw_single(rng, effect, effect, 0.4 + 0.6 * size)
    for _ in range(5 * per_effect):
        yield draw_pair(rng, "pair")
        yield draw_plain(rng, "clean", wrong=False)
        yield draw_plain(rng, "wrong", wrong=True)
    for effects, draw in ((DRIVEN, draw_driven), (MATERIAL, draw_material)):
        for name in effects:
            for size in _sizes(rng, few):
                yield draw(rng, name, name, size, wrong=bool(rng.random() < 0.5))
        for i in range(per_effect):
            yield draw(rng, "plain", None, 0.0, wrong=i % 2 == 1)


def _beneath(rng: np.random.Generator, per_effect: int, share: float) -> Iterator[Case]:
    laws = cycle(REMAINDERS)
    for effect in INSIDE:
        for size in _sizes(rng, per_effect):
            yield draw_beneath(rng, effect, effect, 0.5 + 0.5 * size, next(laws), share)


def _sizes(rng: np.random.Generator, count: int) -> list[float]:
    """One size from each of `count` equal parts of the range."""
    return [float((i + rng.random()) / count) for i in range(count)]


def canonical(truths: Sequence[dict[str, Any]]) -> str:
    """The one JSON text of these truths: keys sorted, no spaces."""
    return json.dumps(list(truths), sort_keys=True, separators=(",", ":"), allow_nan=False)


def seal(cases: Sequence[Case]) -> str:
    """The sha256 of all truths, to be published before the first diagnosis."""
    return hashlib.sha256(canonical([case.truth() for case in cases]).encode()).hexdigest()


def write_case(case: Case, folder: Path) -> Path:
    """Write recording and nominal model into a folder of the case's name below `folder`; its truth stays out.

    Raises:
        BadInput: the operating system refuses.
    """
    own = folder / case.name
    with writing(own):
        own.mkdir(parents=True, exist_ok=True)
    save(case.recording(), own / RECORDING)
    with replacing(own / MODEL) as temporary:
        temporary.write_text(yaml.safe_dump(dict(case.nominal), sort_keys=False), encoding="utf-8")
    return own


def write_truths(cases: Sequence[Case], path: Path) -> None:
    """Open the seal: write the very text that was sealed.

    Raises:
        BadInput: the operating system refuses.
    """
    with replacing(path) as temporary:
        temporary.write_text(canonical([case.truth() for case in cases]), encoding="utf-8")
