"""A hundred objects drawn at random: how near the rendered force comes to each one's own."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import ceil
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import panels, styled
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent, percent
from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.comparisons.bound import noise_bound
from mmt_drake.diagrams.proof.experiments.targets import (
    MEDIAN_OBJECT,
    MEDIAN_OBJECT_REST,
    MOST_OBJECTS,
    MOST_OBJECTS_REST,
    WORST_OBJECT,
)
from mmt_drake.diagrams.proof.experiments.thesis import ESTIMATOR_OPTIONS
from mmt_drake.diagrams.proof.experiments.tick_by_tick import (
    behind_sensor,
    by_axis,
    follow,
    measured_along,
    render_along,
)
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Reached, Report, Study, unheard
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import THETA, THETA_UNITS, BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording

STEP: Final = 1e-3
RANGES: Final = {
    "m": (0.2, 3.0),
    "k1": (0.0, 300.0),
    "k2": (150.0, 2000.0),
    "b1": (2.0, 80.0),
    "b2": (2.0, 80.0),
    "Fc": (0.0, 2.0),
}
"""From which the parameters are drawn, evenly; SI units."""
SECONDS: Final = 20.0
_ASKED: Final = {"median": (0.5, MEDIAN_OBJECT), "95th percentile": (0.95, MOST_OBJECTS), "worst": (1.0, WORST_OBJECT)}
"""Name -> share of the objects that are no worse, and the target."""
_ASKED_OF_REST: Final = ((0.5, MEDIAN_OBJECT_REST), (0.95, MOST_OBJECTS_REST))
_OWN, _FOREIGN, _LAB = "own plant", "foreign plant", "foreign plant, sensors of a lab"
RESOLUTION_M, LATE_S = 1e-5, 0.002
"""What a lab's sensors do: positions in steps, and a force that is late."""
EXPLAINED: Final = MEDIAN_OBJECT.to_reach or 0.0
"""Objects with a larger error are explained: what the noise would have allowed, and what the last parameters give."""
_SPREAD: Final = 0.5  # of the logarithm of normal k and b about k2 and b2, where the object is not one material
_WORST: Final = 5
_ESTIMATORS: Final = {"rls": ESTIMATOR_OPTIONS["settled_rls"], "output_error": OutputErrorOptions(in_plane="vector")}


@dataclass(frozen=True)
class ObjectCase:
    """One object.

    Attributes:
        number: of the draw.
        true: theta, of the object.
        found: theta, of the last estimate.
        errors: name of a band -> error of the rendered force, against the plant's without noise.
        last_set: the same in all bands, had the last estimate been there from the first sample on. Where it is small
            and the error is not, friction holds the rendered body where earlier parameters have put it.
        noise_leaves: the error that parameters at the bound of the force's noise would have (`comparisons.bound`), in
            all bands; of objects with an error above `MEDIAN_OBJECT` alone.
        foreign: the error in all bands where the plant shares no physics with the model (`mmt_drake.foreign`), friction
            a vector.
        rest: plant -> the error in all contact after its first 0.5 s, in all bands; of the foreign plant also
            behind the sensors of a lab (`in_a_lab`).
    """

    number: int
    true: Array
    found: Array
    errors: dict[str, float | None]
    last_set: float | None
    noise_leaves: float | None = None
    foreign: float = 0.0
    rest: Mapping[str, float] = field(default_factory=dict)

    @property
    def error(self) -> float:
        """In all bands."""
        return self.errors["all"] or 0.0

    def to_json(self) -> dict[str, Any]:
        """One entry of `cases`."""
        return {
            "object": self.number,
            "true": dict(zip(THETA, self.true.tolist(), strict=True)),
            "found": {
                name: None if np.isnan(value) else float(value) for name, value in zip(THETA, self.found, strict=True)
            },
            "rendered_error_true": self.errors,
            "rendered_error_true_of_last_set": self.last_set,
            "noise_leaves": self.noise_leaves,
            "rendered_error_true_foreign": self.foreign,
            "error_rest_true": dict(self.rest),
        }


