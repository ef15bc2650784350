"""The tables of a report: numbers to three digits, or as many as their intervals know."""

import math
from collections.abc import Iterable, Sequence
from typing import Final

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.decide.block_replay import BlockReplay
from mmt_drake.diagnosis.tell.figures_common import NAMES
from mmt_drake.diagnosis.tell.provenance import Provenance
from mmt_drake.diagnosis.tell.result import Diagnosis, NamedEffect
from mmt_drake.diagnosis.tell.wording import all_words, bounded, capitalised, in_degrees, rms_words
from mmt_drake.effects.wording import words

DIGITS: Final = 3
"""Of a number in a table."""


def effect_table(effect: NamedEffect) -> Table | None:
    """An effect's numbers; None where it has none but a table or text."""
    return _table(["parameter", "value", "95 % interval", "unit"], effect_rows(effect))


def effect_rows(effect: NamedEffect) -> list[tuple[str, str, str | None, str]]:
    """Symbol, value, 95 % interval and unit of each number of an effect; the interval is None where it is unknown."""
    return [
        (symbol, *bounded(number.value, number.ends), number.unit)
        for symbol, own in effect.parameters.items()
        if isinstance((number := in_degrees(effect, own)).value, float | int)
    ]


def recordings_table(diagnosis: Diagnosis) -> Table | None:
    """Held-out RMS errors of every recording; None where there is one only, or nothing was fitted."""
    if diagnosis.fit is None or not diagnosis.further_fits:
        return None
    rows = (
        (
            name,
            *(
                None if error is None else rms_words(fit, error)
                for error in (*vars(fit.heldout_nrmse).values(), fit.noise_floor)
            ),
        )
        for name, fit in zip(diagnosis.recordings, (diagnosis.fit, *diagnosis.further_fits), strict=True)
    )
    return _table(
        ["recording", *NAMES.values(), "noise alone"], rows, "RMS error on what was held out of each recording."
    )


def parameter_table(diagnosis: Diagnosis) -> Table | None:
    """Structural parameters whose interval leaves out the nominal value; None where there is none."""
    rows = (
        (name, significant(one.nominal, 3), *bounded(one.value, one.ci95), one.unit)
        for name, one in diagnosis.parameters.items()
    )
    headers = ["parameter", "handed in", "found", "95 % interval", "unit"]
    return _table(headers, rows, "Only parameters whose interval leaves out the value handed in.")


def curve_table(diagnosis: Diagnosis) -> Table | None:
    """Numbers that are free over something recorded, knot by knot; None where there is none."""
    rows: list[Sequence[Cell]] = []
    for one in diagnosis.curves:
        ends = [None] * len(one.at) if one.ci95 is None else [*zip(*one.ci95, strict=True)]
        nominal = one.nominal or [None] * len(one.at)
        for at, was, value, interval in zip(one.at, nominal, one.value, ends, strict=True):
            rows.append((one.number, one.over, at, was, *bounded(value, interval), one.unit))
    headers = ["parameter", "over", "at", "handed in", "found", "95 % interval", "unit"]
    return _table(headers, rows, "Linear between the knots, and held beyond the first and the last.")


def candidate_table(diagnosis: Diagnosis) -> Table | None:
    """What was tried and what became of it, by held-out error; None where nothing was."""
    told = {
        "accepted": "delivered",
        "ambiguous": "cannot be told apart",
        "at a bound": "at a bound",
        "rejected": "not taken",
    }
    ordered = sorted(diagnosis.candidates, key=lambda c: math.inf if c.heldout_nrmse is None else c.heldout_nrmse)
    rows = (
        (capitalised(all_words(c.names)), _rms(diagnosis, c.heldout_nrmse), told[c.status], c.reason) for c in ordered
    )
    headers = ["explanation", f"held-out error{_unit(diagnosis)}", "verdict", "why"]
    caption = (
        "By held-out error (RMS), the lowest first. It does not choose: names are chosen on the fitted blocks, each "
        "left out in turn, and the held-out ones confirm them. A dash: its simulation diverges, or was not run."
    )
    return _table(headers, rows, caption)


def alternative_table(diagnosis: Diagnosis) -> Table | None:
    """Other explanations; None where there is none."""
    said = {True: "cannot be told apart", False: "less likely"}
    rows = (
        (capitalised(words(one.name)), _rms(diagnosis, one.heldout_nrmse), said[one.indistinguishable], one.reason)
        for one in diagnosis.alternatives
    )
    return _table(["alternative", f"held-out error{_unit(diagnosis)}", "verdict", "why"], rows)


def hash_table(provenance: Provenance) -> Table | None:
    """The files that were read, with all digits of their hashes; None where there is none."""
    return _table(["file", "sha256"], [(one.name, one.sha256) for one in provenance.files if one.sha256 is not None])


def block_table(replays: Iterable[BlockReplay]) -> Table:
    """One row per block and output: how far the recording is from the replay, and what that means."""
    rows = [(found.block, found.output, found.nrmse, found.note) for found in replays]
    caption = "Off: RMS of the difference over the standard deviation of what was recorded."
    return Table(["block", "output", "off", "which means"], rows, caption, DIGITS)


def finding_table(diagnosis: Diagnosis) -> Table | None:
    """What the check before the diagnosis saw, worst first; None where it saw nothing."""
    said = {"refuse": "stops the diagnosis", "warn": "to be kept in mind", "note": "noted"}
    ordered = sorted(diagnosis.preflight, key=lambda finding: list(said).index(finding.severity))
    return _table(["", "what", "finding"], ((said[one.severity], words(one.code), one.text) for one in ordered))


def _table(headers: Sequence[str], rows: Iterable[Sequence[Cell]], caption: str = "") -> Table | None:
    """The table; None without rows."""
    rows = list(rows)
    return Table(headers, rows, caption, DIGITS) if rows else None


def _rms(diagnosis: Diagnosis, nrmse: float | None) -> float | None:
    """Of the first recording; over the spread of what was measured where that is unknown."""
    rms = None if diagnosis.fit is None or nrmse is None else diagnosis.fit.rms(nrmse)
    return nrmse if rms is None else rms


def _unit(diagnosis: Diagnosis) -> str:
    if diagnosis.fit is None or diagnosis.fit.spread is None:
        return " / measured spread"
    return f" [{diagnosis.fit.unit}]" if diagnosis.fit.unit else ""
