"""A first model in words: the table of its numbers, what to think of them, and its file."""

import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

from mmt_drake.analysis.table import Table
from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide.gate import NOTHING_LEFT
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.summary import summary_of
from mmt_drake.model_files import Model, model_data, save_model

FIRST_MODEL: Final = "first_model.yaml"
"""Beside the document of a diagnosis that was given no model."""


Told = Literal["determined", "at most", "of this structure", "cannot be told"]


@dataclass(frozen=True)
class FirstNumber:
    """A number of a first model.

    Attributes:
        symbol: of the model file, `normal.k` and `normal.b` for the normal axis.
        value: in the model.
        unit: its unit.
        ci95: 95 % interval, over all minima that the recordings do not tell apart; from 0 or as far as it was sought
            where they do not tell it.
        told: `determined`: neither end of the interval is where the search ended; `of this structure`: nor is it, but
            more than noise is left; `at most`: the lower end is, so it may as well be nothing; else `cannot be told`.
    """

    symbol: str
    value: float
    unit: str
    ci95: tuple[float, float]
    told: Told


@dataclass(frozen=True)
class FirstModel:
    """What recordings alone tell of a model.

    Attributes:
        model: the model.
        numbers: each of its numbers that was sought.
        heldout: held-out error of each recording (`fit.heldout_nrmse` of a diagnosis).
        noise: what noise alone would leave there.
        left: what the model leaves beyond the noise, over the sensor's own noise (`NoiseReference.left`).
        minima: sets of numbers that these recordings do not tell apart.
        findings: what the check before the fit saw.
        reason: why nothing can be told, and `model` is any; None if something can.
        caution: what else to keep in mind, as that the numbers are not in the recording's own units; or None.
    """

    model: Model
    findings: tuple[Finding, ...]
    numbers: tuple[FirstNumber, ...] = ()
    heldout: tuple[float, ...] = ()
    noise: tuple[float, ...] = ()
    left: float = math.inf
    minima: int = 0
    reason: str | None = None
    caution: str | None = None

    @property
    def explains(self) -> bool:
        """Whether next to nothing but noise is left, so that intervals are what they say."""
        return self.left <= NOTHING_LEFT


def numbers_table(found: FirstModel) -> Table:
    """Each number, with its unit, its 95 % interval, and whether it is told."""
    rows = [[n.symbol, _three(n.value), n.unit, _interval(n), n.told] for n in found.numbers]
    return Table(["number", "value", "unit", "95 % interval", "told"], rows)


def remarks(found: FirstModel) -> list[str]:
    """What to keep in mind with the numbers, a sentence each; the held-out error first, where they were fitted."""
    said = _fitted_remarks(found) if found.heldout else []
    if found.caution is not None:
        said.append(found.caution)
    return [*said, *(finding.text for finding in found.findings if finding.severity == "warn")]


def _fitted_remarks(found: FirstModel) -> list[str]:
    errors = ", ".join(significant(error, 3) for error in found.heldout)
    noise = ", ".join(significant(error, 3) for error in found.noise)
    said = [f"Held-out error: {errors} of the spread of what was measured; noise alone would leave {noise}."]
    if not found.explains:
        said.append(
            f"More is left than noise ({significant(found.left, 2)} times the sensor's): the structure lacks physics, "
            "and the numbers are those of a model without. `mmt-drake diagnose` looks for what is missing."
        )
    if found.minima > 1:
        said.append(f"These recordings do not tell {found.minima} sets of numbers apart; intervals span all of them.")
    untold = [n.symbol for n in found.numbers if n.told == "cannot be told"]
    if untold:
        said.append(f"Cannot be told from these recordings: {', '.join(untold)}; the value is one of many that do.")
    zero = [n.symbol for n in found.numbers if n.told == "at most" and n.value == 0.0]
    if zero:
        said.append(f"May as well be 0, and is 0 in the model: {', '.join(zero)}.")
    return said


def save_first_model(found: FirstModel, path: str | Path, sources: list[str]) -> None:
    """Write the model file, with the numbers' intervals as comments.

    Raises:
        BadInput: it cannot be written.
    """
    lines = [f"{n.symbol} [{n.unit}]: {_interval(n)}, {n.told}" for n in found.numbers]
    head = f"A first model, fitted to {', '.join(sources)} alone. 95 % intervals:"
    save_model(path, model_data(found.model), "\n".join([head, *lines, *remarks(found)]))


def with_first_model(outcome: Outcome, found: FirstModel) -> Outcome:
    """The outcome of a diagnosis of a first model, which says so."""
    if found.reason is not None:
        return outcome
    told = ", ".join(f"{n.symbol} {_three(n.value)} {n.unit}" for n in found.numbers)
    head = f"No model was handed in; one was fitted to the recordings first ({FIRST_MODEL}: {told}), and stands for it."
    named = replace(outcome.diagnosis, first_model=FIRST_MODEL)
    said = named.summary if named.fit is None else summary_of(named)  # where nothing was fitted it is the reason
    return replace(outcome, diagnosis=replace(named, summary=f"{head} {said}"))


def first_document(found: FirstModel) -> dict[str, Any]:
    """Plain values, as `fit --json` prints them."""
    return {
        "structure": found.model.NAME,
        "numbers": [{**asdict(n), "ci95": [_finite(end) for end in n.ci95]} for n in found.numbers],
        "heldout_nrmse": list(found.heldout),
        "noise_floor": list(found.noise),
        "explains": found.explains,
        "left": found.left,
        "minima": found.minima,
        "remarks": remarks(found),
    }


def _interval(n: FirstNumber) -> str:
    """With as many digits as tell its ends apart."""
    low, high = n.ci95
    size = max(abs(low), abs(high)) / max(high - low, 1e-300)
    digits = max(3, 2 + math.ceil(math.log10(size))) if 1.0 < size < math.inf else 3
    return f"{significant(low, digits)} to {significant(high, digits)}"


def _three(value: float) -> str:
    return significant(value, 3)


def _finite(end: float) -> float | None:
    return end if math.isfinite(end) else None
