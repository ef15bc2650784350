"""The engine table as tables, one figure, sentences and a page."""

from collections.abc import Callable
from typing import Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import BLACK, BLUE, DPI, GREEN, GREY, ORANGE, PURPLE, RED, WIDTH_IN, styled
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import significant
from mmt_drake.diagrams.proof.experiments.engines.method import OURS, STEP, Input
from mmt_drake.diagrams.proof.experiments.engines.run import Cell as EngineCell
from mmt_drake.diagrams.proof.experiments.engines.run import EnginesResult, Summary, run_engines, runs_of
from mmt_drake.diagrams.proof.experiments.engines.tables import TABLES
from mmt_drake.diagrams.proof.experiments.targets import ENGINE_ERROR
from mmt_drake.diagrams.proof.studies.columns import Column, documents, tabled
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Report, Study, to_json

NAMES: Final = {OURS: "the renderer", "drake": "Drake", "mujoco": "MuJoCo", "bullet": "Bullet", "dart": "DART"}
_COLORS: Final = {OURS: RED, "drake": BLUE, "mujoco": GREEN, "bullet": ORANGE, "dart": PURPLE}
_REACH: Final = ENGINE_ERROR.to_reach or 0.0
_INSIDE: Final[Input] = "inside_step"
_SAMPLED: Final[Input] = "sampled"
_INPUTS: Final[dict[Input, str]] = {_INSIDE: "input known inside the step", _SAMPLED: "sampled poses only"}


def findings(result: EnginesResult) -> list[str]:
    """What the figures say, in sentences; every number is the result's."""
    own = [summary for summary in result.summaries() if summary.method.engine == OURS]
    others = [summary for summary in result.summaries() if summary.method.engine != OURS]
    inside, sampled = (max(summary.error(input_) for summary in own) for input_ in (_INSIDE, _SAMPLED))
    sentences = [
        f"The renderer's force is off the exact H(s) by at most {inside:.2g} of its amplitude where the input is known "
        f"inside the step ({_reached(inside)}), and by {sampled:.2g} where only poses are sampled "
        f"({_reached(sampled)}); amplitude and phase together, both tables."
    ]
    for ours in own:
        if (cheap := result.cheapest_beside(ours)) is not None:
            sentences.append(
                f"A step of it {_stepped(ours)} costs {significant(ours.us_per_step, 2)} us; of the others' the "
                f"cheapest, {_named(cheap)}, {significant(cheap.us_per_step, 2)} us "
                f"({significant(cheap.us_per_step / ours.us_per_step, 2)} times as much) at an error of "
                f"{cheap.error(_INSIDE):.2g}."
            )
    if others:
        exact = min(others, key=lambda summary: summary.error(_INSIDE))
        sentences.append(
            f"The most exact of the others, {_named(exact)}, is off by {exact.error(_INSIDE):.2g} at "
            f"{significant(exact.us_per_step, 2)} us."
        )
    sentences += [f"{NAMES.get(engine, engine)} was left out: {reason}." for engine, reason in result.left_out.items()]
    return sentences


def engines_table(result: EnginesResult) -> Table:
    """One row per way of using an engine: its worst errors over both tables, its cost, the thesis's own errors."""
    headers = ["engine", "used as", "stepped", "amplitude off [%]", "phase off [deg]", "sampled: amplitude off [%]"]
    headers += ["sampled: phase off [deg]", "step [us]", "thesis: off [%]", "to reach [%]", "verdict"]
    rows: list[list[Cell]] = []
    for summary in result.summaries():
        error, sampled, cost = result.reached_by(summary)
        row: list[Cell] = [NAMES[summary.method.engine], summary.method.name, _stepped(summary)]
        for input_ in _INPUTS:
            amplitude = summary.error(input_, lambda cell: cell.relative_error)
            phase_deg = summary.error(input_, lambda cell: abs(cell.phase_error_deg))
            row += [f"{100.0 * amplitude:.2g}", f"{phase_deg:.2g}"]
        thesis = None if error.target.thesis is None else error.target.thesis_says
        verdict = f"{error.verdict}; sampled: {sampled.verdict}"
        if cost.target.to_reach is not None:
            verdict += f"; cost (to reach: {cost.target.to_reach:.2g} us): {cost.verdict}"
        rows.append([*row, f"{summary.us_per_step:.2g}", thesis, f"{100.0 * _REACH:g}", verdict])
    caption = (
        f"At a step of {1e3 * STEP:g} ms against the exact H(s), the worst point of both tables; processor time of a "
        "step, the least of all points. Reached is an error of amplitude and phase together; the cost of a step is "
        "asked of the renderer alone, and has to be below that of every other engine that is stepped alike."
    )
    return Table(headers, rows, caption)


