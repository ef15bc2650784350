"""A number of a model that is a curve over something recorded beside the motion, and how kernels follow it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array

RECORDING = "recording"
"""`Over.of` of a number that is another one in each recording."""


@dataclass(frozen=True)
class Over:
    """A number of a model over a column recorded beside the motion, or free per recording.

    Attributes:
        number: symbol of the structure, or `effect.symbol`.
        of: name of the column, or `RECORDING`.
        at: knots of the curve, increasing, or names of recordings; empty where nothing is known of it yet.
        value: of the number at each: linear between knots, held beyond the first and the last.
    """

    number: str
    of: str
    at: tuple[float, ...] | tuple[str, ...] = ()
    value: tuple[float, ...] = ()

    @property
    def effect(self) -> str:
        """Name of the effect whose number it is; empty for one of the structure."""
        return self.number.rpartition(".")[0]

    @property
    def symbol(self) -> str:
        """Of the number, without its effect."""
        return self.number.rpartition(".")[2]

    @property
    def symbols(self) -> tuple[str, ...]:
        """The free numbers that the curve is made of, by name: `Fc(current=0.5)`."""
        return tuple(f"{self.symbol}({self.of}={x if isinstance(x, str) else f'{x:.9g}'})" for x in self.at)

    @property
    def mean(self) -> float:
        """Of the values: what the number counts as where nobody asks over what."""
        return float(np.mean(self.value))

    def with_values(self, values: Mapping[str, float]) -> Over:
        """The curve with other values, by their names in `symbols`; the rest as they are."""
        pairs = zip(self.symbols, self.value, strict=True)
        return replace(self, value=tuple(float(values.get(symbol, value)) for symbol, value in pairs))

    def named(self, name: str, source: str) -> float:
        """The value in the recording of a name.

        Raises:
            BadInput: the curve has none for it.
        """
        for known, value in zip(self.at, self.value, strict=True):
            if known == name:
                return value
        found, expected = f"no value for {name!r}", f"one of {', '.join(map(str, self.at)) or 'no recording'}"
        raise BadInput(source, at=f"over.{self.number}", found=found, expected=expected)


def plain(symbol: str) -> str:
    """The number that a free one of `Over.symbols` belongs to; any other symbol as it is."""
    return symbol.partition("(")[0]


@dataclass(frozen=True)
class Course:
    """Numbers of a kernel vector that change in the course of a recording.

    Attributes:
        indices: of these numbers.
        time: (n,) [s] since the first sample, increasing.
        values: (k, n) of each; linear in between, held beyond the ends.
        max_step: the shortest integration step [s] that any of them asks for.
    """

    indices: tuple[int, ...]
    time: Array
    values: Array
    max_step: float

    def numbers(self) -> Array:
        """As it stands at the end of a kernel vector: how many numbers and times, indices, times, values."""
        return np.concatenate([[len(self.indices), len(self.time)], self.indices, self.time, self.values.ravel()])


@njit(error_model="numpy")
def take_course(p: Array, start: float, t: float) -> None:
    """Set the numbers of a kernel vector that have a course to what they are at a time, in place.

    Args:
        p: kernel vector.
        start: where in it the course begins; 0: there is none.
        t: since the first sample [s].
    """
    at = int(start)
    if at == 0:
        return
    count, knots = int(p[at]), int(p[at + 1])
    times = at + 2 + count
    low, high = 0, knots - 1
    while high - low > 1:
        middle = (low + high) // 2
        if p[times + middle] <= t:
            low = middle
        else:
            high = middle
    part = 0.0
    if knots > 1:
        part = min(max((t - p[times + low]) / (p[times + high] - p[times + low]), 0.0), 1.0)
    for j in range(count):
        first = times + knots * (j + 1)
        p[int(p[at + 2 + j])] = (1.0 - part) * p[first + low] + part * p[first + high]
