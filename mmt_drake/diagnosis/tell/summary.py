"""A diagnosis in one paragraph."""

from __future__ import annotations

from typing import Final

from mmt_drake.diagnosis.tell.result import Diagnosis, NamedEffect
from mmt_drake.diagnosis.tell.wording import words

MOST_WARNINGS: Final = 3
"""More are counted only: the report has them all."""

_ACCOUNTED_FOR: Final = {
    "bias": {"force_bias", "force_drift"},
    "hum": {"periodic_disturbance"},
    "offset": {"time_delay", "force_lag"},
    "saturation": {"force_saturation"},
}
"""Warnings that say what an effect says already."""


def summary_of(diagnosis: Diagnosis) -> str:
    """What was found, what to do about it, and what to keep in mind with it, for a person who acts on it."""
    parts = (_verdict(diagnosis), _errors(diagnosis), _where(diagnosis), _warnings(diagnosis))
    return " ".join(part for part in parts if part)


def _verdict(d: Diagnosis) -> str:
    if d.verdict == "no_mismatch":
        return "The nominal model explains the recording to its noise; nothing needs to be changed."
    if d.verdict == "parameters":
        changes = ", ".join(f"{name} {p.nominal:.4g} -> {p.value:.4g} {p.unit}" for name, p in d.parameters.items())
        return f"The structure is right, but values were not: {changes}."
    if d.verdict == "missing_physics":
        return f"The model leaves out {_listed(d.effects)}."
    if d.verdict == "ambiguous":
        others = ", or ".join(words(a.name) for a in d.alternatives if a.indistinguishable)
        return f"The model leaves out {_listed(d.effects)}; these recordings cannot tell it from {others}."
    if d.verdict == "unexplained":
        return "Something real is missing from the model, and no effect of the library was found to explain it."
    return d.summary


def _listed(effects: tuple[NamedEffect, ...]) -> str:
    told = []
    for effect in effects:
        numbers = ", ".join(
            f"{symbol} = {p.value:.4g}" + (f" {p.unit}" if p.unit != "1" else "")
            for symbol, p in effect.parameters.items()
            if isinstance(p.value, float)
        )
        told.append(f"{words(effect.name)} ({numbers})")
    return " and ".join(told)


def _errors(d: Diagnosis) -> str:
    if d.fit is None or d.fit.heldout_nrmse.nominal is None:
        return ""
    e, floor = d.fit.heldout_nrmse, d.fit.noise_floor
    told = f"On held-out data the error is {e.nominal:.3g} with the model handed in"
    if d.verdict != "no_mismatch" and e.refit is not None:
        told += f", {e.refit:.3g} with its parameters fitted"
        if d.verdict in ("missing_physics", "ambiguous") and e.augmented is not None:
            told += f", {e.augmented:.3g} with what was missing"
    return told + (f"; noise alone would leave {floor:.3g}." if floor is not None else ".")


def _where(d: Diagnosis) -> str:
    if d.verdict not in ("unexplained", "ambiguous") or not d.mismatch.blocks:
        return ""
    block = d.mismatch.blocks[0]
    told = f"It most likely acts in the block {block.block.replace('_', ' ')}"
    if d.mismatch.depends_on and d.mismatch.depends_on[0].score > 0.1:
        told += f", and follows the {d.mismatch.depends_on[0].signal.replace('_', ' ')}"
    return told + "."


def _warnings(d: Diagnosis) -> str:
    """What the check of the recordings warned of, but for what the effects account for."""
    names = {effect.name for effect in d.effects}
    told = [f.text for f in d.preflight if f.severity == "warn" and not names & _ACCOUNTED_FOR.get(f.code, set())]
    if not told:
        return ""
    left = len(told) - MOST_WARNINGS
    more = f" And {left} more (see the report)." if left > 0 else ""
    return f"Keep in mind: {' '.join(told[:MOST_WARNINGS])}{more}"
