"""A hundred objects drawn at random: how near the rendered force comes to each one's own.

Plant, estimator and renderer are the compiled ticks of the station's systems, run one after the other without a
Diagram: the plant's force with the sensors' noise into the estimator, its theta into the renderer.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from diagrams.experiments.changes import NOISE
from diagrams.experiments.plans import SETTLE_S
from diagrams.experiments.report import picture
from diagrams.experiments.tick_by_tick import follow, render_along
from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.page import Section, write_page
from mmt_drake.analysis.plotting import panels, styled
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import percent
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import THETA, THETA_UNITS, BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.recording import Recording

Array = NDArray[np.float64]

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
REACH: Final = {"median": 0.01, "95th percentile": 0.05}
_SPREAD: Final = 0.5  # of the logarithm of normal k and b about k2 and b2, where the object is not one material
_WORST: Final = 5


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
    """

    number: int
    true: Array
    found: Array
    errors: dict[str, float | None]
    last_set: float | None

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
        }


@dataclass(frozen=True)
class ObjectsResult:
    """All objects.

    Attributes:
        estimator: `output_error` or `rls`.
        isotropic: whether the normal axis is of the same material.
        seed: of the draws and the noise.
        cases: in the order of their numbers.
    """

    estimator: str
    isotropic: bool
    seed: int
    cases: tuple[ObjectCase, ...]

    def statistics(self) -> dict[str, float]:
        """Median, 95th percentile and worst error, in all bands."""
        errors = [case.error for case in self.cases]
        return {
            "median": float(np.median(errors)),
            "95th percentile": float(np.quantile(errors, 0.95)),
            "worst": float(np.max(errors)),
        }

    def worst(self) -> list[ObjectCase]:
        """The worst cases, the worst first."""
        return sorted(self.cases, key=lambda case: -case.error)[:_WORST]

    def to_json(self) -> dict[str, Any]:
        """The document that `experiment objects --json` prints."""
        return {
            "experiment": "objects",
            "estimator": self.estimator,
            "isotropic": self.isotropic,
            "seed": self.seed,
            "statistics": self.statistics(),
            "to_reach": REACH,
            "cases": [case.to_json() for case in self.cases],
        }


def drawn(number: int, seed: int = 0, *, isotropic: bool = True) -> FlexibleBoxModel:
    """The object of this number: parameters from `RANGES`; its normal axis of the same material, or another."""
    random = np.random.default_rng((seed, number))
    own = BoxParameters(**{name: float(random.uniform(*span)) for name, span in RANGES.items()})
    spread = np.zeros(2) if isotropic else _SPREAD * random.standard_normal(2)
    k, b = np.array([own.k2, own.b2]) * np.exp(spread)
    return FlexibleBoxModel(own, NormalContact(float(k), float(b)))


def run_object(number: int, *, estimator: str, seed: int, isotropic: bool, seconds: float = SECONDS) -> ObjectCase:
    """One object under strokes, estimated and rendered.

    Args:
        number: of the draw.
        estimator: `output_error` or `rls` (which waits after each touch).
        seed: of the draw and the noise.
        isotropic: see `drawn`.
        seconds: how long.
    """
    return run_model(drawn(number, seed, isotropic=isotropic), number, estimator=estimator, seed=seed, seconds=seconds)


def run_model(
    model: FlexibleBoxModel,
    number: int = 0,
    *,
    estimator: str = "output_error",
    seed: int = 0,
    seconds: float = SECONDS,
) -> ObjectCase:
    """The same with an object of one's own; `number` and `seed` are of the noise."""
    time = np.arange(round(seconds / STEP), dtype=np.float64) * STEP
    position, velocity = scripted_motion("strokes", duration=seconds, lifts=0).sample(time)
    n = len(time)
    force, body = np.empty((n, 3)), np.empty((n, 4))
    geometry = np.full(n, box.CONTACT_BY_GEOMETRY)
    box.replay(time, position, velocity, geometry, model.kernel_vector(), force, body)
    contact = (position[:, 2] < 0.0).astype(np.float64)
    random = np.random.default_rng((seed, number, 1))
    deviation = np.repeat([NOISE.position, NOISE.velocity, NOISE.force], 3)
    measurement = np.hstack([position, velocity, force]) + deviation * random.standard_normal((n, 9))
    options = RlsOptions(step=STEP, settle=SETTLE_S) if estimator == "rls" else OutputErrorOptions(step=STEP)
    motion = np.hstack([position, velocity])
    found = follow(time, measurement, contact, options, motion=motion)
    last = np.tile(found.theta[-1], (n, 1))
    again = render_along(time, motion, last, np.full(n, found.stable[-1]), contact, STEP)

    def errors(rendered: Array) -> dict[str, float | None]:
        columns = {"in_contact": contact}
        for name, values in (("force", measurement[:, 6:]), ("rendered_force", rendered), ("true_force", force)):
            columns |= {f"{name}_{axis}": values[:, i] for i, axis in enumerate("xyz")}
        error = measure(Recording(time, columns, f"object {number}")).rendered_error_true
        return {} if error is None else dict(error.tangential)

    return ObjectCase(number, model.theta(), found.theta[-1], errors(found.rendered), errors(again).get("all"))


