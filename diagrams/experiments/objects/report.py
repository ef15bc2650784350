"""What a hundred objects say, as a table, sentences, a figure and a page."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import panels, styled
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent, percent
from mmt_drake.diagrams.experiments.objects.run import EXPLAINED, RANGES, SECONDS, ObjectCase, ObjectsResult
from mmt_drake.diagrams.experiments.reaching import reached_table
from mmt_drake.diagrams.studies.study import Report
from mmt_drake.model.parameters import THETA_UNITS


def objects_table(result: ObjectsResult) -> Table:
    """The worst objects, truth over estimate."""
    headers = ["object", *(f"{name} [%]" for name in BAND_NAMES.values()), "last set [%]", "object is"]
    headers += [f"{name} [{unit}]" for name, unit in list(THETA_UNITS.items())[:6]]
    rows: list[list[Cell]] = []
    for case in result.worst():
        errors = map(in_percent, [*(case.errors.get(band) for band in BAND_NAMES), case.last_set])
        rows.append([str(case.number), *errors, "true", *map(float, case.true[:6])])
        rows.append(["", *[None] * (len(BAND_NAMES) + 1), "found", *map(float, case.found[:6])])
    return Table(headers, rows, "The objects with the largest errors of the rendered force.")


def objects_findings(result: ObjectsResult) -> list[str]:
    """What came of it, in sentences."""
    told = result.statistics()
    asked = [figure for figure in result.figures_to_reach() if figure.target.to_reach is not None]
    reached = all(figure.reached for figure in asked)
    material = "the normal axis of the same material" if result.isotropic else "the normal axis of another material"
    return [
        f"{len(result.cases)} objects, {material}, estimator {result.estimator}: the rendered force is off by "
        f"{percent(told['median'])} (median), {percent(told['95th percentile'])} (95th percentile), "
        f"{percent(told['worst'])} at worst; to reach {' and '.join(percent(each.target.to_reach) for each in asked)}: "
        f"{'reached' if reached else 'missed'}.",
        *(_explained(case) for case in result.worst() if case.error > EXPLAINED),
    ]


def _explained(case: ObjectCase) -> str:
    """Why an object's error is large, as far as the figures tell."""
    told = f"Object {case.number} is {percent(case.error)} off"
    told += f", {percent(case.last_set)} with the last parameters all along"
    told += f", {percent(case.noise_leaves)} with parameters at the bound of the noise"
    if case.last_set is not None and case.last_set < 0.1 * case.error:
        return f"{told}: they are right, but friction holds the rendered body where earlier ones have put it."
    return f"{told}."


@styled
def _distribution(result: ObjectsResult) -> Figure:
    drawing, (panel,) = panels(1, 3.2)
    errors = np.sort([100.0 * case.error for case in result.cases])
    panel.step(errors, (np.arange(len(errors)) + 1.0) / len(errors), where="post")
    panel.set_xscale("log")
    panel.set_xlabel("error of the rendered force [%]")
    panel.set_ylabel("share of objects")
    return drawing


def report_of(result: ObjectsResult) -> Report:
    """What the objects come to."""
    worst, reached = objects_table(result), reached_table(result.figures_to_reach())
    found = objects_findings(result)
    lead = (
        f"Objects drawn evenly from {', '.join(f'{name} {low:g} to {high:g}' for name, (low, high) in RANGES.items())} "
        f"(SI units) under strokes of {SECONDS:g} s, sensor noise as in set-up 1; seed {result.seed}."
    )
    sections = [
        Section(
            "What was found",
            "\n\n".join(found),
            figures=[Picture(_distribution(result), "Distribution of the errors.", name="objects")],
            table=reached,
        ),
        Section("The worst", table=worst),
    ]
    return Report(
        result.to_json(), "Objects drawn at random", [worst, reached], found, "A hundred objects", lead, sections
    )
