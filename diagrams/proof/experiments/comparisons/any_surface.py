"""Surfaces that are not level: is what is rendered on them as right as on a table?"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mmt_drake.analysis.table import Cell
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagrams.proof.experiments.comparison import CaseFindings, Comparison, Findings, findings_of
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun
from mmt_drake.diagrams.proof.studies.study import Asked, Reached, Target
from mmt_drake.diagrams.stations.environment import Environment, Top
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.network.config import ChannelConfig
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.surfaces import Cylinder, HeightField, Plane, Saddle, Sphere, Step

RENDERED_ON: Final = Target("rendered force, after the first 0.5 s of contact", to_reach=0.02)
CHANGED_LATE: Final = Target("longest lag of a touch or release", "s", to_reach=0.005)
FALSE_CONTACT: Final = Target("false contact", to_reach=0.005)
_WITHOUT: Final = {
    each: replace(each, to_reach=None) for each in (RENDERED_ON, CHANGED_LATE, FALSE_CONTACT)
}  # where the estimator's model is not the plant's

SLIDE: Final = Scripted("press_slide_lift", {"duration": 6.0, "touches": 1, "depth": 0.003})
"""Always the same slide, there and back in the air."""
_FIRST_S: Final = 0.5
_LENGTH_S: Final = 30.0


def edge_across_the_slide() -> Step:
    """A step down whose edge lies across the middle of `SLIDE`."""
    time = np.linspace(0.0, 6.0, 6001)
    position, _ = scripted_motion(SLIDE.motion, **SLIDE.parameters).sample(time)
    x, y = position[np.argmax(np.hypot(position[:, 0], position[:, 1])), :2]
    return Step(at=(0.5 * float(x), 0.5 * float(y), 0.0), turned=math.degrees(math.atan2(y, x)))


@dataclass(frozen=True)
class OnSurface:
    """One case.

    Attributes:
        shape: of the surface; None: set-up 1 as it is.
        asked: whether anything is to be reached.
        operator: whose hand it is, if not the scenario's.
        delay: each way [s].
    """

    shape: Top | None
    asked: bool = True
    operator: Scripted | None = None
    delay: float = 0.0


SURFACES_RUN: Final = {
    "level, as set-up 1": OnSurface(None),
    "plane at 0 degrees": OnSurface(Plane()),
    "plane at 20 degrees": OnSurface(Plane(tilt=20.0)),
    "plane at 45 degrees": OnSurface(Plane(tilt=45.0)),
    "plane at 60 degrees": OnSurface(Plane(tilt=60.0)),
    "ball of 60 mm": OnSurface(Sphere()),
    "cylinder of 60 mm": OnSurface(Cylinder()),
    "saddle": OnSurface(Saddle()),
    "height field": OnSurface(HeightField()),
    "step, over its edge": OnSurface(edge_across_the_slide(), operator=SLIDE),
    "level, the same slide": OnSurface(None, operator=SLIDE),
    "level, 400 ms each way": OnSurface(None, delay=0.4),
    "ball, 400 ms each way": OnSurface(Sphere(), delay=0.4),
    "ball, tip slips (mu 0.3)": OnSurface(Sphere(mu=0.3), asked=False),
    "plane at 20 degrees, carried": OnSurface(Plane(tilt=20.0, fixed_to="body"), asked=False),
    "ball, carried": OnSurface(Sphere(fixed_to="body"), asked=False),
}
"""What a case is called -> what is on the table."""


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """The same hand over every surface."""
    base = replace(load_scenario("setup1-free-running"), seed=asked.seed, duration=asked.seconds or _LENGTH_S)
    made, seen = {}, (base.environment.object, base.environment.noise, base.environment.cloud)
    for name, case in SURFACES_RUN.items():
        way = ChannelConfig(delay=case.delay)
        scenario = replace(base, to_telerobot=way, to_operator=way, operator=case.operator or base.operator)
        made[name] = replace(scenario, environment=Environment(*seen, surface=case.shape))
    return made


def judge(found: Cases) -> Findings:
    """Errors of the rendered force in three components, touches and releases, and contact that is none."""
    headers = ["surface", RENDERED_ON.title, "of it along x, y, z [%]", CHANGED_LATE.title, FALSE_CONTACT.title]
    headers.append("telerobot's false contact [%]")
    caption = (
        "Error of the rendered force against the plant's without noise, root mean squares of all three components, in "
        "contact. False contact: share of the samples in which detector and plant differ, beside the operator."
    )
    return findings_of({name: _judged(case) for name, case in found.items()}, headers, caption)


def errors_on(recording: Recording, delay_s: float, first_s: float = _FIRST_S) -> tuple[float, Array]:
    """RMS of rendered less true force over that of the true one, and (3,) the same along each axis over all three.

    Args:
        recording: of a station in simulation.
        delay_s: from operator to telerobot; the rendered force is held against what the plant says later.
        first_s: of contact, that does not count [s].
    """
    late = round(delay_s / float(np.median(np.diff(recording.time))))
    step = float(np.median(np.diff(recording.time)))
    n = len(recording.time) - late
    true, rendered = recording.vector("true_force")[late:], recording.vector("rendered_force")[:n]
    counts = recording["in_contact"][late:] > 0.5
    counts &= np.cumsum(counts) > first_s / step
    whole = float(np.sqrt(np.mean(np.sum(true[counts] ** 2, axis=1))))
    error = np.sqrt(np.mean((rendered - true)[counts] ** 2, axis=0))
    return float(np.linalg.norm(error)) / whole, error / whole


def _judged(case: MeasuredRun) -> CaseFindings:
    what, recording = SURFACES_RUN[case.name], case.samples
    error, along = errors_on(recording, what.delay)
    lags = [abs(lag) for each in (case.metrics.touch, case.metrics.release) for lag in each.lags_s if lag is not None]
    late = round(what.delay / case.scenario.step)
    told, is_in = recording["operator_contact"], recording["in_contact"]
    false = float(np.mean(told[: len(told) - late] != is_in[late:]))
    telerobot = float(np.mean(recording["detected_contact"] != is_in))
    longest = max(lags, default=None)
    values = ((RENDERED_ON, error), (CHANGED_LATE, longest), (FALSE_CONTACT, false))
    row: list[Cell] = [case.name, in_percent(error), ", ".join(f"{100.0 * each:.2g}" for each in along), longest]
    return CaseFindings(
        [*row, in_percent(false), in_percent(telerobot)],
        {"error": error, "error_along": along.tolist(), "false_contact": false, "telerobot_false_contact": telerobot},
        [Reached(case.name, target if what.asked else _WITHOUT[target], value) for target, value in values],
    )


SURFACES: Final = Comparison(
    name="surfaces",
    title="Is the rendered force right on surfaces that are not level?",
    lead=(
        "`setup1-free-running`, strokes, ideal clouds of 30 000 points with normals by Open3D. The hand's motion is "
        "laid over surfaces that are fixed to the world; it glides over the edge of a step. Where the body carries the "
        "surface, or the tip slips, the estimator's model is another than the plant's: nothing is to be reached there."
    ),
    cases=cases,
    judge=judge,
    file=lambda number, name: str(number),
)