def run_objects(
    count: int = 100,
    *,
    estimator: str = "output_error",
    isotropic: bool = True,
    seed: int = 0,
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> ObjectsResult:
    """Every object, on several cores.

    Args:
        count: how many.
        estimator: `output_error` or `rls`.
        isotropic: see `drawn`.
        seed: of everything random.
        jobs: processes at work at the same time; the numbers do not depend on it.
        progress: called with the number of objects done.
    """
    one = partial(run_object, estimator=estimator, seed=seed, isotropic=isotropic)
    cases = [one(0)] if count else []  # compiles, before there are processes
    jobs = jobs or os.cpu_count() or 1
    if jobs == 1:
        for number in range(1, count):
            cases.append(one(number))
            if progress:
                progress(len(cases))
    else:
        with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
            for case in pool.map(one, range(1, count)):
                cases.append(case)
                if progress:
                    progress(len(cases))
    return ObjectsResult(estimator, isotropic, seed, tuple(cases))


def objects_table(result: ObjectsResult) -> Table:
    """The worst objects, truth over estimate."""
    headers = ["object", *(f"{name} [%]" for name in BAND_NAMES.values()), "last set [%]", ""]
    headers += [f"{name} [{unit}]" for name, unit in list(THETA_UNITS.items())[:6]]
    rows: list[list[Cell]] = []
    for case in result.worst():
        ratios = [*(case.errors.get(band) for band in BAND_NAMES), case.last_set]
        errors = [None if ratio is None else 100.0 * ratio for ratio in ratios]
        rows.append([str(case.number), *errors, "true", *map(float, case.true[:6])])
        rows.append(["", *[None] * (len(BAND_NAMES) + 1), "found", *map(float, case.found[:6])])
    return Table(headers, rows, "The objects with the largest errors of the rendered force.")


def objects_findings(result: ObjectsResult) -> list[str]:
    """What came of it, in sentences."""
    told = result.statistics()
    reached = all(told[name] <= most for name, most in REACH.items())
    material = "the normal axis of the same material" if result.isotropic else "the normal axis of another material"
    return [
        f"{len(result.cases)} objects, {material}, estimator {result.estimator}: the rendered force is off by "
        f"{percent(told['median'])} (median), {percent(told['95th percentile'])} (95th percentile), "
        f"{percent(told['worst'])} at worst; to reach {percent(REACH['median'])} and "
        f"{percent(REACH['95th percentile'])}: {'reached' if reached else 'missed'}.",
        *(_explained(case) for case in result.worst() if case.error > REACH["median"]),
    ]


def _explained(case: ObjectCase) -> str:
    """Why an object's error is large, as far as the figures tell."""
    told = f"Object {case.number} is {percent(case.error)} off"
    told += f", {percent(case.last_set)} with the last parameters all along"
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


def write_objects(result: ObjectsResult, out: str | Path) -> Path:
    """The page `index.html` with the distribution of the errors and the worst cases.

    Raises:
        BadInput: the folder cannot be written.
    """
    out = Path(out)
    lead = (
        f"Objects drawn evenly from {', '.join(f'{name} {low:g} to {high:g}' for name, (low, high) in RANGES.items())} "
        f"(SI units) under strokes of {SECONDS:g} s, sensor noise as in set-up 1; seed {result.seed}."
    )
    section = Section(
        "What was found",
        "\n\n".join(objects_findings(result)),
        figures=[picture(out, "objects", _distribution(result), "Distribution of the errors.")],
        table=objects_table(result),
    )
    return write_page(out / "index.html", "A hundred objects", [section], lead)