@dataclass(frozen=True)
class ObjectsResult:
    """All objects.

    Attributes:
        estimator: name of one of `mmt_drake.diagrams.stations.estimators.KINDS`.
        isotropic: whether the normal axis is of the same material.
        seed: of the draws and the noise.
        cases: in the order of their numbers.
    """

    estimator: str
    isotropic: bool
    seed: int
    cases: tuple[ObjectCase, ...]

    def statistics(self, *, foreign: bool = False) -> dict[str, float]:
        """Median, 95th percentile and worst error, in all bands."""
        errors = [case.foreign if foreign else case.error for case in self.cases]
        return {which: float(np.quantile(errors, share)) for which, (share, _) in _ASKED.items()}

    def worst(self) -> list[ObjectCase]:
        """The worst cases, the worst first."""
        return sorted(self.cases, key=lambda case: -case.error)[:_WORST]

    def figures_to_reach(self) -> list[Reached]:
        """Of all objects together."""
        found, ordered = self.statistics(), sorted(self.cases, key=lambda case: case.error)
        name = f"{len(self.cases)} objects, {self.estimator}"
        return (
            [
                # The bound is of the object there, or next above.
                Reached(name, target, found[which], ordered[ceil(share * (len(ordered) - 1))].noise_leaves)
                for which, (share, target) in _ASKED.items()
            ]
            + [
                Reached(f"{name}, foreign plant", target, self.statistics(foreign=True)[which])
                for which, (_, target) in _ASKED.items()
            ]
            + [
                Reached(name if plant == _OWN else f"{name}, {plant}", target, self.rest(plant, share))
                for plant in self.cases[0].rest
                for share, target in _ASKED_OF_REST
            ]
        )

    def rest(self, plant: str, share: float) -> float:
        """The error in all contact after its first 0.5 s that this share of the objects stays below."""
        return float(np.quantile([case.rest[plant] for case in self.cases], share))


def drawn(number: int, seed: int = 0, *, isotropic: bool = True) -> FlexibleBoxModel:
    """The object of this number: parameters from `RANGES`; its normal axis of the same material, or another."""
    random = np.random.default_rng((seed, number))
    own = BoxParameters(**{name: float(random.uniform(*span)) for name, span in RANGES.items()})
    spread = np.zeros(2) if isotropic else _SPREAD * random.standard_normal(2)
    k, b = np.array([own.k2, own.b2]) * np.exp(spread)
    return FlexibleBoxModel(own, NormalContact(float(k), float(b)))


def path_of(motion: str, seconds: float) -> tuple[Array, Array]:
    """Times (n,) [s] and a scripted motion (n, 6) [m, m/s] at ticks of `STEP`; strokes that never lift."""
    time: Array = np.arange(round(seconds / STEP), dtype=np.float64) * STEP
    options: dict[str, int] = {"lifts": 0} if motion == "strokes" else {}
    return time, np.hstack(scripted_motion(motion, duration=seconds, **options).sample(time))


def run_object(number: int, *, estimator: str, seed: int, isotropic: bool) -> ObjectCase:
    """One object under strokes, estimated and rendered.

    Args:
        number: of the draw.
        estimator: name of one of `mmt_drake.diagrams.stations.estimators.KINDS`; `rls` waits after each touch.
        seed: of the draw and the noise.
        isotropic: see `drawn`.
    """
    options = replace(_ESTIMATORS[estimator], step=STEP)
    model = replace(drawn(number, seed, isotropic=isotropic), in_plane=options.in_plane)
    time, motion = path_of("strokes", SECONDS)
    n = len(time)
    random = np.random.default_rng((seed, number, 1))
    measurement, contact, force = measured_along(time, motion, model, NOISE, random)
    found = follow(time, measurement, contact, options, motion=motion)
    ended = np.tile(found.theta[-1], (n, 1))
    stable = np.full(n, found.stable[-1])
    again = render_along(time, motion, ended, stable, contact, STEP, in_plane=options.in_plane)

    def recorded(**vectors: Array) -> Recording:
        return Recording(time, {"in_contact": contact, **by_axis(vectors)}, f"object {number}")

    def errors(rendered: Array, true: Array) -> tuple[dict[str, float | None], float]:
        figures = measure(recorded(force=true, rendered_force=rendered))
        rest = figures.stages["error_rest"]
        return dict(figures.rendered_error.tangential), rest.tangential["all"] or 0.0

    (rendered, rest), (last, _) = errors(found.rendered, force), errors(again, force)
    elsewhere, _, other = measured_along(time, motion, model, NOISE, random, "foreign")
    (foreign, foreign_rest), (_, lab_rest) = (
        errors(follow(time, sensed, contact, options, motion=motion).rendered, other)
        for sensed in (elsewhere, in_a_lab(elsewhere))
    )
    by_plant = {_OWN: rest, _FOREIGN: foreign_rest, _LAB: lab_rest}
    leaves = None
    if (rendered.get("all") or 0.0) > EXPLAINED:
        along = recorded(master_position=motion[:, :3], master_velocity=motion[:, 3:])
        leaves = noise_bound(model, along, NOISE.force, OutputErrorOptions(step=STEP).ticks).leaves["all"]
    in_all = foreign["all"] or 0.0
    return ObjectCase(number, model.theta(), found.theta[-1], rendered, last.get("all"), leaves, in_all, by_plant)


def in_a_lab(measurement: Array) -> Array:
    """What a lab's sensors make of a measurement (n, 9): `RESOLUTION_M`, `LATE_S`."""
    sensed = measurement.copy()
    sensed[:, :3] = RESOLUTION_M * np.round(measurement[:, :3] / RESOLUTION_M)
    time: Array = STEP * np.arange(len(sensed), dtype=np.float64)
    sensed[:, 6:] = behind_sensor(time, measurement[:, 6:], LATE_S, 0.0)
    return sensed


