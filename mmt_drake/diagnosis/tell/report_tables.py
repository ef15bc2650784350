"""The tables of a report."""

from collections.abc import Iterable

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagnosis.decide.block_replay import BlockReplay
from mmt_drake.diagnosis.tell.result import Diagnosis, NamedEffect, Values
from mmt_drake.diagnosis.tell.wording import words


def effect_table(effect: NamedEffect) -> Table | None:
    """An effect's numbers; None where it has none but a table or text."""
    rows: list[list[Cell]] = [
        [symbol, number.value, number.unit, *_ends(number.ci95)]
        for symbol, number in effect.parameters.items()
        if isinstance(number.value, float | int)
    ]
    return Table(["parameter", "value", "unit", "95 % from", "to"], rows) if rows else None


def recordings_table(diagnosis: Diagnosis) -> Table | None:
    """Held-out errors of every recording; None where there is one only, or nothing was fitted."""
    if diagnosis.fit is None or not diagnosis.further_fits:
        return None
    rows: list[list[Cell]] = [
        [name, *map(in_percent, (e.nominal, e.refit, e.augmented, fit.noise_floor))]
        for name, fit in zip(diagnosis.recordings, (diagnosis.fit, *diagnosis.further_fits), strict=True)
        for e in (fit.heldout_nrmse,)
    ]
    headers = ["recording", "nominal [%]", "refit [%]", "best [%]", "noise alone [%]"]
    return Table(headers, rows, "Error on what was held out of each recording, over the spread of what was measured.")


def parameter_table(diagnosis: Diagnosis) -> Table | None:
    """Structural parameters whose interval leaves out the nominal value; None where there is none."""
    rows: list[list[Cell]] = [
        [name, one.nominal, one.value, one.unit, *_ends(one.ci95)] for name, one in diagnosis.parameters.items()
    ]
    headers = ["parameter", "nominal", "found", "unit", "95 % from", "to"]
    return Table(headers, rows, "Only parameters whose interval excludes the nominal value.") if rows else None


def candidate_table(diagnosis: Diagnosis) -> Table | None:
    """What was tried and what became of it, in the order of the diagnosis; None where nothing was."""
    rows: list[list[Cell]] = [
        [
            " + ".join(words(name) for name in one.names),
            in_percent(one.heldout_nrmse),
            in_percent(one.delta),
            one.p_value,
            one.status,
            one.reason,
        ]
        for one in diagnosis.candidates
    ]
    headers = ["explanation", "held-out error [%]", "gain [%]", "p", "verdict", "why"]
    caption = (
        "Best first. Gain: how much the held-out error falls against the refitted model without it. p: how likely "
        "chance alone puts the best one so far before it. A dash: too far behind to be fitted to the end."
    )
    return Table(headers, rows, caption) if rows else None


def alternative_table(diagnosis: Diagnosis) -> Table | None:
    """Other explanations; None where there is none."""
    rows: list[list[Cell]] = [
        [
            words(one.name),
            in_percent(one.heldout_nrmse),
            "cannot be told apart" if one.indistinguishable else "less likely",
            one.reason,
        ]
        for one in diagnosis.alternatives
    ]
    return Table(["alternative", "held-out error [%]", "", "why"], rows) if rows else None


def dependence_table(diagnosis: Diagnosis) -> Table | None:
    """The signals that the error follows; None where there is none."""
    rows: list[list[Cell]] = [
        [words(one.signal), 100.0 * one.score, one.where] for one in diagnosis.mismatch.depends_on
    ]
    return Table(["signal", "explains [%] of the error", "where"], rows) if rows else None


def block_table(replays: Iterable[BlockReplay]) -> Table:
    """One row per block and output: how far the recording is from the replay [%], and what that means."""
    rows: list[list[Cell]] = [[found.block, found.output, in_percent(found.nrmse), found.note] for found in replays]
    return Table(["block", "output", "off [%]", "which means"], rows)


def finding_table(diagnosis: Diagnosis) -> Table | None:
    """What the check before the diagnosis saw, worst first; None where it saw nothing."""
    said = {"refuse": "stops the diagnosis", "warn": "to be kept in mind", "note": "noted"}
    ordered = sorted(diagnosis.preflight, key=lambda finding: list(said).index(finding.severity))
    rows: list[list[Cell]] = [[said[one.severity], words(one.code), one.text] for one in ordered]
    return Table(["", "what", "finding"], rows) if rows else None


def _ends(interval: tuple[float | Values, float | Values] | None) -> list[Cell]:
    return [None, None] if interval is None else [None if isinstance(end, tuple) else end for end in interval]
