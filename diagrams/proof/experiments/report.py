"""Figures of an experiment as files, and one page that shows them beside what the thesis says."""

from functools import partial
from typing import Final

from matplotlib.figure import Figure

from mmt_drake.analysis import charts
from mmt_drake.analysis.figures import THESIS_FIGURES
from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.windows import frozen_since, wound_up
from mmt_drake.analysis.wording import milliseconds, percent
from mmt_drake.diagrams.proof.experiments.ablation.claims import CLAIMS
from mmt_drake.diagrams.proof.experiments.comparison import Comparison, Findings
from mmt_drake.diagrams.proof.experiments.findings import by_equations, findings
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun, errors_of, ratio_of
from mmt_drake.diagrams.proof.experiments.thesis import FIGURES, MAIN, SCENARIOS, figures_to_reach, thesis_cases
from mmt_drake.diagrams.proof.studies.study import Asked
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.errors import BadInput
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.model.parameters import THETA, THETA_UNITS
from mmt_drake.recording import Recording

_OWN_WINDOW = (8, 25, 26, 27, 28)  # the whole run, or a window of their own making
_AFTER_FREEZING = (11, 31)
_BEFORE_S, _AFTER_S = 0.5, 25.0  # what these show around the moment

THESIS = {
    8: "strokes along y with content up to the object's mode at 3.6 Hz; contact broken and made again at least once.",
    9: "up to 100 % error while high frequencies are excited (before 4 s), up to 30 % at lower ones.",
    **{figure: claim.says for claim in CLAIMS for figure in claim.figures},
}
"""What the thesis says of each figure, in our words."""


def judge(number: int, cases: Cases) -> Findings:
    """What experiment 1 or 3 comes to; pictures `figure_09` and so on are by the thesis's numbers.

    Figures 11 and 31 of a run too short for them are left out, and the page says so.
    """
    pictures, remarks = [], ["Drawn from the recordings of this run, one by one."]
    for figure, name in FIGURES[number].items():
        case = cases[name]
        too_short = _never_still(case.samples) if figure in _AFTER_FREEZING else ""
        if too_short:
            remarks.append(f"Figure {figure} is not drawn, the run is too short for it: {too_short}.")
            continue
        drawn = _thesis_figure(figure, case.samples, case.metrics.delay_s)
        pictures.append(Picture(drawn, _caption(figure, case), name=f"figure_{figure:02d}"))
    main, running = cases[MAIN], by_equations(cases)
    timeline = charts.contact_timeline(main.samples, delay_s=main.metrics.delay_s)
    rendered = charts.error_bars({_short(case): case.metrics.rendered_error for case in running})
    late = charts.error_bars(
        {_short(case): case.settled.rendered_error for case in running},
        title="The same in the second half of the contact time",
    )
    errors = [
        Picture(rendered, "Rendered force against the measured one, from 5 s of contact on.", name="errors"),
        Picture(late, "What is left of the error once theta has settled.", name="errors_settled"),
    ]
    found = charts.parameters(main.samples, truth=main.truth)
    theta = Picture(found, f"MeasuredRun {MAIN}; shaded where theta may be rendered.", name="parameters")
    caption = "When plant, detector and rendered force were in contact, all in the operator's time."
    tables = [errors_of(cases), parameter_table(cases)]
    sections = [
        Section("Errors", figures=errors, table=tables[0]),
        Section("Parameters", "What each way of solving eq. 30 ends with.", figures=[theta], table=tables[1]),
        Section("Touch and release", figures=[Picture(timeline, caption, name="contact")]),
        Section("The thesis's figures", "\n\n".join(remarks), figures=pictures),
    ]
    return Findings(tables, findings(cases), sections, figures_to_reach(cases))


def parameter_table(cases: Cases) -> Table:
    """The last theta of every case, and the truth in the first row."""
    true = cases[MAIN].truth
    headers = ["case", *(f"{name} [{unit}]" for name, unit in THETA_UNITS.items())]
    rows: list[list[Cell]] = [["truth", *(true[name] for name in THETA)]]
    rows += [[case.name, *(case.metrics.parameters.get(name) for name in THETA)] for case in cases.values()]
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


def _cases(number: int, asked: Asked) -> dict[str, Scenario]:
    return thesis_cases(number, asked.seed, asked.seconds)


_LEAD: Final = (
    "Scenario {}. Every way of solving eq. 30 is a case of its own, since the thesis does not say which it used. "
    "Errors are RMS(force - measured) / RMS(measured), measured being the force sent to the estimator, in contact, "
    "from 5 s of contact on."
)
_QUESTIONS: Final = {
    1: "does the whole system work with a simulated object?",
    3: "what does a delay of 400 ms each way do?",
}
EXPERIMENTS: Final = {
    number: Comparison(
        name=number,
        title=f"Experiment {number} of the thesis: {question}",
        lead=_LEAD.format(SCENARIOS[number]),
        cases=partial(_cases, number),
        judge=partial(judge, number),
    )
    for number, question in _QUESTIONS.items()
}
STUDIES: Final = {str(number): experiment.study for number, experiment in EXPERIMENTS.items()}