def run_objects(asked: Asked, progress: Progress = unheard) -> ObjectsResult:
    """Every object, on several cores.

    Args:
        asked: count, estimator, seed, whether anisotropic; the numbers do not depend on the jobs.
        progress: called with the number of objects done.
    """
    estimator, isotropic = asked.estimator or "output_error", not asked.anisotropic
    one = partial(run_object, estimator=estimator, seed=asked.seed, isotropic=isotropic)
    tasks = [partial(one, number) for number in range(_count(asked))]
    cases = results_of(tasks, asked.jobs, progress, compile_first=True)
    return ObjectsResult(estimator, isotropic, asked.seed, tuple(cases))


def objects_table(result: ObjectsResult) -> Table:
    """The worst objects, truth over estimate."""
    headers = ["object", *(f"{name} [%]" for name in BAND_NAMES.values()), "last set [%]", "foreign [%]", "object is"]
    headers += [f"{name} [{unit}]" for name, unit in list(THETA_UNITS.items())[:6]]
    rows: list[list[Cell]] = []
    for case in result.worst():
        errors = map(in_percent, [*(case.errors.get(band) for band in BAND_NAMES), case.last_set, case.foreign])
        rows.append([str(case.number), *errors, "true", *map(float, case.true[:6])])
        rows.append(["", *[None] * (len(BAND_NAMES) + 2), "found", *map(float, case.found[:6])])
    return Table(headers, rows, "The objects with the largest errors of the rendered force.")


def objects_findings(result: ObjectsResult) -> list[str]:
    """What came of it, in sentences."""
    found, foreign = result.statistics(), result.statistics(foreign=True)
    asked = [figure for figure in result.figures_to_reach() if figure.target.to_reach is not None]
    reached, most = (
        all(figure.reached for figure in asked),
        " and ".join(dict.fromkeys(percent(each.target.to_reach) for each in asked)),
    )
    rest = [
        f"{plant} {percent(result.rest(plant, 0.5))}, {percent(result.rest(plant, 0.95))}"
        for plant in result.cases[0].rest
    ]
    material = "the normal axis of the same material" if result.isotropic else "the normal axis of another material"
    return [
        f"{len(result.cases)} objects, {material}, estimator {result.estimator}: the rendered force is off by "
        f"{percent(found['median'])} (median), {percent(found['95th percentile'])} (95th percentile), "
        f"{percent(found['worst'])} at worst; on a plant that shares no physics with the model, friction a vector, "
        f"{', '.join(map(percent, foreign.values()))}; to reach {most}: {'reached' if reached else 'missed'}.",
        f"In all contact after its first 0.5 s, median and 95th percentile: {'; '.join(rest)}.",
        *(_explained(case) for case in result.worst() if case.error > EXPLAINED),
    ]


def _explained(case: ObjectCase) -> str:
    """Why an object's error is large, as far as the figures tell."""
    text = f"Object {case.number} is {percent(case.error)} off"
    text += f", {percent(case.last_set)} with the last parameters all along"
    text += f", {percent(case.noise_leaves)} with parameters at the bound of the noise"
    if case.last_set is not None and case.last_set < 0.1 * case.error:
        return f"{text}: they are right, but friction holds the rendered body where earlier ones have put it."
    return f"{text}."


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
    worst = objects_table(result)
    picture = Picture(_distribution(result), "Distribution of the errors.", name="objects")
    data = {
        "experiment": "objects",
        "estimator": result.estimator,
        "isotropic": result.isotropic,
        "seed": result.seed,
        "statistics": result.statistics(),
        "statistics_foreign": result.statistics(foreign=True),
        "cases": [case.to_json() for case in result.cases],
    }
    lead = (
        f"Objects drawn evenly from {', '.join(f'{name} {low:g} to {high:g}' for name, (low, high) in RANGES.items())} "
        f"(SI units) under strokes of {SECONDS:g} s, sensor noise as in set-up 1; seed {result.seed}. "
        f"Sensors of a lab: positions in steps of {1e6 * RESOLUTION_M:g} um, "
        f"the force {1e3 * LATE_S:g} ms late."
    )
    return Report(
        data,
        title="A hundred objects",
        lead=lead,
        heading="Objects drawn at random",
        own_tables=[worst],
        sentences=objects_findings(result),
        sections=[Section("The worst", figures=[picture], table=worst)],
        reached=result.figures_to_reach(),
    )


def _count(asked: Asked) -> int:
    return asked.objects("objects", 100)


def _run(asked: Asked, progress: Progress) -> Report:
    return report_of(run_objects(asked, progress))


STUDIES: Final = {"objects": Study("objects", ("seed", "estimator", "count", "anisotropic"), _count, _run)}
