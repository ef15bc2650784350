"""All scores of a trial together: rates, detection limits, coverage, the confusion matrix and its picture."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mmt_drake.analysis.plotting import BLACK, DPI, GREEN, GREY, RED, styled
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import significant
from mmt_drake.diagrams.proof.studies.counted import counted
from mmt_drake.diagrams.proof.studies.of_known import of_known
from mmt_drake.diagrams.proof.trial.score import ScoredNumber, TrialScore
from mmt_drake.errors import BadInput

VERDICTS = ("no_mismatch", "parameters", "ambiguous", "unexplained", "insufficient_data", "crashed")
"""What a diagnosis says instead of a name."""


_SEVERAL, _ALL = ("pair", "triple"), "all"
_ROWS = {"pair": "two effects", "triple": "three effects", "none": "nothing", "parameters": "wrong parameters"}


def document(seal_sha256: str, scores: Sequence[TrialScore], plant: str = "own") -> dict[str, Any]:
    """The trial's JSON (contract section 6), and in its summary by which plant the cases are."""
    summary = {"plant": plant, **summarise(scores)}
    return {"seal_sha256": seal_sha256, "cases": [score.line() for score in scores], "summary": summary}


def summarise(scores: Sequence[TrialScore]) -> dict[str, Any]:
    """Rates over the cases they are about; a rate over no case is None.

    `right` is about single effects that are noticeable, `right_visible` about those whose visibility, which no
    diagnosis has a hand in, is ten times the noise or more. `counted` tells of each rate of cases how many of how many
    it is and what that bounds, `sizes` how large what was concealed in pairs, triples and from outside the library was.
    """
    none, parameters, single, pair, triple, outside = (
        [s for s in scores if s.truth["kind"] == kind]
        for kind in ("none", "parameters", "single", "pair", "triple", "outside")
    )
    noticeable = [s for s in single if s.noticeable]
    quantities = [q for s in scores for q in s.quantities]
    named = [s for s in scores if s.correct and s.effects and "augmented" in s.heldout_nrmse]
    flags = {
        "right": _correct(noticeable),
        "right_family": [s.right_family for s in noticeable],
        "right_visible": _correct(s for s in single if s.truth["visibility"] >= 10.0),
        "right_pairs": _correct(pair),
        "right_triples": _correct(triple),
        "right_outside": _correct(s for s in outside if s.noticeable),
        "right_clean": _correct(none),
        "right_parameters": _correct(parameters),
        "false_name_rate": [s.false_name for s in scores],
        "block_right": [bool(s.block_correct) for s in scores if s.block_correct is not None and s.noticeable],
    }
    sizes = {"pairs": pair, "triples": triple, "outside": outside}
    return {
        "cases": len(scores),
        "noticeable": len(noticeable),
        **{name: _rate(each) for name, each in flags.items()},
        "false_names_plain": sum(s.false_name for s in none + parameters),
        "coverage": _coverage(quantities),
        "coverage_object": _coverage(q for s in scores for q in s.base_quantities),
        "parameter_error": _median(q.relative_error for q in quantities),
        "improvement": _median(s.heldout_nrmse["refit"] / s.heldout_nrmse["augmented"] for s in named),
        "augmented_over_noise": _median(
            s.heldout_nrmse["augmented"] / s.noise_floor for s in named if s.noise_floor is not None
        ),
        "seconds": _median(s.seconds for s in scores),
        "seconds_worst": max((s.seconds for s in scores), default=None),
        "crashed": sum(s.verdict == "crashed" for s in scores),
        "counted": {name: counted(each, from_above=name == "false_name_rate") for name, each in flags.items() if each},
        "sizes": {name: _sizes(each) for name, each in sizes.items() if each},
        "by_effect": {name: _of_effect(own) for name, own in _by_name(scores).items()},
    }


