"""Figures of an experiment as files, and one page that shows them beside what the thesis says."""

from __future__ import annotations

from typing import Final

from matplotlib.figure import Figure

from mmt_drake.analysis import charts
from mmt_drake.analysis.figures import THESIS_FIGURES
from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.summary import error_table
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.windows import frozen_since, wound_up
from mmt_drake.analysis.wording import milliseconds, percent
from mmt_drake.diagrams.experiments.findings import by_equations, findings, ratio_of, truth
from mmt_drake.diagrams.experiments.runs import MeasuredRun
from mmt_drake.diagrams.experiments.thesis import MAIN, PLANS, ExperimentResult, figures_to_reach, run_experiment
from mmt_drake.diagrams.studies.figures import reached_table
from mmt_drake.diagrams.studies.study import OF_A_RUN, Asked, Progress, Report, Study
from mmt_drake.errors import BadInput
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.model.parameters import THETA, THETA_UNITS
from mmt_drake.recording import Recording, load

_OWN_WINDOW = (8, 25, 26, 27, 28)  # the whole run, or a window of their own making
_AFTER_FREEZING = (11, 31)
_BEFORE_S, _AFTER_S = 0.5, 25.0  # what these show around the moment

THESIS = {
    8: "strokes along y with content up to the object's mode at 3.6 Hz; contact broken and made again at least once.",
    9: "up to 100 % error while high frequencies are excited (before 4 s), up to 30 % at lower ones.",
    10: "the estimated force follows the measured one, the rendered force does not follow the estimated.",
    11: "with theta frozen at 5 s the estimated force starts to err like the rendered one.",
    14: "as in experiment 1, and 800 ms late at touch and release.",
    24: "measured and rendered force look alike, but part at higher frequencies.",
    25: "better than at high frequencies, but off by up to 30 %.",
    26: "errors as large as the force.",
    27: "below 0.25 N up to 0.3 Hz, then about 1 N, of the order of the measured force.",
    28: "the measured force, for comparison with figure 27.",
    29: "an error noticeably lower than that of the rendered force.",
    30: "the estimated force stays close to the measured one, the rendered force does not.",
    31: "with theta frozen the spikes of estimated and rendered force become alike.",
    35: "800 ms between the measured force becoming zero at a release and the rendered force doing so.",
}
"""What the thesis says of each figure, in our words."""


def report_of(result: ExperimentResult) -> Report:
    """What experiment 1 or 3 comes to; pictures `figure_09` and so on are by the thesis's numbers.

    Args:
        result: of `run_experiment`; its recordings must still be there.

    Raises:
        BadInput: a recording is gone or has not what a figure shows. Figures 11 and 31 of a run too short for them are
            left out, and the page says so.
    """
    plan = PLANS[result.number]
    recordings = {name: load(result[name].recording) for name in dict.fromkeys((MAIN, *plan.figures.values()))}
    pictures, remarks = [], ["Drawn from the recordings of this run, one by one."]
    for number, name in plan.figures.items():
        case, recording = result[name], recordings[name]
        too_short = _never_still(recording) if number in _AFTER_FREEZING else ""
        if too_short:
            remarks.append(f"Figure {number} is not drawn, the run is too short for it: {too_short}.")
            continue
        figure = _thesis_figure(number, recording, case.metrics.delay_s)
        pictures.append(Picture(figure, _caption(number, case), name=f"figure_{number:02d}"))
    main, reached = result[MAIN], reached_table(figures_to_reach(result))
    delay_s = main.metrics.delay_s
    running = by_equations(result)
    sections = [
        Section("What was found", "\n\n".join(findings(result)), table=reached),
        Section(
            "Errors",
            figures=[
                Picture(
                    charts.error_bars({_short(case): case.metrics.rendered_error for case in running}),
                    "Rendered force against the measured one, from 5 s of contact on.",
                    name="errors",
                ),
                Picture(
                    charts.error_bars(
                        {_short(case): case.settled.rendered_error for case in running},
                        title="The same in the second half of the contact time",
                    ),
                    "What is left of the error once theta has settled.",
                    name="errors_settled",
                ),
            ],
            table=error_table(result.metrics, result.settled),
        ),
        Section(
            "Parameters",
            "What each way of solving eq. 30 ends with.",
            figures=[
                Picture(
                    charts.parameters(recordings[MAIN], truth=truth(main)),
                    f"MeasuredRun {MAIN}; shaded where theta may be rendered.",
                    name="parameters",
                )
            ],
            table=parameter_table(result),
        ),
        Section(
            "Touch and release",
            figures=[
                Picture(
                    charts.contact_timeline(recordings[MAIN], delay_s=delay_s),
                    "When plant, detector and rendered force were in contact, all in the operator's time.",
                    name="contact",
                )
            ],
        ),
        Section("The thesis's figures", "\n\n".join(remarks), figures=pictures),
    ]
    lead = (
        f"{plan.title} Scenario {result.scenario}, operator {result.operator}, seed {result.seed}. Every way of "
        "solving eq. 30 is a case of its own, since the thesis does not say which it used. Errors are "
        "RMS(force - measured) / RMS(measured), in contact, from 5 s of contact on. Recordings stand beside this page."
    )
    tables = [error_table(result.metrics, result.settled), parameter_table(result), reached]
    return Report(
        document=result.to_json(),
        heading=f"Experiment {result.number}: scenario {result.scenario}, operator {result.operator}",
        tables=tables,
        sentences=findings(result),
        title=f"Experiment {result.number} of the thesis",
        lead=lead,
        sections=sections,
    )


