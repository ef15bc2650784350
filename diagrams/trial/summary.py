"""All scores of a trial together: rates, detection limits, coverage, the confusion matrix."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagrams.trial.score import TrialScore

VERDICTS = ("no_mismatch", "parameters", "ambiguous", "unexplained", "insufficient_data", "crashed")
"""What a diagnosis says instead of a name."""


def document(seal_sha256: str, scores: Sequence[TrialScore]) -> dict[str, Any]:
    """The trial's JSON (contract section 6)."""
    return {"seal_sha256": seal_sha256, "cases": [score.line() for score in scores], "summary": summarise(scores)}


def summarise(scores: Sequence[TrialScore]) -> dict[str, Any]:
    """Rates over the cases they are about; a rate over no case is None.

    `right` is about single effects that are noticeable, `right_visible` about those whose visibility, which no
    diagnosis has a hand in, is ten times the noise or more.
    """
    by_kind = {kind: [s for s in scores if s.truth["kind"] == kind] for kind in ("none", "parameters", "pair")}
    singles = [s for s in scores if s.truth["kind"] == "single"]
    noticeable = [s for s in singles if s.noticeable]
    outside = [s for s in scores if s.truth["kind"] == "outside" and s.noticeable]
    plain = by_kind["none"] + by_kind["parameters"]
    quantities = [q for s in scores for q in s.quantities]
    named = [s for s in scores if s.correct and s.effects and "augmented" in s.heldout_nrmse]
    return {
        "cases": len(scores),
        "noticeable": len(noticeable),
        "right": _rate(noticeable, _correct),
        "right_family": _rate(noticeable, lambda s: bool(s.right_family)),
        "right_visible": _rate([s for s in singles if s.truth["visibility"] >= 10.0], _correct),
        "right_pairs": _rate(by_kind["pair"], _correct),
        "right_outside": _rate(outside, _correct),
        "right_clean": _rate(by_kind["none"], _correct),
        "right_parameters": _rate(by_kind["parameters"], _correct),
        "false_name_rate": _rate(scores, _false),
        "false_names_plain": sum(map(_false, plain)),
        "block_right": _rate([s for s in scores if s.block_correct is not None and s.noticeable], _block),
        "coverage": _rate([q for q in quantities if q.covered is not None], lambda q: bool(q.covered)),
        "coverage_object": _rate(
            [q for s in scores for q in s.base_quantities if q.covered is not None], lambda q: bool(q.covered)
        ),
        "parameter_error": _median(q.relative_error for q in quantities),
        "improvement": _median(s.heldout_nrmse["refit"] / s.heldout_nrmse["augmented"] for s in named),
        "augmented_over_noise": _median(
            s.heldout_nrmse["augmented"] / s.noise_floor for s in named if s.noise_floor is not None
        ),
        "seconds": _median(s.seconds for s in scores),
        "seconds_worst": max((s.seconds for s in scores), default=None),
        "crashed": sum(s.verdict == "crashed" for s in scores),
        "by_effect": {name: _of_effect(own) for name, own in _by_name(scores).items()},
    }


def _by_name(scores: Sequence[TrialScore]) -> dict[str, list[TrialScore]]:
    """Cases with one effect by its name, and by structure where that is not the flexible box."""
    found: dict[str, list[TrialScore]] = {}
    for s in scores:
        if len(s.truth["truth"]) == 1:
            structure = s.truth["structure"]
            suffix = "" if structure == "flexible_box" else f" ({structure})"
            found.setdefault(s.truth["truth"][0] + suffix, []).append(s)
    return dict(sorted(found.items()))


def _of_effect(scores: Sequence[TrialScore]) -> dict[str, Any]:
    found = [s for s in scores if s.correct]
    missed = [s for s in scores if not s.correct]
    quantities = [q for s in found for q in s.quantities]
    return {
        "cases": len(scores),
        "right": _rate(scores, _correct),
        "right_noticeable": _rate([s for s in scores if s.noticeable], _correct),
        "false_names": sum(map(_false, scores)),
        "smallest_found": _limit(min(found, key=_size)) if found else None,
        "largest_missed": _limit(max(missed, key=_size)) if missed else None,
        "coverage": _rate([q for q in quantities if q.covered is not None], lambda q: bool(q.covered)),
        "parameter_error": _median(q.relative_error for q in quantities),
        "seconds": _median(s.seconds for s in scores),
    }