def _sizes(scores: Sequence[TrialScore]) -> dict[str, Any]:
    """Smallest, median and largest of what was concealed, of its range and over the noise."""
    values = {name: [float(s.truth[name]) for s in scores] for name in ("size", "visibility")}
    return {name: [min(each), float(np.median(each)), max(each)] for name, each in values.items()}


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
    found, missed = ([s for s in scores if s.correct is correct] for correct in (True, False))
    quantities = [q for s in found for q in s.quantities]
    return {
        "cases": len(scores),
        "right": _right(scores),
        "right_noticeable": _right(s for s in scores if s.noticeable),
        "false_names": sum(s.false_name for s in scores),
        "smallest_found": _limit(min(found, key=_size)) if found else None,
        "largest_missed": _limit(max(missed, key=_size)) if missed else None,
        "coverage": _coverage(quantities),
        "parameter_error": _median(q.relative_error for q in quantities),
        "seconds": _median(s.seconds for s in scores),
    }


def _size(s: TrialScore) -> float:
    return float(s.truth["size"])


def _limit(s: TrialScore) -> dict[str, Any]:
    return {
        "size": s.truth["size"],
        "parameters": s.truth["parameters"][0],
        "visibility": s.truth["visibility"],
        "residual_over_noise": s.residual_over_noise,
    }


def _rate(flags: Iterable[bool | None]) -> float | None:
    listed = list(map(bool, flags))
    return sum(listed) / len(listed) if listed else None


def _correct(scores: Iterable[TrialScore]) -> list[bool]:
    return [bool(s.correct) for s in scores]


def _right(scores: Iterable[TrialScore]) -> float | None:
    return _rate(_correct(scores))


def _coverage(quantities: Iterable[ScoredNumber]) -> float | None:
    return _rate(q.covered for q in quantities if q.covered is not None)


_median = partial(of_known, np.median)


def confusion(scores: Sequence[TrialScore]) -> tuple[list[str], list[str], np.ndarray[Any, np.dtype[np.int64]]]:
    """Rows (what is concealed), columns (what was said) and counts (rows, columns).

    A certain answer counts under its first name that is not true, or else under the truth; pairs are a row of their
    own, and triples, whose column is `all` if all were named.
    """
    cells = Counter(map(_cell, scores))
    rows = sorted({row for row, _ in cells}, key=_order)
    columns = sorted({column for _, column in cells}, key=_order)
    counts = np.array([[cells[row, column] for column in columns] for row in rows], dtype=np.int64)
    return rows, columns, counts


def _cell(s: TrialScore) -> tuple[str, str]:
    return _row(s), _column(s)


def _row(s: TrialScore) -> str:
    kind = s.truth["kind"]
    if kind in _ROWS:
        return _ROWS[kind]
    name = str(s.truth["truth"][0])
    return f"outside: {name}" if kind == "outside" else name


def _column(s: TrialScore) -> str:
    if not s.effects or s.verdict == "ambiguous":
        return s.verdict
    if s.truth["kind"] in _SEVERAL and s.correct:
        return _ALL
    if s.false_name:
        return next((name for name in s.effects if name not in s.truth["truth"]), s.effects[0])
    return s.effects[0]


def _order(label: str) -> tuple[int, int, str]:
    """Names first, then several, what is outside, nothing and wrong parameters, and verdicts in their own order."""
    if label in VERDICTS:
        return (5, VERDICTS.index(label), label)
    groups = {_ROWS["pair"]: 1, _ROWS["triple"]: 1, _ALL: 1, "nothing": 3, "wrong parameters": 4}
    return (groups.get(label, 2 if label.startswith("outside") else 0), 0, label)


