"""When parameters are found, and whether that is in time where the noise would allow it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from diagrams.experiments.comparisons.bound import NEAR
from mmt_drake.analysis.signals import contact_time, flag, mean_step
from mmt_drake.analysis.table import Cell
from mmt_drake.analysis.wording import percent, significant
from mmt_drake.recording import Recording

Times = Mapping[str, float | None]
"""Parameter -> contact time [s]; None is never."""

FOUND: Final = ("m", "k2", "b1", "b2", "Fc")
IN_TIME_S: Final = 3.0
"""Contact time [s] within which a parameter has to be found if the noise alone would allow that."""
IN_TIME, LATE, NOT_ASKED = "in time", "late", "not asked"


def times_found(recording: Recording, true: Mapping[str, float]) -> dict[str, float | None]:
    """Contact time [s] from which on each parameter stays near the truth; None where it does not."""
    touched = contact_time(flag(recording, "in_contact"), mean_step(recording))
    found: dict[str, float | None] = {}
    for name in FOUND:
        near = np.abs(recording[f"theta_{name}"] - true[name]) <= NEAR * true[name]
        astray = np.flatnonzero(~near)
        first = 0 if len(astray) == 0 else int(astray[-1]) + 1
        found[name] = float(touched[first]) if first < len(touched) else None
    return found


def verdicts(found: Times, allowed: Times) -> dict[str, str]:
    """Of each parameter: found `IN_TIME`, `LATE`, or `NOT_ASKED` where the noise alone does not allow it in time."""

    def within(time: float | None) -> bool:
        return time is not None and time <= IN_TIME_S

    return {name: (IN_TIME if within(found[name]) else LATE) if within(allowed[name]) else NOT_ASKED for name in FOUND}


def cells(found: Times, allowed: Times) -> list[Cell]:
    """Of each parameter: found after / noise alone would allow after [s]."""
    return [f"{_seconds(found[name])} / {_seconds(allowed[name])}" for name in FOUND]


def told(name: str, found: Times, allowed: Times) -> str:
    """The verdicts of one case in a sentence."""
    said = verdicts(found, allowed)
    by = {verdict: [each for each in FOUND if said[each] == verdict] for verdict in (IN_TIME, LATE, NOT_ASKED)}
    late = [f"{each} ({_seconds(found[each])} s, noise alone {_seconds(allowed[each])} s)" for each in by[LATE]]
    parts = [
        f"{name}: {', '.join(by[IN_TIME]) or 'nothing'} within {percent(NEAR)} after {IN_TIME_S:g} s of contact",
        f"late, though the force's noise alone would allow it: {', '.join(late) or 'nothing'}",
    ]
    if by[NOT_ASKED]:
        parts.append(f"not to be asked by that bound: {', '.join(by[NOT_ASKED])}")
    return "; ".join(parts) + "."


def _seconds(time: float | None) -> str:
    return "–" if time is None else significant(time, 3)
