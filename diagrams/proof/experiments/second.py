"""Experiment 2 of the thesis: every estimator over every contact that can be had."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from mmt_drake.analysis.metrics import Metrics, counted, measure
from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import legend_above, line, panels, styled
from mmt_drake.analysis.signals import mean_step
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagrams.proof.experiments.comparisons.bound import Times, parameters_found, times_found
from mmt_drake.diagrams.proof.experiments.runs import ratio_of
from mmt_drake.diagrams.proof.experiments.second_contacts import Contact, known_contacts
from mmt_drake.diagrams.proof.experiments.targets import ESTIMATED, STABLE, estimated, stable
from mmt_drake.diagrams.proof.experiments.thesis import ESTIMATOR_OPTIONS
from mmt_drake.diagrams.proof.experiments.tick_by_tick import follow
from mmt_drake.diagrams.proof.studies.study import BY_PRIOR, Asked, Progress, Reached, Report, Study, unheard
from mmt_drake.diagrams.stations.estimators import KINDS
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import KERNEL_SIZE, TANGENTIAL_THETA, THETA_UNITS, InPlane
from mmt_drake.model.plane_call import planar
from mmt_drake.model.theta import adopt_theta
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.atomic import writing

ESTIMATORS: Final = {**ESTIMATOR_OPTIONS, "output_error": OutputErrorOptions()}
"""Those of the thesis's set-up 1; friction is a vector here."""
_LEAST_STEP: Final = 1e-5  # [s] of the simulation with the last parameters


@dataclass(frozen=True)
class SecondCase:
    """One estimator on one contact.

    Attributes:
        contact: what was estimated from.
        estimator: a name of `ESTIMATORS`.
        recording: the file with the contact and all that the estimator made of it.
        metrics: of that file. The rendered force is that of the parameters of each moment, running freely.
        free_running: error of the force that the last parameters alone give from the first sample on, as a share of
            the measured force's RMS, x and y together; None where they cannot be simulated.
        noise_free: the same against the plant's force, where that is known.
        found_s: parameter -> contact time [s] from which on it stays near the truth, None where it does not; empty
            where the truth is not known.
    """

    contact: Contact
    estimator: str
    recording: Path
    metrics: Metrics
    free_running: float | None
    noise_free: float | None
    found_s: Times

    @property
    def name(self) -> str:
        """Of the case."""
        return f"{self.contact.name}_{self.estimator}"

    @property
    def stable_by_prior(self) -> bool:
        """Whether what the estimator puts out is stable from its prior on, whatever it learns."""
        return isinstance(ESTIMATORS[self.estimator], OutputErrorOptions)

    def to_json(self) -> dict[str, Any]:
        """One entry of `cases`."""
        return {
            "name": self.name,
            "estimator": KINDS[type(ESTIMATORS[self.estimator])].name,
            "renderer": "runge_kutta",
            "recording": str(self.recording),
            **self.metrics.to_json(),
            "stable_by_prior": self.stable_by_prior,
            "free_running_error": self.free_running,
            "free_running_error_true": self.noise_free,
            "truth": dict(self.contact.truth),
            "found_s": dict(self.found_s),
        }


@dataclass(frozen=True)
class SecondResult:
    """All cases.

    Attributes:
        cases: by contact, then by estimator.
        left_out: name of a contact -> why it was not there.
    """

    cases: tuple[SecondCase, ...]
    left_out: Mapping[str, str]

    def figures_to_reach(self) -> list[Reached]:
        """Of every case: error of the estimated force, when it is stable and, where the truth is known, right."""
        found: list[Reached] = []
        for case in self.cases:
            found += estimated(case.name, case.metrics.estimated_error)
            found.append(stable(case.name, case.metrics, by_prior=case.stable_by_prior))
            found += parameters_found(case.name, case.found_s).values()
        return found


def run_second(chosen: Sequence[Contact], asked: Asked, progress: Progress = unheard) -> SecondResult:
    """Take every contact and run every estimator over it.

    Args:
        chosen: contacts.
        asked: folder for the recordings, `exp2_arm_thesis_rls.mcap` and so on, made if need be; how much of each
            contact; seed of the sensors' noise.
        progress: called with the number of cases done.

    Raises:
        BadInput: a folder that cannot be made, or no contact at all.
    """
    left_out = {contact.name: contact.missing for contact in chosen if contact.missing is not None}
    if len(left_out) == len(chosen):
        raise BadInput("experiment 2", found="; ".join(left_out.values()), expected="an arm or recordings")
    with writing(asked.out):
        asked.out.mkdir(parents=True, exist_ok=True)
    cases: list[SecondCase] = []
    for contact in chosen:
        if contact.take is None:
            continue
        recording = contact.take(asked.seconds, asked.seed)
        for name in ESTIMATORS:
            cases.append(_followed(contact, recording, name, asked.out))
            progress(len(cases))
    return SecondResult(tuple(cases), left_out)