def parameter_table(result: ExperimentResult) -> Table:
    """The last theta of every case, and the truth in the first row."""
    true = truth(result[MAIN])
    headers = ["case", *(f"{name} [{unit}]" for name, unit in THETA_UNITS.items())]
    rows: list[list[Cell]] = [["truth", *(true[name] for name in THETA)]]
    rows += [[case.name, *(case.metrics.parameters.get(name) for name in THETA)] for case in result.cases]
    return Table(headers, rows, "Parameters at the end of the run; the truth of Fc is the sliding level.")


def _short(case: MeasuredRun) -> str:
    """The way of solving eq. 30 alone, where there is little room."""
    chosen = case.scenario.estimator
    return chosen.equations if isinstance(chosen, RlsOptions) else case.name


def _thesis_figure(number: int, recording: Recording, delay_s: float) -> Figure:
    """As the thesis, without the wind-up, whose forces may be larger by orders of magnitude."""
    window = None if number in _OWN_WINDOW else wound_up(recording)
    if window is not None and number in _AFTER_FREEZING:
        window = (window[0] - _BEFORE_S, min(window[0] + _AFTER_S, window[1]))
    return THESIS_FIGURES[number](recording, delay_s=delay_s, window_s=window)


def _never_still(recording: Recording) -> str:
    """Why frozen parameters cannot be shown; empty where they can."""
    try:
        frozen_since(recording)
    except BadInput as error:
        return f"{error.at}: found {error.found}, expected {error.expected}"
    return ""


def _caption(number: int, case: MeasuredRun) -> str:
    metrics = case.metrics
    rendered, estimated = metrics.rendered_error.tangential, ratio_of(metrics.estimated_error)
    both = f"estimated force {percent(estimated)}, rendered force {percent(rendered['all'])} off."
    late = " and ".join(
        f"{milliseconds(lag)} at {event}"
        for event, lag in (("touch", metrics.touch.median_s), ("release", metrics.release.median_s))
        if lag is not None
    )
    delayed = f"rendered force {percent(rendered['all'])} off, late by {late or 'an unknown time'} (median)."
    found = {
        8: f"{case.metrics.contact_s:.1f} s of contact, {len(metrics.release.events_s)} releases.",
        9: f"rendered force {percent(rendered['all'])} off in all, {percent(rendered['below_0.3_hz'])} below 0.3 Hz, "
        f"{percent(rendered['0.3_to_3_hz'])} from 0.3 to 3 Hz, {percent(rendered['3_to_10_hz'])} from 3 to 10 Hz.",
        14: delayed,
        24: f"rendered force {percent(rendered['all'])} off.",
        25: f"{percent(rendered['below_0.3_hz'])} below 0.3 Hz, over the whole run.",
        26: f"{percent(rendered['3_to_10_hz'])} from 3 to 10 Hz, over the whole run.",
        27: "the same by band: "
        f"{', '.join(percent(rendered[band]) for band in ('below_0.3_hz', '0.3_to_3_hz', '3_to_10_hz'))}.",
        28: f"measured {metrics.rendered_error.reference_rms['all']:.3g} N RMS.",
        29: f"{percent(estimated)} off.",
        35: delayed,
    }
    return f"Figure {number}, case {case.name}. Thesis: {THESIS[number]} Here: {found.get(number, both)}"


def _study(number: int) -> Study:
    def run(asked: Asked, progress: Progress) -> Report:
        return report_of(run_experiment(number, **asked.of_a_run(), progress=progress))

    return Study(f"experiment {number}, cases", OF_A_RUN, lambda asked: len(PLANS[number].cases()), run)


STUDIES: Final = {str(number): _study(number) for number in PLANS}
