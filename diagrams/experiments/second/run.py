"""Runs every estimator over every contact of experiment 2, and measures what it says."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.metrics import Metrics, counted, measure
from mmt_drake.analysis.signals import mean_step
from mmt_drake.diagrams.experiments.comparisons.found import Times, parameters_found, times_found
from mmt_drake.diagrams.experiments.plans import SETTLE_S
from mmt_drake.diagrams.experiments.reaching import Reached, estimated, stable, to_json
from mmt_drake.diagrams.experiments.second.contacts import Contact, known_contacts
from mmt_drake.diagrams.experiments.tick_by_tick import follow
from mmt_drake.diagrams.stations.estimators import KINDS, EstimatorOptions
from mmt_drake.errors import BadInput
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import KERNEL_SIZE
from mmt_drake.model.theta import adopt_theta
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.atomic import told

Array = NDArray[np.float64]

ESTIMATORS: Final[Mapping[str, EstimatorOptions]] = {
    "thesis_rls": RlsOptions(),
    "settled_rls": RlsOptions(settle=SETTLE_S),
    "output_error": OutputErrorOptions(),
}
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
        seed: of the sensors' noise.
        cases: by contact, then by estimator.
        left_out: name of a contact -> why it was not there.
    """

    seed: int
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

    def to_json(self) -> dict[str, Any]:
        """The document that `experiment 2 --json` prints."""
        return {
            "experiment": 2,
            "scenario": None,
            "seed": self.seed,
            "operator": "strokes",
            "cases": [case.to_json() for case in self.cases],
            "figures_to_reach": to_json(self.figures_to_reach()),
            "left_out": dict(self.left_out),
        }


def run_second(
    *,
    out: str | Path,
    seed: int = 0,
    seconds: float | None = None,
    chosen: list[Contact] | None = None,
    progress: Callable[[float], None] | None = None,
) -> SecondResult:
    """Take every contact and run every estimator over it.

    Args:
        out: folder for the recordings, `exp2_arm_thesis_rls.mcap` and so on; made if need be.
        seed: of the sensors' noise.
        seconds: how much of each contact; all of it by default.
        chosen: contacts; `known_contacts()` by default.
        progress: called with the number of cases done.

    Raises:
        BadInput: a folder that cannot be made, or no contact at all.
    """
    chosen = known_contacts() if chosen is None else chosen
    left_out = {contact.name: contact.missing for contact in chosen if contact.missing is not None}
    if len(left_out) == len(chosen):
        raise BadInput("experiment 2", found="; ".join(left_out.values()), expected="an arm or recordings")
    folder = Path(out)
    with told(folder):
        folder.mkdir(parents=True, exist_ok=True)
    cases: list[SecondCase] = []
    for contact in chosen:
        if contact.take is None:
            continue
        recording = contact.take(seconds, seed)
        for name, options in ESTIMATORS.items():
            cases.append(run_second_case(contact, recording, name, options, folder))
            if progress:
                progress(len(cases))
    return SecondResult(seed, tuple(cases), left_out)


def run_second_case(
    contact: Contact, recording: Recording, name: str, options: EstimatorOptions, folder: Path
) -> SecondCase:
    """One estimator over one contact, into a file of its own."""
    options = replace(options, step=mean_step(recording))
    measurement = np.hstack([recording.vector(part) for part in ("position", "velocity", "force")])
    flag = "detected_contact" if "detected_contact" in recording else "in_contact"
    found = follow(recording.time, measurement, recording[flag], options)
    file = folder / f"exp2_{contact.name}_{name}.mcap"
    save(replace(recording, columns={**recording.columns, **found.columns()}), file)
    whole = load(file)
    force = _free_running(found.theta[-1], recording)
    errors = {
        against: None if force is None or not recording.has_vector(against) else _error(force, whole, against)
        for against in ("force", "true_force")
    }
    found_s = times_found(whole, contact.truth) if contact.truth else {}
    return SecondCase(contact, name, file, measure(whole), errors["force"], errors["true_force"], found_s)


def _free_running(theta: Array, recording: Recording) -> Array | None:
    """The force (n, 3) of one set of parameters along the measured motion, or None for a set that is none."""
    p = np.zeros(KERNEL_SIZE)
    if not (np.isfinite(theta).all() and adopt_theta(theta, np.inf, _LEAST_STEP, p)):
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