def _followed(contact: Contact, recording: Recording, name: str, folder: Path) -> SecondCase:
    """One estimator over one contact, into a file of its own."""
    options = replace(ESTIMATORS[name], step=mean_step(recording))
    measurement = np.hstack([recording.vector(part) for part in ("position", "velocity", "force")])
    flag = "detected_contact" if "detected_contact" in recording else "in_contact"
    found = follow(recording.time, measurement, recording[flag], options)
    file = folder / f"exp2_{contact.name}_{name}.mcap"
    save(replace(recording, columns={**recording.columns, **found.columns()}), file)
    whole = load(file)
    force = _free_running(found.theta[-1], recording, options.in_plane)
    errors = {
        against: None if force is None or not recording.has_vector(against) else _error(force, whole, against)
        for against in ("force", "true_force")
    }
    found_s = times_found(whole, contact.truth) if contact.truth else {}
    return SecondCase(contact, name, file, measure(whole), errors["force"], errors["true_force"], found_s)


def _free_running(theta: Array, recording: Recording, in_plane: InPlane) -> Array | None:
    """The force (n, 3) of one set of parameters along the measured motion, or None for a set that is none."""
    p = np.zeros(KERNEL_SIZE)
    if not (np.isfinite(theta).all() and adopt_theta(theta, np.inf, _LEAST_STEP, planar(in_plane), p)):
        return None
    force, body = np.empty((len(recording), 3)), np.empty((len(recording), 4))
    position, velocity = recording.vector("position"), recording.vector("velocity")
    box.replay(recording.time, position, velocity, recording["in_contact"], p, force, body)
    return force


def _error(force: Array, recording: Recording, against: str) -> float:
    """Error over the RMS of the force, along x and y, where errors count."""
    chosen, reference = counted(recording), recording.vector(against)
    difference = (force - reference)[chosen, :2]
    return float(np.sqrt(np.sum(difference**2) / np.sum(reference[chosen, :2] ** 2)))


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
    for contact, cases in groupby(result.cases, key=lambda case: case.contact):
        if contact.truth:
            truth = (contact.truth.get(name) for name in TANGENTIAL_THETA)
            rows.append([f"{contact.name}: truth", *[None] * 5, *truth])
        for case in cases:
            metrics = case.metrics
            errors = (ratio_of(metrics.estimated_error), ratio_of(metrics.rendered_error))
            row: list[Cell] = [case.name, *map(in_percent, (*errors, case.free_running, case.noise_free))]
            stable: Cell = BY_PRIOR if case.stable_by_prior else metrics.time_to_stable_s
            rows.append([*row, stable, *(metrics.parameters.get(name) for name in TANGENTIAL_THETA)])
    caption = (
        "Shares of the measured force's RMS, x and y together, after 5 s of contact. Rendered: with the parameters of "
        "each moment; last set: with the last ones from the first sample on. – where there is none."
    )
    return Table(headers, rows, caption)


def findings(result: SecondResult) -> list[str]:
    """What the table does not say, in sentences."""
    sentences = []
    for case in result.cases:
        if case.metrics.time_to_stable_s is None:
            sentences.append(f"{case.name}: there are no stable parameters that stay so.")
        elif case.estimator == "output_error" and (case.free_running or 0.0) > _UNEXPLAINED:
            sentences.append(f"{case.name}: the model is not that of this contact.")
    return sentences + [f"{name} was left out: {reason}." for name, reason in result.left_out.items()]


def report_of(result: SecondResult, seed: int) -> Report:
    """What the contacts come to, with one picture each; their recordings must still be there.

    Args:
        result: all cases.
        seed: of the sensors' noise.
    """
    each = second_table(result)
    pictures = [
        Picture(_forces(list(cases)), f"{contact.title}: ten seconds in the middle.", name=f"forces_{contact.name}")
        for contact, cases in groupby(result.cases, key=lambda case: case.contact)
    ]
    data = {
        "experiment": 2,
        "scenario": None,
        "seed": seed,
        "operator": "strokes",
        "cases": [case.to_json() for case in result.cases],
        "left_out": dict(result.left_out),
    }
    lead = (
        "The estimators of set-up 3: a simulated Panda under impedance control slides the thesis's 459 g object with a "
        "soft top, its wrist's force cleared of the probe's weight, inertia and the sensor's drifting offset; and "
        f"recordings of a real robot that palpates, which is no object on a table. Seed {seed}."
    )
    return Report(
        data,
        title="Experiment 2: can a real contact be estimated?",
        lead=lead,
        heading="Experiment 2: estimators on contacts",
        own_tables=[each],
        sentences=findings(result),
        sections=[Section("Contacts", figures=pictures, table=each)],
        reached=result.figures_to_reach(),
    )


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


def _steps(asked: Asked) -> float:
    return len(ESTIMATORS) * sum(contact.take is not None for contact in known_contacts())


def _run(asked: Asked, progress: Progress) -> Report:
    return report_of(run_second(known_contacts(), asked, progress), asked.seed)


STUDIES: Final = {"2": Study("experiment 2, cases", ("seconds", "seed"), _steps, _run)}
