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
    simulations: int | None = None
    estimates: Mapping[str, Estimate] = field(default_factory=dict)
    error: float | None = None
    names: tuple[str, ...] = ()
    says: str = ""

    def to_json(self) -> dict[str, Any]:
        """The result as plain data."""
        return {**asdict(self), "names": list(self.names)}


def peers_table(results: Sequence[PeerResult], caption: str = "") -> Table:
    """One row per run."""
    rows: list[list[Cell]] = [
        [
            r.tool,
            r.setting,
            r.rate_hz,
            r.seconds,
            "–" if r.simulations is None else str(r.simulations),
            r.error,
            ", ".join(f"{symbol} {estimate}" for symbol, estimate in r.estimates.items()) or "–",
            ", ".join(r.names) or "–",
            r.says,
        ]
        for r in results
    ]
    headers = ("package", "free", "Hz", "seconds", "simulations", "error", "estimates (95 %)", "names", "says")
    return Table(headers, rows, caption)


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