def _limit(s: TrialScore) -> dict[str, Any]:
    return {
        "size": s.truth["size"],
        "parameters": s.truth["parameters"][0],
        "visibility": s.truth["visibility"],
        "residual_over_noise": s.residual_over_noise,
    }


def _correct(s: TrialScore) -> bool:
    return s.correct


def _false(s: TrialScore) -> bool:
    return s.false_name


def _block(s: TrialScore) -> bool:
    return s.block_correct is True


def _size(s: TrialScore) -> float:
    return float(s.truth["size"])


def _rate(items: Sequence[Any], holds: Callable[[Any], bool]) -> float | None:
    return sum(map(holds, items)) / len(items) if items else None


def _median(values: Iterable[float]) -> float | None:
    listed = list(values)
    return float(np.median(listed)) if listed else None


def confusion(scores: Sequence[TrialScore]) -> tuple[list[str], list[str], np.ndarray[Any, np.dtype[np.int64]]]:
    """Rows (what is concealed), columns (what was said) and counts (rows, columns).

    A certain answer counts under its first name that is not true, or else under the truth; a pair is a row of its own
    whose column is `both` if both were named.
    """
    cells = Counter((_row(s), _column(s)) for s in scores)
    rows = sorted({row for row, _ in cells}, key=_order)
    columns = sorted({column for _, column in cells}, key=_order)
    counts = np.array([[cells[row, column] for column in columns] for row in rows], dtype=np.int64)
    return rows, columns, counts


def _row(s: TrialScore) -> str:
    kind = s.truth["kind"]
    if kind == "pair":
        return "two effects"
    if kind in ("none", "parameters"):
        return {"none": "nothing", "parameters": "wrong parameters"}[kind]
    name = str(s.truth["truth"][0])
    return f"outside: {name}" if kind == "outside" else name


def _column(s: TrialScore) -> str:
    if not s.effects or s.verdict == "ambiguous":
        return s.verdict
    if s.truth["kind"] == "pair" and s.correct:
        return "both"
    if s.false_name:
        return next((name for name in s.effects if name not in s.truth["truth"]), s.effects[0])
    return s.effects[0]


def _order(label: str) -> tuple[int, int, str]:
    """Names first, then pairs, what is outside, nothing and wrong parameters, and verdicts in their own order."""
    if label in VERDICTS:
        return (5, VERDICTS.index(label), label)
    groups = {"two effects": 1, "both": 1, "nothing": 3, "wrong parameters": 4}
    return (groups.get(label, 2 if label.startswith("outside") else 0), 0, label)


def rates_table(summary: dict[str, Any]) -> Table:
    """The summary's figures with what they should reach."""
    targets = {
        "right": ">= 0.95",
        "false_name_rate": "<= 0.01",
        "false_names_plain": "0",
        "right_outside": ">= 0.90",
        "right_pairs": ">= 0.80",
        "parameter_error": "<= 0.05",
        "coverage": "0.90 to 0.99",
        "augmented_over_noise": "<= 1.3",
        "seconds": "<= 30",
    }
    rows = [
        (name.replace("_", " "), value, targets.get(name, "")) for name, value in summary.items() if name != "by_effect"
    ]
    return Table(("figure", "measured", "to reach"), rows, "Concealed-effect trial")


def effects_table(summary: dict[str, Any]) -> Table:
    """One row per effect: how often right, the smallest found, the largest missed."""
    rows: list[list[Cell]] = []
    for name, of in summary["by_effect"].items():
        found, missed = of["smallest_found"], of["largest_missed"]
        rows.append(
            [
                name,
                of["cases"],
                of["right"],
                of["right_noticeable"],
                of["false_names"],
                _parameters(found),
                found and found["residual_over_noise"],
                missed and missed["residual_over_noise"],
                of["parameter_error"],
            ]
        )
    headers = (
        "effect",
        "cases",
        "right",
        "right, noticeable",
        "false names",
        "smallest found",
        "its residual / noise",
        "largest missed, residual / noise",
        "parameter error",
    )
    return Table(headers, rows, "Effects one by one")


def _parameters(limit: dict[str, Any] | None) -> str:
    return "–" if limit is None else ", ".join(f"{symbol} {value:.3g}" for symbol, value in limit["parameters"].items())
