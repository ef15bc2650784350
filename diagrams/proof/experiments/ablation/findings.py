"""Findings of the ablation, in sentences that are made from its verdicts."""

from collections.abc import Iterable, Sequence
from itertools import combinations, groupby
from typing import Final

from mmt_drake.diagrams.proof.experiments.ablation.claims import CLAIMS, REFERENCES, Claim
from mmt_drake.diagrams.proof.experiments.ablation.run import Verdict
from mmt_drake.diagrams.proof.experiments.changes import Cause

_FIGURES: Final = frozenset(figure for claim in CLAIMS for figure in claim.figures)
_FEW: Final = 4  # names in a sentence; a table has them all


def findings(verdicts: Sequence[Verdict]) -> list[str]:
    """What came out, figure by figure and together; every name and number is the result's."""
    sentences = [_figure_sentence(verdicts, claim) for claim in CLAIMS] + conclusions(verdicts)
    return sentences + [sentence for reference in REFERENCES for sentence in _most(verdicts, reference)]


def conclusions(verdicts: Sequence[Verdict]) -> list[str]:
    """Which figures need a cause, by the force that was measured; nothing without a run that has no cause in it."""
    bare, moved = ([verdict for verdict in verdicts if verdict.cause.group == group] for group in ("none", "hand"))
    if not bare:
        return []
    (raw, filtered), (raw_bare, filtered_bare), (raw_moved, filtered_moved) = (
        [_figures(among, reference) for reference in REFERENCES] for among in (verdicts, bare, moved)
    )
    says = {
        "Whichever force was measured, no cause is needed for": raw_bare & filtered_bare,
        "If it was the raw force, none is needed for": raw_bare - filtered_bare,
        "If it was the filtered force, none is needed for": filtered_bare - raw_bare,
        "The filtered force, or the raw force and a cause: these runs do not tell which for": (filtered_bare - raw_bare)
        & raw,
        "If it was the raw force, no more than another motion of the hand is needed for": raw_moved - raw_bare,
        "If it was the filtered force, no more than another motion of the hand is needed for": filtered_moved
        - filtered_bare,
        "Only against the filtered force does any run here show": filtered - raw,
        "Only against the raw force does any run here show": raw - filtered,
        "Whichever was measured, a cause is needed for": (raw | filtered) - raw_bare - filtered_bare,
        "Nothing here reproduces": _FIGURES - raw - filtered,
    }
    return [f"{what} {ranges(figures)}." for what, figures in says.items() if figures]


def _figures(verdicts: Sequence[Verdict], reference: str) -> set[int]:
    """The numbers of the figures that any of these reproduces."""
    return {figure for verdict in verdicts for figure in verdict.figures(reference)}


def _most(verdicts: Sequence[Verdict], reference: str) -> list[str]:
    """How many figures one cause, several together and any two in runs of their own reproduce."""
    sentences = []
    against = f"Against the {reference} force"
    for what, groups in (
        ("one cause reproduces", ("estimator", "plant", "renderer", "hand")),
        ("several together reproduce", ("together",)),
    ):
        among = [verdict for verdict in verdicts if verdict.cause.group in groups]
        if not among:
            continue
        most = max(len(verdict.figures(reference)) for verdict in among)
        best = [verdict for verdict in among if len(verdict.figures(reference)) == most]
        missing = _FIGURES.difference(best[0].figures(reference))
        left = f", all but {ranges(missing)}" if len(best) == 1 and missing else ""
        names = _few([verdict.cause.name for verdict in best])
        sentences.append(f"{against} {what} at most {most} of the {len(_FIGURES)} figures{left}: {names}.")
    return sentences + _pairs_sentence(verdicts, reference, against)


def _pairs_sentence(verdicts: Sequence[Verdict], reference: str, against: str) -> list[str]:
    """Which two causes, each by itself, reproduce more figures between them than any one does."""
    alone = {v.cause.name: set(v.figures(reference)) for v in verdicts if v.cause.group not in ("none", "together")}
    shown = {(one, other): len(alone[one] | alone[other]) for one, other in combinations(alone, 2)}
    most = max(shown.values(), default=0)
    if most <= max(map(len, alone.values()), default=0):
        return []
    best = _few([" and ".join(pair) for pair, count in shown.items() if count == most])
    return [f"{against} two causes, each in runs of its own, reproduce at most {most} of {len(_FIGURES)}: {best}."]


def reproducing(verdicts: Sequence[Verdict], claim: Claim, reference: str) -> list[Cause]:
    """The causes that reproduce what a figure shows, against one of `REFERENCES`."""
    return [verdict.cause for verdict in verdicts if claim in verdict.reproduced(reference)]


def _figure_sentence(verdicts: Sequence[Verdict], claim: Claim) -> str:
    name = f"Figure{'s' if len(claim.figures) > 1 else ''} {claim.name}: {claim.says}"
    by = (f"Against the {reference} force {_reproduced(verdicts, claim, reference)}." for reference in REFERENCES)
    return " ".join([name, *by])


def _reproduced(verdicts: Sequence[Verdict], claim: Claim, reference: str) -> str:
    by = reproducing(verdicts, claim, reference)
    alone = [cause.name for cause in by if cause.group not in ("together", "none")]
    together = [cause.name for cause in by if cause.group == "together"]
    if len(by) == len(verdicts):
        return "reproduced whatever is put in"
    if not by:
        return "reproduced by nothing here"
    inherent = "with nothing put in, too; " if any(cause.group == "none" for cause in by) else ""
    by_alone = f"by {_few(alone)} alone" if alone else "by no single cause"
    return f"reproduced {inherent}{by_alone}{f'; together by {_few(together)}' if together else ''}"


def _few(names: Sequence[str]) -> str:
    """The first names of many."""
    shown = listed(names[:_FEW])
    return shown if len(names) <= _FEW else f"{shown} and {len(names) - _FEW} more"


def listed(things: Sequence[object]) -> str:
    """Separated by commas."""
    return ", ".join(map(str, things))


def ranges(figures: Iterable[int]) -> str:
    """Numbers in order, three or more in a row as `24 to 30`."""
    rows = groupby(enumerate(sorted(figures)), key=lambda pair: pair[1] - pair[0])
    found = [[figure for _, figure in row] for _, row in rows]
    return ", ".join(f"{row[0]} to {row[-1]}" if len(row) > 2 else listed(row) for row in found)