@styled
def confusion_picture(scores: Sequence[TrialScore]) -> Figure:
    """What was concealed (rows) against what was said (columns); right answers green, false names red.

    A cell whose cases were neither, a verdict that leaves the question open or an effect that was missed, is grey.

    Raises:
        BadInput: no score.
    """
    if not scores:
        raise BadInput("trial", found="no case", expected="at least one to draw")
    rows, columns, counts = confusion(scores)
    right, false = {_cell(s) for s in scores if s.correct}, {_cell(s) for s in scores if s.false_name}
    width, height = 2.6 + 0.27 * len(columns), 2.2 + 0.21 * len(rows)
    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((2.3 / width, 0.15 / height, 0.27 * len(columns) / width, 0.21 * len(rows) / height))
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5))
    for i, j in zip(*np.nonzero(counts), strict=True):
        cell, share = (rows[i], columns[j]), counts[i, j] / counts[i].sum()
        color = RED if cell in false else GREEN if cell in right else GREY
        across, down = [j - 0.5, j + 0.5, j + 0.5, j - 0.5], [i - 0.5, i - 0.5, i + 0.5, i + 0.5]
        axes.fill(across, down, color=color, alpha=0.25 + 0.6 * share, lw=0)
        axes.text(j, i, str(counts[i, j]), ha="center", va="center", fontsize=7.5, color=BLACK)
    axes.xaxis.tick_top()
    for axis, names, rotation in ((axes.xaxis, columns, 90), (axes.yaxis, rows, 0)):
        axis.set_ticks(range(len(names)), [name.replace("_", " ") for name in names], rotation=rotation, fontsize=7.5)
        axis.set_ticks(np.arange(len(names) + 1) - 0.5, minor=True)
    axes.grid(visible=False, which="major")
    axes.grid(visible=True, which="minor", color="#DDDDDD", linewidth=0.5)
    axes.tick_params(length=0, which="both")
    figure.text(0.02, 1.0 - 0.12 / height, "concealed (rows), said (columns)", fontsize=9, weight="bold", va="top")
    return figure


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
    counted = summary["counted"]
    rows = [
        (name.replace("_", " "), value, *_count_and_bound(counted.get(name)), targets.get(name, ""))
        for name, value in summary.items()
        if name not in ("counted", "sizes", "by_effect")
    ]
    sizes = (
        f"{name}: size {_range(s['size'], 2)} of its range, {_range(s['visibility'], 3)} times the noise"
        for name, s in summary["sizes"].items()
    )
    caption = "Concealed-effect trial. Bound: one-sided, of the rate among cases drawn as these."
    if summary["sizes"]:
        caption += f" Smallest, median and largest of what was concealed: {'; '.join(sizes)}."
    return Table(("figure", "measured", "cases", "95 % bound", "to reach"), rows, caption)


def _count_and_bound(counted: dict[str, Any] | None) -> tuple[str, str]:
    if counted is None:
        return "", ""
    sign, bound = (">=", counted["at_least"]) if "at_least" in counted else ("<=", counted["at_most"])
    return f"{counted['count']} of {counted['of']}", f"{sign} {significant(bound, 2)}"


def _range(values: Sequence[float], digits: int) -> str:
    return ", ".join(significant(value, digits) for value in values)


def effects_table(summary: dict[str, Any]) -> Table:
    """One row per effect: how often right, the smallest found, the largest missed."""
    columns: dict[str, Callable[[dict[str, Any]], Cell]] = {
        "cases": itemgetter("cases"),
        "right": itemgetter("right"),
        "right, noticeable": itemgetter("right_noticeable"),
        "false names": itemgetter("false_names"),
        "smallest found": lambda of: _parameters(of["smallest_found"]),
        "its residual / noise": lambda of: of["smallest_found"] and of["smallest_found"]["residual_over_noise"],
        "largest missed, residual / noise": lambda of: (
            of["largest_missed"] and of["largest_missed"]["residual_over_noise"]
        ),
        "parameter error": itemgetter("parameter_error"),
    }
    rows = [[name, *(cell(of) for cell in columns.values())] for name, of in summary["by_effect"].items()]
    return Table(("effect", *columns), rows, "Effects one by one")


def _parameters(limit: dict[str, Any] | None) -> str:
    return "–" if limit is None else ", ".join(f"{symbol} {value:.3g}" for symbol, value in limit["parameters"].items())
