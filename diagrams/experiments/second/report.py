"""What experiment 2 says, as a table, sentences, figures and a page."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import legend_above, line, panels, styled
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent, percent, significant
from mmt_drake.diagrams.experiments.reaching import BY_PRIOR, reached_table
from mmt_drake.diagrams.experiments.second.run import SecondCase, SecondResult
from mmt_drake.diagrams.experiments.targets import ESTIMATED, STABLE
from mmt_drake.diagrams.studies.study import Report
from mmt_drake.model.parameters import TANGENTIAL_THETA, THETA_UNITS
from mmt_drake.recording import load

_UNEXPLAINED = 0.3  # of the force


def second_table(result: SecondResult) -> Table:
    """One row per case: errors, time until stable, parameters; the thesis's own and the truth where it is known."""
    headers = ["case", "estimated [%]", "rendered [%]", "last set, free-running [%]", "the same, no noise [%]"]
    headers += ["stable [s]", *(f"{name} [{THETA_UNITS[name]}]" for name in TANGENTIAL_THETA)]
    nothing: list[Cell] = [None] * len(TANGENTIAL_THETA)
    rows: list[list[Cell]] = [
        ["thesis", in_percent(ESTIMATED.thesis), None, None, None, STABLE.thesis, *nothing],
        ["to reach", None, None, None, None, STABLE.to_reach, *nothing],
    ]
    told: set[str] = set()
    for case in result.cases:
        metrics, known = case.metrics, case.contact.truth
        if known and case.contact.name not in told:
            told.add(case.contact.name)
            rows.append([f"{case.contact.name}: truth", *[None] * 5, *(known.get(name) for name in TANGENTIAL_THETA)])
        estimated = None if metrics.estimated_error is None else metrics.estimated_error.tangential["all"]
        errors = (estimated, metrics.rendered_error.tangential["all"], case.free_running, case.noise_free)
        row: list[Cell] = [case.name, *map(in_percent, errors)]
        stable: Cell = BY_PRIOR if case.stable_by_prior else metrics.time_to_stable_s
        rows.append([*row, stable, *(metrics.parameters.get(name) for name in TANGENTIAL_THETA)])
    caption = (
        "Shares of the measured force's RMS, x and y together, after 5 s of contact. Rendered: with the parameters of "
        "each moment; last set: with the last ones from the first sample on. – where there is none."
    )
    return Table(headers, rows, caption)


def findings(result: SecondResult) -> list[str]:
    """What the figures say, in sentences; every number is the result's."""
    told = []
    for case in result.cases:
        if case.estimator == "output_error":
            told.append(_told(case))
        elif case.metrics.time_to_stable_s is None:
            told.append(f"{case.name}: there are no stable parameters that stay so.")
    return told + [f"{name} was left out: {reason}." for name, reason in result.left_out.items()]


def _told(case: SecondCase) -> str:
    error, stable = case.metrics.estimated_error, case.metrics.time_to_stable_s
    estimated = None if error is None else error.tangential["all"]
    if case.stable_by_prior:
        when = f"stable {BY_PRIOR}"
    else:
        when = "never stable" if stable is None else f"stable after {significant(stable, 2)} s of contact"
    words = (
        f"{case.name}: the estimated force is {percent(estimated)} off (the thesis, on a real object: "
        f"{ESTIMATED.thesis_says}), {when} (the thesis: after "
        f"{STABLE.thesis:g} s), the last parameters, running freely, {percent(case.free_running)}"
    )
    if case.noise_free is not None:
        words += f", against the force without noise {percent(case.noise_free)}"
    if case.free_running is not None and case.free_running > _UNEXPLAINED:
        words += "; the model is not that of this contact"
    return words + "."


def report_of(result: SecondResult) -> Report:
    """What the contacts come to, with one picture each; their recordings must still be there."""
    each, reached, found = second_table(result), reached_table(result.figures_to_reach()), findings(result)
    by_contact: dict[str, list[SecondCase]] = {}
    for case in result.cases:
        by_contact.setdefault(case.contact.name, []).append(case)
    pictures = [
        Picture(_forces(cases), f"{cases[0].contact.title}: ten seconds in the middle.", name=f"forces_{name}")
        for name, cases in by_contact.items()
    ]
    lead = (
        "The estimators of set-up 3: a simulated Panda under impedance control slides the thesis's 459 g object with a "
        "soft top, its wrist's force cleared of the probe's weight, inertia and the sensor's drifting offset; and "
        f"recordings of a real robot that palpates, which is no object on a table. Seed {result.seed}."
    )
    sections = [
        Section("What was found", "\n\n".join(found), table=reached),
        Section("Contacts", figures=pictures, table=each),
    ]
    title = "Experiment 2: can a real contact be estimated?"
    heading = "Experiment 2: estimators on contacts"
    return Report(result.to_json(), heading, [each, reached], found, title, lead, sections)


@styled
def _forces(cases: Sequence[SecondCase]) -> Figure:
    """Measured and rendered force along y over ten seconds."""
    figure, (panel,) = panels(1, 3.4)
    recordings = [load(case.recording) for case in cases]
    middle = 0.5 * (recordings[0].time[0] + recordings[0].time[-1])
    shown = abs(recordings[0].time - middle) <= 5.0
    time = recordings[0].time[shown]
    line(panel, time, recordings[0]["force_y"][shown], "measured")
    top = abs(recordings[0]["force_y"][shown]).max()
    for case, recording in zip(cases, recordings, strict=True):
        line(panel, time, recording["rendered_force_y"][shown].clip(-3.0 * top, 3.0 * top), case.estimator)
    panel.set(xlabel="time [s]", ylabel="force along y [N]")
    legend_above(panel)
    return figure
