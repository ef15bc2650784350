"""Both tables through every engine: amplitude, phase and cost against the exact H(s)."""

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, product
from typing import Final, get_args

import numpy as np

from mmt_drake.analysis.wording import significant
from mmt_drake.diagrams.proof.experiments.engines import (
    bullet_methods,
    dart_methods,
    drake_methods,
    mujoco_methods,
    own,
)
from mmt_drake.diagrams.proof.experiments.engines.method import OURS, STEP, Input, Method, Probe, Setting, missing
from mmt_drake.diagrams.proof.experiments.engines.tables import Point, points, printed_errors
from mmt_drake.diagrams.proof.experiments.targets import ENGINE_COST, ENGINE_ERROR, ENGINE_SAMPLED
from mmt_drake.diagrams.proof.studies.study import Progress, Reached, unheard
from mmt_drake.numeric.arrays import Array

METHODS: Final = (
    *own.METHODS,
    *drake_methods.METHODS,
    *mujoco_methods.METHODS,
    *bullet_methods.METHODS,
    *dart_methods.METHODS,
)

ITS_RENDERER: Final = "raisim"
"""The engine that the thesis renders with."""
SETTLE_S: Final = 8.0
"""Simulated before the force counts: it starts in the exact steady state, so only the engine's own error dies away."""
WINDOW_S: Final = 2.0
"""Over which amplitude and phase are taken, at least; a whole period at least."""


@dataclass(frozen=True)
class Cell:
    """One engine, used in one way, at one point of a table.

    Attributes:
        method: how the engine was used.
        input: what it knew of the probe's motion.
        point: of the table.
        response: force over position, as simulated [N/m]; `point.exact` is what it has to be.
        us_per_step: processor time of one step [us].
    """

    method: Method
    input: Input
    point: Point
    response: complex
    us_per_step: float

    @property
    def relative_error(self) -> float:
        """Of the amplitude."""
        return abs(abs(self.response) / abs(self.point.exact) - 1.0)

    @property
    def phase_error_deg(self) -> float:
        """Positive where the force comes too early."""
        return math.degrees(cmath.phase(self.response / self.point.exact))

    @property
    def error(self) -> float:
        """Amplitude and phase together: |response / exact - 1|."""
        return abs(self.response / self.point.exact - 1.0)

    @property
    def thesis(self) -> float | None:
        """What the thesis prints for this engine here; for ours what it prints as the right value."""
        return self.point.expected if self.method.engine == OURS else self.point.printed.get(self.method.engine)


@dataclass(frozen=True)
class Summary:
    """One way of using one engine, over both tables.

    Attributes:
        cells: of that way.
    """

    cells: tuple[Cell, ...]

    @property
    def method(self) -> Method:
        """The way."""
        return self.cells[0].method

    @property
    def us_per_step(self) -> float:
        """The least processor time of a step at any point [us]."""
        return min(cell.us_per_step for cell in self.cells)

    def error(self, input_: Input, of: Callable[[Cell], float] = lambda cell: cell.error) -> float:
        """The largest error at any point with this input, of amplitude and phase together or as `of` takes it."""
        return max(of(cell) for cell in self.cells if cell.input == input_)


@dataclass(frozen=True)
class EnginesResult:
    """All that was measured.

    Attributes:
        cells: by method, then input, then point.
        left_out: engine that was not run -> why.
    """

    cells: tuple[Cell, ...]
    left_out: dict[str, str]

    def summaries(self) -> tuple[Summary, ...]:
        """One per method, in the order of the cells."""
        return tuple(Summary(tuple(cells)) for _, cells in groupby(self.cells, key=lambda cell: cell.method))

    def cheapest_beside(self, ours: Summary) -> Summary | None:
        """Of the other engines the one with the cheapest step, natively or from Python alike; None without any."""
        others = [each for each in self.summaries() if each.method.engine != OURS]
        alike = [each for each in others if each.method.from_python == ours.method.from_python]
        return min(alike, key=lambda each: each.us_per_step, default=None)

    def figures_to_reach(self) -> list[Reached]:
        """Of every way of using an engine, see `reached_by`."""
        return [figure for summary in self.summaries() for figure in self.reached_by(summary)]

    def reached_by(self, summary: Summary) -> tuple[Reached, Reached, Reached]:
        """Its error, the same with sampled poses, and its cost, beside what the thesis prints of that engine.

        Beside the renderer stands the engine that the thesis renders with. The cost is asked of the renderer alone,
        against the cheapest of the others that are stepped alike.
        """
        method = summary.method
        name, ours = f"{method.engine}: {method.name}", method.engine == OURS
        error, cost = ENGINE_ERROR, ENGINE_COST
        if (printed := printed_errors(ITS_RENDERER if ours else method.engine)) is not None:
            least, most = (significant(100.0 * value, 2) for value in printed)
            error = replace(error, thesis=printed[1], thesis_says=f"{least} to {most}{' (Raisim)' if ours else ''}")
        cheapest = self.cheapest_beside(summary)
        if ours and cheapest is not None:
            cost = replace(cost, to_reach=cheapest.us_per_step)
        return (
            Reached(name, error, summary.error("inside_step")),
            Reached(name, ENGINE_SAMPLED, summary.error("sampled")),
            Reached(name, cost, summary.us_per_step),
        )


def run_engines(
    methods: Sequence[Method] = METHODS, at: Sequence[Point] | None = None, progress: Progress = unheard
) -> EnginesResult:
    """Put a sine through every engine at every point, once known inside the step and once only sampled.

    All of it in this process, one after the other, since it is timed; the engines in turn at each point, so that other
    work on the machine, which comes and goes, slows all alike. Engines that are not installed are left out.

    Args:
        methods: ways of using engines.
        at: columns of the tables; all by default.
        progress: called with the number of runs done, of `runs_of()` by default.
    """
    left_out = {method.engine: missing(method.package) for method in methods if method.package}
    absent = {engine: reason for engine, reason in left_out.items() if reason is not None}
    cells: list[Cell] = []
    for point, input_, method in product(points() if at is None else at, get_args(Input), methods):
        if method.engine not in absent:
            cells.append(measure(method, point, input_))
            progress(len(cells))
    cells.sort(key=lambda cell: (methods.index(cell.method), get_args(Input).index(cell.input)))
    return EnginesResult(tuple(cells), absent)


def runs_of() -> int:
    """How many runs `run_engines` makes by default."""
    here = [method for method in METHODS if method.package is None or missing(method.package) is None]
    return len(here) * len(get_args(Input)) * len(points())


def measure(method: Method, point: Point, input_: Input) -> Cell:
    """One cell.

    Raises:
        MissingDependency: the engine is not installed.
    """
    settle = round(SETTLE_S / STEP)
    window = math.ceil(max(WINDOW_S, 2.0 * math.pi / point.omega) / STEP)
    probe = Probe(point.omega, settle + window, input_)
    trace = method.run(Setting(point.parameters, probe))
    response = _response(probe.times[settle:], trace.force[settle:], point.omega)
    return Cell(method, input_, point, response, trace.us_per_step)


def _response(times: Array, force: Array, omega: float) -> complex:
    """Of a force (n,) to sin(omega t), by least squares, less the constant that the anchor of a spring leaves."""
    basis = np.column_stack([np.sin(omega * times), np.cos(omega * times), np.ones_like(times)])
    in_phase, ahead, _ = np.linalg.lstsq(basis, force)[0]
    return complex(in_phase, ahead)
