"""The thesis's two tables of physics engines (appendix E, figures 18 and 19): objects, frequencies, printed figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from types import MappingProxyType
from typing import Any, Final

from mmt_drake.model.linear import transfer_function
from mmt_drake.model.parameters import BoxParameters


@dataclass(frozen=True)
class PrintedTable:
    """One table of the thesis.

    Attributes:
        name: ours, a letter.
        source: where the thesis prints it.
        parameters: the object, as printed.
        omega: frequencies of the sine that moves the probe [rad/s].
        expected: the amplitude of the force over that of the position that it prints as the right one, at each.
        printed: engine -> what it prints for that engine, at each.
    """

    name: str
    source: str
    parameters: BoxParameters
    omega: tuple[float, ...]
    expected: tuple[float, ...]
    printed: Mapping[str, tuple[float, ...]]

    def exchanged(self) -> PrintedTable:
        """The same with b1 and b2 exchanged."""
        p = self.parameters
        return replace(self, parameters=replace(p, b1=p.b2, b2=p.b1))

    def to_json(self) -> dict[str, Any]:
        """One entry of `thesis` of `experiment engines --json`: what it prints, beside what is exact."""
        return {
            "table": self.name,
            "source": self.source,
            "parameters": asdict(self.parameters),
            "omega": list(self.omega),
            "expected": list(self.expected),
            "exact": [abs(point.exact) for point in self.points()],
            "exact_b1_b2_exchanged": [abs(point.exact) for point in self.exchanged().points()],
            "printed": {engine: list(figures) for engine, figures in self.printed.items()},
        }

    def points(self) -> Iterator[Point]:
        """Its columns."""
        for column, omega in enumerate(self.omega):
            printed = {engine: figures[column] for engine, figures in self.printed.items()}
            yield Point(self.name, self.parameters, omega, self.expected[column], printed)


@dataclass(frozen=True)
class Point:
    """One column of a table: an object at one frequency [rad/s], and what the thesis prints there."""

    table: str
    parameters: BoxParameters
    omega: float
    expected: float
    printed: Mapping[str, float]

    @property
    def exact(self) -> complex:
        """H(j omega), what force over position has to be [N/m]."""
        return complex(transfer_function(self.parameters, 1j * self.omega))


TABLES: Final = (
    PrintedTable(
        name="A",
        source="appendix E, figure 18",
        parameters=BoxParameters(m=1.0, k1=10.0, k2=10.0, b1=1.0, b2=1.0),
        omega=(1.0, 4.32),
        expected=(0.64, 4.2),
        printed=MappingProxyType(
            {"ode": (0.58, 0.99), "bullet": (1.43, 1.15), "simbody": (0.65, 0.98), "dart": (0.35, 0.9)}
        ),
    ),
    # The mass is not printed: 0.5 kg puts the resonance to 6.32 rad/s, where the thesis tests 6.27 rad/s.
    PrintedTable(
        name="B",
        source="appendix E, figure 19",
        parameters=BoxParameters(m=0.5, k1=0.0, k2=20.0, b1=0.1, b2=0.5),
        omega=(1.0, 6.27, 10.3, 24.3),
        expected=(0.67, 105.93, 31.62, 21.63),
        printed=MappingProxyType({"raisim": (0.7, 108.85, 31.79, 21.27)}),
    ),
)


def points() -> tuple[Point, ...]:
    """Every column of both tables."""
    return tuple(point for table in TABLES for point in table.points())


def printed_errors(engine: str) -> tuple[float, float] | None:
    """The least and the largest error of what the thesis prints for an engine, against what it prints as right."""
    off = [
        abs(figure / expected - 1.0)
        for table in TABLES
        for figure, expected in zip(table.printed.get(engine, ()), table.expected, strict=False)
    ]
    return (min(off), max(off)) if off else None
