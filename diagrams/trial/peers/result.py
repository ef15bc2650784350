"""What a package made of one case, and the table of several."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Final, Self

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import significant

OURS: Final = "mmt_drake"
SYSID: Final = "mujoco.sysid"
SINDY: Final = "pysindy"

WITHOUT, WITH = "parameters", "parameters and friction"
"""What is free in a fit: the model's own parameters, or Coulomb friction beside them."""


@dataclass(frozen=True)
class Estimate:
    """A number found: `value`, and `half`, half the width of its 95 % interval as the package gives it, if it does."""

    value: float
    half: float | None = None

    def __str__(self) -> str:
        value = significant(self.value, 4)
        return value if self.half is None else f"{value} ± {significant(self.half, 2)}"


@dataclass(frozen=True)
class PeerResult:
    """One run of one package on one case.

    Attributes:
        tool, version: the package.
        setting: what was free, or what it was given.
        rate_hz: samples per second that it worked on.
        seconds: wall time of the fit alone, everything loaded and compiled, one thread.
        cpu_seconds: the same on the processor's clock, which other work on the machine does not lengthen.
        before_seconds: processor time of what it does before, once for all fits of a recording.
        simulations: how often it simulated the recording; None where it does not simulate.
        estimates: parameters found, by symbol of the model.
        error: RMS of measured less simulated force over the measured one's deviation, while in contact, force as
            recorded; None where nothing is simulated.
        names: effects that it says are missing, by the names of the library.
        says: its own words or equation, in one line.
    """

    tool: str
    version: str
    setting: str
    rate_hz: float
    seconds: float
    cpu_seconds: float
    before_seconds: float = 0.0
    simulations: int | None = None
    estimates: Mapping[str, Estimate] = field(default_factory=dict)
    error: float | None = None
    names: tuple[str, ...] = ()
    says: str = ""

    def to_json(self) -> dict[str, Any]:
        """The result as plain data."""
        return {**asdict(self), "names": list(self.names)}


def fits_tables(results: Sequence[PeerResult], case: str = "") -> list[Table]:
    """The fits of a case, a table for each set of numbers that is free, a row for each fit."""
    fits: dict[str, list[PeerResult]] = {}
    for r in results:
        if r.simulations is not None:
            fits.setdefault(r.setting, []).append(r)
    headers = ("package", "samples/s", "time [s]", "simulations", "error", "found (95 %)")
    return [
        Table(headers, [_fit_row(r) for r in rows], f"{case}: {setting} free".removeprefix(": "))
        for setting, rows in fits.items()
    ]


def _fit_row(r: PeerResult) -> list[Cell]:
    found = ", ".join(f"{symbol} {estimate}" for symbol, estimate in r.estimates.items())
    return [r.tool, r.rate_hz, r.cpu_seconds, r.simulations, r.error, found]


def speed_ratios(results: Sequence[PeerResult]) -> dict[tuple[str, float], float]:
    """(setting, rate [Hz]) -> time that mujoco.sysid takes over that of the project's own fit of the same numbers.

    Args:
        results: of one case. Times are those of the processor.
    """
    ours = {r.setting: r.cpu_seconds for r in results if r.tool == OURS}
    return {
        (r.setting, r.rate_hz): r.cpu_seconds / ours[r.setting]
        for r in results
        if r.tool == SYSID and r.setting in ours
    }


def speed_lines(results: Sequence[PeerResult]) -> list[str]:
    """How much longer mujoco.sysid takes for the same fit: a line for each set of numbers that is free."""
    ratios, lines = speed_ratios(results), []
    for own in (r for r in results if r.tool == OURS):
        times = [
            f"{significant(ratio, 3)} times as long at {rate:g} samples/s"
            for (setting, rate), ratio in ratios.items()
            if setting == own.setting
        ]
        before = f"{OURS} has prepared the recording, once for all its fits, in {significant(own.before_seconds, 2)} s"
        lines.append("; ".join([*([f"{SYSID} takes {', '.join(times)}"] if times else []), before]))
    return lines


def missing_lines(results: Sequence[PeerResult]) -> list[str]:
    """What each package says is missing, and its own words or equation; none is told that anything is."""
    asked = [r for r in results if r.setting != WITH]
    lines = [
        f"{r.tool}{f', {r.setting}' if r.tool == SINDY else ''}: {', '.join(r.names) or 'nothing'}. {r.says}"
        for r in asked
    ]
    return list(dict.fromkeys(lines))  # a fit at another rate mostly says the same


@dataclass
class Stopwatch:
    """Wall and processor time [s] of a `with` block."""

    seconds: float = 0.0
    cpu_seconds: float = 0.0

    def __enter__(self) -> Self:
        self.seconds, self.cpu_seconds = -time.perf_counter(), -time.process_time()
        return self

    def __exit__(self, *_: object) -> None:
        self.seconds += time.perf_counter()
        self.cpu_seconds += time.process_time()