def thesis_table() -> Table:
    """What the thesis prints, beside the exact amplitude."""
    headers = ["table", "omega [rad/s]", "exact [N/m]", "exact, b1 and b2 exchanged [N/m]", "thesis: expected"]
    engines = [engine for table in TABLES for engine in table.printed]
    rows: list[list[Cell]] = []
    for table in TABLES:
        for point, other in zip(table.points(), table.exchanged().points(), strict=True):
            printed = (point.printed.get(engine) for engine in engines)
            rows.append([table.name, point.omega, abs(point.exact), abs(other.exact), point.expected, *printed])
    return Table([*headers, *(f"thesis: {engine}" for engine in engines)], rows, "Amplitude of force over position.")


def _digits(count: int, factor: float = 1.0) -> Callable[[float], str]:
    return lambda value: f"{factor * value:.{count}g}"


COLUMNS: Final[tuple[Column[EngineCell], ...]] = (
    Column(lambda cell: cell.method.engine, "engine", "engine", NAMES.__getitem__),
    Column(lambda cell: cell.method.name, "method", "used as"),
    Column(lambda cell: cell.input, "input", "input", _INPUTS.__getitem__),
    Column(lambda cell: cell.point.table, "table", "table"),
    Column(lambda cell: cell.point.omega, "omega", "omega [rad/s]"),
    Column(lambda cell: abs(cell.response), "amplitude", "amplitude [N/m]", _digits(6)),
    Column(lambda cell: abs(cell.point.exact), "exact", "exact [N/m]", _digits(6)),
    Column(lambda cell: cell.relative_error, "relative_error", "off [%]", _digits(2, 100.0)),
    Column(lambda cell: cell.phase_error_deg, "phase_error_deg", "phase off [deg]", _digits(2)),
    Column(lambda cell: cell.error, "error"),
    Column(lambda cell: cell.us_per_step, "us_per_step", "step [us]", _digits(2)),
    Column(lambda cell: cell.thesis, "thesis", "thesis"),
    Column(lambda cell: cell.point.expected, "thesis_expected"),
)


@styled
def engines_figure(result: EnginesResult) -> Figure:
    """Error and cost of every way of using an engine, on logarithmic scales."""
    summaries = result.summaries()
    height = 1.1 + 0.24 * len(summaries)
    figure = Figure(figsize=(WIDTH_IN, height), dpi=DPI)
    FigureCanvasAgg(figure)
    margins = {"left": 0.36, "right": 0.985, "top": 1.0 - 0.55 / height, "bottom": 0.5 / height, "wspace": 0.06}
    error, cost = figure.subplots(1, 2, sharey=True, width_ratios=(2, 1), gridspec_kw=margins)
    rows = np.arange(len(summaries))
    colors = [_COLORS[summary.method.engine] for summary in summaries]
    handles = []
    for input_, marker, filled in ((_INSIDE, "o", True), (_SAMPLED, "D", False)):
        off = [summary.error(input_) for summary in summaries]
        error.scatter(off, rows, s=32, marker=marker, facecolors=colors if filled else "none", edgecolors=colors)
        inner = GREY if filled else "none"
        mark = Line2D([], [], linestyle="", marker=marker, markerfacecolor=inner, markeredgecolor=GREY)
        mark.set_label(_INPUTS[input_])
        handles.append(mark)
    error.axvline(_REACH, color=BLACK, linestyle="--", linewidth=0.9)
    cost.barh(rows, [summary.us_per_step for summary in summaries], 0.62, color=colors)
    for row, summary in zip(rows, summaries, strict=True):
        cost.annotate(
            f"{summary.us_per_step:.2g}", (summary.us_per_step, row), (3, 0), textcoords="offset points", va="center"
        )
    for panel in (error, cost):
        panel.set_xscale("log")
        panel.grid(axis="y", visible=False)
    cost.margins(x=0.25)
    names = [f"{NAMES[summary.method.engine]}: {summary.method.name}" for summary in summaries]
    error.set_yticks(rows, names)
    error.set_ylim(len(summaries) - 0.4, -0.6)
    error.set(xlabel="worst error of the force, both tables", title="Error")
    cost.set(xlabel="us a step", title="Cost")
    figure.legend(handles=handles, loc="upper right", ncols=2, handletextpad=0.2)
    return figure


