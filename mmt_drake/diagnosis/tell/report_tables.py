"""The tables of a report."""

from collections.abc import Iterable, Sequence

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagnosis.decide.block_replay import BlockReplay
from mmt_drake.diagnosis.tell.result import Diagnosis, NamedEffect, Values
from mmt_drake.diagnosis.tell.wording import all_words, words


def effect_table(effect: NamedEffect) -> Table | None:
    """An effect's numbers; None where it has none but a table or text."""
    rows = (
        (symbol, number.value, number.unit, *_ends(number.ci95))
        for symbol, number in effect.parameters.items()
        if isinstance(number.value, float | int)
    )
    return _table(["parameter", "value", "unit", "95 % from", "to"], rows)


def recordings_table(diagnosis: Diagnosis) -> Table | None:
    """Held-out errors of every recording; None where there is one only, or nothing was fitted."""
    if diagnosis.fit is None or not diagnosis.further_fits:
        return None
    rows = (
        (name, *map(in_percent, (e.nominal, e.refit, e.augmented, fit.noise_floor)))
        for name, fit in zip(diagnosis.recordings, (diagnosis.fit, *diagnosis.further_fits), strict=True)
        for e in (fit.heldout_nrmse,)
    )
    headers = ["recording", "nominal [%]", "refit [%]", "best [%]", "noise alone [%]"]
    return _table(headers, rows, "Error on what was held out of each recording, over the spread of what was measured.")


def parameter_table(diagnosis: Diagnosis) -> Table | None:
    """Structural parameters whose interval leaves out the nominal value; None where there is none."""
    rows = ((name, one.nominal, one.value, one.unit, *_ends(one.ci95)) for name, one in diagnosis.parameters.items())
    headers = ["parameter", "nominal", "found", "unit", "95 % from", "to"]
    return _table(headers, rows, "Only parameters whose interval excludes the nominal value.")


def curve_table(diagnosis: Diagnosis) -> Table | None:
    """Numbers that are free over something recorded, knot by knot; None where there is none."""
    rows: list[Sequence[Cell]] = []
    for one in diagnosis.curves:
        low, high = one.ci95 or ([None] * len(one.at), [None] * len(one.at))
        nominal = one.nominal or [None] * len(one.at)
        known = zip(one.at, nominal, one.value, low, high, strict=True)
        rows += [(one.number, one.over, at, was, value, one.unit, least, most) for at, was, value, least, most in known]
    headers = ["parameter", "over", "at", "nominal", "found", "unit", "95 % from", "to"]
    return _table(headers, rows, "Linear between the knots, and held beyond the first and the last.")


def candidate_table(diagnosis: Diagnosis) -> Table | None:
    """What was tried and what became of it, in the order of the diagnosis; None where nothing was."""
    rows = (
        (all_words(c.names), in_percent(c.heldout_nrmse), in_percent(c.delta), c.p_value, c.status, c.reason)
        for c in diagnosis.candidates
    )
    headers = ["explanation", "held-out error [%]", "gain [%]", "p", "verdict", "why"]
    caption = (
        "Best first. Gain: how much the held-out error falls against the refitted model without it. p: how likely "
        "chance alone puts the best one so far before it. A dash: too far behind to be fitted to the end."
    )
    return _table(headers, rows, caption)


def alternative_table(diagnosis: Diagnosis) -> Table | None:
    """Other explanations; None where there is none."""
    said = {True: "cannot be told apart", False: "less likely"}
    rows = (
        (words(one.name), in_percent(one.heldout_nrmse), said[one.indistinguishable], one.reason)
        for one in diagnosis.alternatives
    )
    return _table(["alternative", "held-out error [%]", "", "why"], rows)


def dependence_table(diagnosis: Diagnosis) -> Table | None:
    """The signals that the error follows; None where there is none."""
    rows = ((words(one.signal), 100.0 * one.score, one.where) for one in diagnosis.mismatch.depends_on)
    return _table(["signal", "explains [%] of the error", "where"], rows)


def block_table(replays: Iterable[BlockReplay]) -> Table:
    """One row per block and output: how far the recording is from the replay [%], and what that means."""
    rows = [(found.block, found.output, in_percent(found.nrmse), found.note) for found in replays]
    return Table(["block", "output", "off [%]", "which means"], rows)


def finding_table(diagnosis: Diagnosis) -> Table | None:
    """What the check before the diagnosis saw, worst first; None where it saw nothing."""
    said = {"refuse": "stops the diagnosis", "warn": "to be kept in mind", "note": "noted"}
    ordered = sorted(diagnosis.preflight, key=lambda finding: list(said).index(finding.severity))
    return _table(["", "what", "finding"], ((said[one.severity], words(one.code), one.text) for one in ordered))


def _table(headers: Sequence[str], rows: Iterable[Sequence[Cell]], caption: str = "") -> Table | None:
    """The table; None without rows."""
    rows = list(rows)
    return Table(headers, rows, caption) if rows else None


def _ends(interval: tuple[float | Values, float | Values] | None) -> list[Cell]:
    return [None, None] if interval is None else [None if isinstance(end, tuple) else end for end in interval]
