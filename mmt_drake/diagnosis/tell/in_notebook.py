"""A diagnosis as a notebook shows it: verdict, shares, numbers, next step."""

from html import escape

from mmt_drake.analysis.table import Table
from mmt_drake.diagnosis.tell.report_tables import effect_table, parameter_table
from mmt_drake.diagnosis.tell.result import Diagnosis
from mmt_drake.diagnosis.tell.wording import PERCENT, part_words, share_words
from mmt_drake.effects.wording import words
from mmt_drake.notebook import html_table


def as_html(diagnosis: Diagnosis) -> str:
    """A part of a page, with nothing fetched from elsewhere."""
    parts = [f"<p><b>{escape(words(diagnosis.verdict))}</b>: {escape(diagnosis.summary)}</p>"]
    if diagnosis.budget:
        shares = [(part_words(part.part, diagnosis.effects), share_words(part.share)) for part in diagnosis.budget]
        parts.append(html_table(["part of the error", "share"], shares))
        parts.append(f"<p><small>{PERCENT}</small></p>")
    for effect in diagnosis.effects:
        depth = "" if effect.certain is None else f", certain: {effect.certain}"
        parts.append(f"<p>{escape(words(effect.name))} ({escape(effect.block)}{depth})</p>")
        parts.append(_html(effect_table(effect)))
    parts.append(_html(parameter_table(diagnosis)))
    if diagnosis.next_recording is not None:
        parts.append(f"<p>next recording: {escape(diagnosis.next_recording)}</p>")
    return "".join(parts)


def _html(table: Table | None) -> str:
    return "" if table is None else html_table(table.headers, table.texts())
