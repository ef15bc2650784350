"""The main job end to end: a hand's motion, set-up 1 without and with delay, figures and one page that shows them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from mmt_drake.analysis import charts
from mmt_drake.analysis.figures import input_position, measured_and_rendered
from mmt_drake.analysis.page import Picture, Section, write_page
from mmt_drake.analysis.passivity import passivity
from mmt_drake.analysis.summary import lines
from mmt_drake.analysis.windows import Window, wound_up
from mmt_drake.analysis.wording import milliseconds, percent
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun, errors_of, ratio_of, run_cases
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, unheard
from mmt_drake.diagrams.stations.hands import Recorded
from mmt_drake.diagrams.stations.picture import station_picture
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording
from mmt_drake.recording.atomic import writing

HAND: Final = "builtin:hand_reaching"

_NEAR, _FAR = "no delay", "400 ms each way"
_SCENARIOS = {_NEAR: "setup1", _FAR: "setup1-delay"}
_FILES = {_NEAR: "setup1.mcap", _FAR: "setup1_delay.mcap"}


@dataclass(frozen=True)
class Demo:
    """What the demo left.

    Attributes:
        cases: name -> the run, measured.
        page: the page that shows all of it.
        simulated_s: length of one run [s].
    """

    cases: Cases
    page: Path
    simulated_s: float

    def lines(self) -> list[str]:
        """A summary for a terminal."""
        summary = []
        for name, case in self.cases.items():
            speed = self.simulated_s / case.wall_s
            took = f"{self.simulated_s:.0f} s simulated in {case.wall_s:.1f} s, {speed:.0f} times real time"
            summary += [
                f"{name}: {took}",
                *(f"  {line}" for line in lines(case.metrics)),
                f"  recording: {case.recording}",
            ]
        return [*summary, f"page: {self.page} (figures beside it)"]


def run_demo(out: str | Path, progress: Progress = unheard) -> Demo:
    """Run set-up 1 with the shipped hand, without and with 400 ms each way, and write the page `index.html`.

    All of it appears at the end. If anything fails before, nothing does, and an older demo stays as it was.

    Args:
        out: folder for recordings, figures and page; made if need be.
        progress: called with the number of runs done, of two.

    Raises:
        BadInput: the folder cannot be written, or has no room for all of it.
    """
    out = Path(out)
    with _all_or_nothing(out) as folder:
        demo = _run(folder, progress)
    cases = {name: replace(case, recording=out / case.recording.name) for name, case in demo.cases.items()}
    return replace(demo, cases=cases, page=out / demo.page.name)


@contextmanager
def _all_or_nothing(out: Path) -> Iterator[Path]:
    """A folder to work in, inside ``out``, whose files move up to there at the end; otherwise no file or folder stays.

    Raises:
        BadInput: writing failed.
    """
    made = [folder for folder in (out, *out.parents) if not folder.exists()]
    inside = out
    try:
        with writing(out):
            out.mkdir(parents=True, exist_ok=True)
            with TemporaryDirectory(prefix=".demo-", dir=out) as name:
                inside = Path(name)
                yield inside
                for file in inside.iterdir():
                    os.replace(file, out / file.name)
    except BaseException as error:
        for folder in made:
            with suppress(OSError):
                folder.rmdir()
        if isinstance(error, BadInput) and Path(str(error.source)).parent == inside:
            raise BadInput(out, found=error.found, expected="room for the demo; nothing of it is kept") from error
        raise


def _run(out: Path, progress: Progress) -> Demo:
    scenarios = {
        name: replace(load_scenario(scenario), operator=Recorded(HAND), duration=None)
        for name, scenario in _SCENARIOS.items()
    }
    cases = run_cases(scenarios, {name: out / file for name, file in _FILES.items()}, Asked(out), progress)
    near, far = cases[_NEAR], cases[_FAR]
    simulated_s = float(near.samples.time[-1])
    sections = [
        _station(far),
        _hand(near),
        _forces(near),
        _delayed(far),
        _parameters(near),
        _energy(cases),
        _errors(cases),
        Section(
            "How fast",
            " ".join(
                f"{name}: {simulated_s:.0f} s simulated at {1.0 / case.scenario.step:g} Hz in {case.wall_s:.1f} s, "
                f"{simulated_s / case.wall_s:.0f} times real time, clouds at "
                f"{case.scenario.environment.cloud.rate:g} Hz and the recording included."
                for name, case in cases.items()
            ),
        ),
    ]
    lead = (
        "A hand reaches, presses and slides; a telerobot repeats its motion on a flexible object that slides on a "
        "table. An estimator finds the object's impedance, and only its parameters cross the network: what the "
        "operator feels is their model, without delay."
    )
    page = write_page(out / "index.html", "Set-up 1: the model-mediated loop on a hand's motion", sections, lead)
    return Demo(cases, page, simulated_s)


def _station(far: MeasuredRun) -> Section:
    figure = station_picture(build_station(far.scenario))
    caption = "The Drake diagram that was run. A recorder, not drawn, reads every signal."
    return Section("What runs", figures=[Picture(figure, caption, name="station")])


def _hand(case: MeasuredRun) -> Section:
    figure = input_position(case.samples, axis=_busier_axis(case.samples))
    text = (
        f"The operator is a recording that the package ships ({HAND}): reaches, presses and lifts of a documented "
        "model of human motion."
    )
    return Section("The hand", text, figures=[Picture(figure, "Shaded where the probe is in contact.", name="hand")])


def _forces(case: MeasuredRun) -> Section:
    close, whole = (
        measured_and_rendered(case.samples, window_s=window, axis=_busier_axis(case.samples))
        for window in (_around_touch(case), wound_up(case.samples))
    )
    off, late_off = (percent(ratio_of(found.rendered_error)) for found in (case.metrics, case.settled))
    touch, release = _median_lags(case)
    text = (
        f"Without a delay the rendered force is {off} off over the whole run and {late_off} in the second half of the "
        f"contact time. It answers a touch {touch} late and a release {release} late."
    )
    pictures = [
        Picture(close, "A few seconds around a touch.", name="setup1"),
        Picture(whole, "The whole run after the wind-up of 5 s of contact.", name="force"),
    ]
    return Section("Measured and rendered force", text, figures=pictures)


def _delayed(case: MeasuredRun) -> Section:
    recording, metrics, delay_s = case.samples, case.metrics, case.metrics.delay_s
    axis, window = _busier_axis(recording), wound_up(recording)
    whole = measured_and_rendered(recording, delay_s=delay_s, window_s=window, axis=axis)
    timeline = charts.contact_timeline(recording, delay_s=delay_s)
    off, off_between = percent(ratio_of(metrics.rendered_error)), percent(ratio_of(metrics.between_switches_error))
    touch, release = _median_lags(case)
    text = (
        f"With {milliseconds(delay_s)} each way the rendered force is {off} off, and {off_between} away from touches "
        f"and releases. It answers those {touch} and {release} late: the contact flag comes from the telerobot, one "
        "round trip away."
    )
    pictures = [
        Picture(whole, f"As above, the rendered force drawn {milliseconds(delay_s)} later.", name="force_delay"),
        Picture(timeline, "Who was in contact when, in the operator's time, and every lag.", name="contact_delay"),
    ]
    return Section("With a slow network", text, figures=pictures)


def _parameters(case: MeasuredRun) -> Section:
    stable = case.metrics.time_to_stable_s
    when = "never" if stable is None else f"after {stable:.2f} s of contact for good"
    text = f"All that crosses the network. They may be rendered (shaded) {when}."
    figure = charts.parameters(case.samples, truth=case.truth)
    picture = Picture(figure, "The estimate over time, and the object's true values.", name="parameters")
    return Section("Parameters", text, figures=[picture])


def _energy(cases: Cases) -> Section:
    files = {_NEAR: "energy", _FAR: "energy_delay"}
    sentences = [f"{name}: {'; '.join(passivity(case.samples).lines())}." for name, case in cases.items()]
    figures = [
        Picture(charts.energy(case.samples), f"{name}: energy that the hand has put in.", name=files[name])
        for name, case in cases.items()
    ]
    return Section("Energy", "\n\n".join(sentences), figures=figures)


def _errors(cases: Cases) -> Section:
    figure = charts.error_bars({name: case.metrics.rendered_error for name, case in cases.items()})
    bars = Picture(figure, "Rendered force against the measured one, by frequency band.", name="errors")
    return Section("Errors", figures=[bars], table=errors_of(cases))


def _median_lags(case: MeasuredRun) -> tuple[str, str]:
    """Of touches and of releases."""
    return milliseconds(case.metrics.touch.median_s), milliseconds(case.metrics.release.median_s)


def _busier_axis(recording: Recording) -> str:
    """The tangential axis with the larger force."""
    return max("xy", key=lambda axis: float((recording[f"force_{axis}"] ** 2).sum()))


def _around_touch(case: MeasuredRun) -> Window:
    """5 s, from 1.5 s before the first touch after half of the run (before the run's end if there is none)."""
    end = float(case.samples.time[-1])
    touch = next((event for event in case.metrics.touch.events_s if event > end / 2), end - 3.5)
    return touch - 1.5, min(touch + 3.5, end)
