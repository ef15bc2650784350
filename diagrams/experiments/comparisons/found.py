"""Times at which parameters are found, and verdicts on them where the noise would allow it."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from mmt_drake.analysis.signals import contact_time, flag, mean_step
from mmt_drake.analysis.wording import percent, significant
from mmt_drake.diagrams.experiments.comparisons.bound import NEAR
from mmt_drake.diagrams.experiments.targets import FOUND_S
from mmt_drake.diagrams.experiments.targets import found as target
from mmt_drake.diagrams.studies.figures import NOISE_FORBIDS, Reached
from mmt_drake.recording import Recording

Times = Mapping[str, float | None]
"""Parameter -> contact time [s]; None is never."""

FOUND: Final = ("m", "k2", "b1", "b2", "Fc")


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


def parameters_found(
    case: str, found: Times, allowed: Times | None = None, *, updates: str | None = None
) -> dict[str, Reached]:
    """When each parameter was found; without a verdict where the noise alone does not allow it in time.

    Args:
        case: whose.
        found: of `times_found`.
        allowed: parameter -> contact time after which the noise would allow it (`bound.NoiseBound`); where nobody asked
            for that bound every parameter is to be found in time.
        updates: of the case's renderer.
    """
    figures = {}
    for name, time in found.items():
        bound = None if allowed is None else allowed[name]
        forbidden = allowed is not None and (bound is None or bound > FOUND_S)
        unasked = NOISE_FORBIDS if forbidden else ""
        figures[name] = Reached(case, target(name), time, bound, updates, never=time is None, unasked=unasked)
    return figures


def told(name: str, figures: Mapping[str, Reached]) -> str:
    """The verdicts of one case, `parameters_found`, in a sentence."""
    in_time, late, unasked = (
        [each for each, figure in figures.items() if figure.reached is verdict] for verdict in (True, False, None)
    )
    slow = [
        f"{each} ({_seconds(figures[each].value)} s, noise alone {_seconds(figures[each].bound)} s)" for each in late
    ]
    parts = [
        f"{name}: {', '.join(in_time) or 'nothing'} within {percent(NEAR)} after {FOUND_S:g} s of contact",
        f"late, though the force's noise alone would allow it: {', '.join(slow) or 'nothing'}",
    ]
    if unasked:
        parts.append(f"not to be asked by that bound: {', '.join(unasked)}")
    return "; ".join(parts) + "."


def _seconds(time: float | None) -> str:
    return "–" if time is None else significant(time, 3)