def report_of(result: EnginesResult) -> Report:
    """What the engines come to."""
    table, printed = engines_table(result), thesis_table()
    caption = (
        f"Filled: input known inside the step; open: sampled poses only. Dashed: what was to be reached, {_REACH:g}. "
        "Amplitude and phase together, the worst point of both tables."
    )
    sections = [
        Section("Engines", figures=[Picture(engines_figure(result), caption, name="engines")], table=table),
        Section("How each was used", _USED),
        Section("What the thesis prints", _PRINTED, table=printed),
        Section("Every point", table=tabled(result.cells, COLUMNS)),
    ]
    lead = (
        "Appendix E of the thesis chooses a physics engine by how it answers a sine. Here the renderer and today's "
        "engines are held against the exact transfer function of the same two objects, all in one run."
    )
    title, heading = "Engine table of the thesis (appendix E)", "Engine table: appendix E of the thesis"
    document = {
        "experiment": "engines",
        "step_s": STEP,
        "cells": documents(result.cells, COLUMNS),
        "left_out": result.left_out,
        "thesis": [each.to_json() for each in TABLES],
        "figures_to_reach": to_json(result.figures_to_reach()),
    }
    return Report(document, title, lead, heading, [table, printed], findings(result), sections)


_USED: Final = """\
A sine moves the probe; the engine moves the body under k1, b1 and the contact's k2, b2; the force is that of the
contact spring and damper at the samples. Each engine starts in the exact steady state and settles for 8 s.

Known inside the step: position and velocity may be asked for at any time. Drake's integrators and the renderer ask
where their method wants them; an engine that holds its input over the step gets it at the step's beginning, Runge-Kutta
4 of MuJoCo at its middle. Sampled: only poses are known, one a step and none ahead. The velocity is then a third-order
backward difference and the motion between two samples the cubic through both ends, for all alike. Such a difference
multiplies the poses' noise by 3.8 per step: where poses are noisy, a measured velocity is worth more.

MuJoCo's mocap body is no fair way of using it, and is there to show what is lost where a hand is brought in by
setting a body's position: its velocity.

Native stepping is that of Drake's simulator, of MuJoCo's rollout and of the renderer's tick in a compiled loop. Bullet
and DART are stepped from Python, the only way of their packages, and their cost holds that; MuJoCo and the renderer,
which a station calls from Python, are run so too. The renderer moves three axes and looks at its parameters at every
tick, the others move one."""

_PRINTED: Final = """\
No transfer function with the printed parameters gives the thesis's 'expected' column. Table A's is off by a factor of
3 to 7. Table B's, whose mass is not printed (0.5 kg is taken), fits within half a percent at three of four points once
b1 and b2 are exchanged. So every engine is held against H(s) with the parameters as printed. ODE, Simbody and Raisim
have no package that could be installed here; their figures are the thesis's alone."""


def _reached(error: float) -> str:
    return f"to reach: {_REACH:g}, {'reached' if error <= _REACH else 'missed'}"


def _stepped(summary: Summary) -> str:
    return "from Python" if summary.method.from_python else "natively"


def _named(summary: Summary) -> str:
    return f"{NAMES[summary.method.engine]} ({summary.method.name})"


def _run(asked: Asked, progress: Progress) -> Report:
    return report_of(run_engines(progress=progress))


STUDIES: Final = {"engines": Study("engines, runs", (), lambda asked: runs_of(), _run)}
