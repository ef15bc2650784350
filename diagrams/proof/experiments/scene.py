"""Several objects: what is felt of one that has been touched before, and whether each keeps its identity."""

import time
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from mmt_drake.analysis.carried import LIFTED, CarriedObject, carried_object
from mmt_drake.analysis.metrics import FIRST_S
from mmt_drake.analysis.passivity import passivity
from mmt_drake.analysis.signals import delayed, stretches, vector
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagrams.proof.experiments.targets import (
    CARRIED,
    CARRIED_MASS,
    ENERGY_GIVEN,
    IDENTITY_LOST,
    SECOND_TOUCH,
    SECOND_TOUCH_FOREIGN,
    SLOWNESS,
    SWAPPED,
    TOUCH_LATE,
)
from mmt_drake.diagrams.proof.studies.drawn import DrawnCases, DrawnFindings, each_draw
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.diagrams.stations.nets import Nets
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.diagrams.stations.station import build_station, worth_spreading
from mmt_drake.model import scene_layout as at
from mmt_drake.model.scene_layout import SeenState
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, load

SECONDS: Final = 60.0
PUSHING_S: Final = 600.0
"""Of pushing, to see whether identities are kept."""
PLANTS: Final = ("own", "foreign")
FOREIGN: Final = (
    "environment.laws=foreign",
    *(f"environment.things.{name}.object.parameters.b1=0.0" for name in ("sponge", "brick", "roll")),
    "environment.things.roll.object.effects=[]",
)
"""Set-up 4 on the other simulation, whose objects have no spring or damper to the world and do not stiffen."""
_SHOWN: Final = {"scene": "scene.scene", "places": "environment.places"}
_PUSH: Final = 0.055
"""[m]: so far that objects meet."""
_TOLD_S: Final = 3.0
_NEAR: Final = 0.03
"""[m]: what is seen so near to an object is that object."""
_TOLD: Final = (SeenState.LOST, SeenState.FOUND, SeenState.SPLIT, SeenState.TAKEN_AWAY, SeenState.NEW)
_LONGEST_ANSWER_S: Final = 0.2
"""[s]: a change of the flag that is farther from the truth answers another touch."""


@dataclass(frozen=True)
class Visit:
    """One touch of set-up 4.

    Attributes:
        object: its name.
        before: how often it had been touched before.
        first: error of the rendered force along x and y in the first half second of contact, against the plant's.
        whole: and in all of the touch.
    """

    object: str
    before: int
    first: float
    whole: float


@dataclass(frozen=True)
class SceneCase:
    """One seed: a run of set-up 4, and one of pushing.

    Attributes:
        number: of the seed.
        plant: `own`, or `foreign`: of the simulation that shares no physics with the model, and no pushing.
        visits: every touch.
        carried: what was carried, as it was felt; None: nothing was.
        mass: by how much its mass was told wrong, 3 s after it was lifted.
        late_s: the longest that a touch or release was told too early or late beside the operator [s]; None: one was
            not told at all.
        energy: that the hand was given and had not put in [J].
        times: faster than real time, the recording included.
        minutes: of objects in view while they were pushed.
        kept: share of them with the identity that the object had at first.
        swapped: how often an identity went over to another object without a word.
        told: state -> for how many frames it was told, of all objects together.
    """

    number: int
    plant: str
    visits: tuple[Visit, ...]
    carried: CarriedObject | None
    mass: float
    late_s: float | None
    energy: float
    times: float
    minutes: float
    kept: float
    swapped: int
    told: dict[str, int]

    @property
    def worst_again(self) -> dict[str, float]:
        """Object -> largest error of a first half second after the first touch."""
        again = [visit for visit in self.visits if visit.before > 0]
        return {
            name: max(v.first for v in again if v.object == name) for name in dict.fromkeys(v.object for v in again)
        }


def run_case(number: int, plant: str, seed: int) -> SceneCase:
    """Both runs of a seed, on the foreign plant the first alone."""
    scenario = load_scenario("setup4", [f"seed={1000 * seed + number}", *(FOREIGN if plant == "foreign" else ())])
    with TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        station = build_station(scenario, record=file, spread=worth_spreading(scenario, SECONDS))
        began = time.perf_counter()
        station.simulate(SECONDS)
        times = SECONDS / (time.perf_counter() - began)
        recording = load(file)
    carried = carried_object(recording)
    several = scenario.several
    assert several is not None
    true = next(iter(several.things.values())).object.parameters.m
    soon = int(np.argmax(recording["body_height"] > LIFTED)) + round(_TOLD_S / scenario.step)
    mass = float(abs(recording["carried_m"][soon] / true - 1.0))
    directions = f"operator.parameters={{seed: {1000 * seed + number + 1}, push: {_PUSH}}}"
    only_pushed = "operator.motion=visits", directions, "carrying=null"
    pushed = load_scenario("setup4", [f"seed={1000 * seed + number}", *only_pushed])
    minutes, kept, swapped, told = identities(pushed, PUSHING_S) if plant == "own" else (0.0, 1.0, 0, {})
    late = latest(recording, scenario.to_telerobot.playout)
    given = passivity(recording).operator.violation
    visits = visits_of(recording, scenario)
    return SceneCase(number, plant, visits, carried, mass, late, given, times, minutes, kept, swapped, told)


def visits_of(recording: Recording, scenario: Scenario) -> tuple[Visit, ...]:
    """Every touch that lasts, of a recording of set-up 4."""
    several, step = scenario.several, scenario.step
    assert several is not None  # it is set-up 4
    felt = delayed(vector(recording, "rendered_force"), scenario.to_telerobot.playout, step)[:, :2]
    true, touched = vector(recording, "true_force")[:, :2], recording["touched"]
    names, count, found = list(several.things), [0] * len(several.things), list[Visit]()
    for start, end in stretches(touched > 0.0):
        which, first = int(touched[start]) - 1, round(FIRST_S / step)
        if end - start < first:
            continue
        errors = [_error(felt[start:stop], true[start:stop]) for stop in (start + first, end)]
        found.append(Visit(names[which], count[which], *errors))
        count[which] += 1
    return tuple(found)


def _error(felt: Array, true: Array) -> float:
    return float(np.linalg.norm(felt - true) / np.linalg.norm(true))


def latest(recording: Recording, delay: float) -> float | None:
    """The longest time between a true touch or release and what the operator's side says of it [s]; None: nothing."""
    worst, end = 0.0, float(recording.time[-1])
    true, told = (recording[name] > 0.5 for name in ("in_contact", "operator_contact"))
    for rises in (True, False):
        events, answers = (recording.time[1:][(flag[1:] == rises) & (flag[:-1] != rises)] for flag in (true, told))
        for event in events[events < end - _LONGEST_ANSWER_S]:
            lag = np.abs(answers + delay - event)
            if not len(lag) or lag.min() > _LONGEST_ANSWER_S:
                return None
            worst = max(worst, float(lag.min()))
    return worst


def identities(scenario: Scenario, seconds: float) -> tuple[float, float, int, dict[str, int]]:
    """Push objects and watch who is taken for whom; no estimator and no renderer.

    Returns:
        Minutes of objects in view, share of them with the right identity, swaps that were not told, frames by state.
    """
    with closing(Site(scenario, spread=worth_spreading(scenario, seconds))) as site:
        return _watched(scenario, _only_seen(site), seconds)


def _only_seen(site: Site) -> Diagram:
    several = site.scenario.several
    assert several is not None  # of set-up 4
    names = ("operator", "environment", "camera", "scene")
    systems = site.person.system, several.build(site), site.surface.camera, several.tracker(site)
    parts = {name: system for name, system in zip(names, systems, strict=True) if system is not None}
    builder = DiagramBuilder()
    for name, system in parts.items():
        builder.AddNamedSystem(name, system)
    reads = {
        "environment.motion": "operator.motion",
        "camera.bodies": "environment.bodies",
        "camera.probe": "operator.motion[0:3]",
        "scene.position": "operator.motion[0:3]",
        "scene.point_cloud": "camera.point_cloud | environment.point_cloud",
    }
    Nets(parts).connect(builder, {port: net for port, net in reads.items() if port.split(".")[0] in parts}, _SHOWN)
    return builder.Build()


def _watched(scenario: Scenario, diagram: Diagram, seconds: float) -> tuple[float, float, int, dict[str, int]]:
    several, simulator = scenario.several, Simulator(diagram)
    assert several is not None  # of set-up 4
    watch, frame = IdentityWatch(len(several.things)), 1.0 / several.cloud.rate
    for k in range(1, round(seconds / frame)):
        simulator.AdvanceTo(k * frame)
        scene, places = (diagram.GetOutputPort(name).Eval(simulator.get_context()) for name in _SHOWN)
        if k * frame > 1.0:  # the camera has begun
            watch.look(at.rows(scene), places.reshape(-1, 2))
    return watch.frames * frame / 60.0, watch.kept / max(watch.frames, 1), watch.swapped, watch.told


class IdentityWatch:
    """Holds what is seen against the truth, frame by frame.

    Attributes:
        frames: of all objects together.
        kept: of them those in which the object has its first identity.
        swapped: identities that went over to another object without a word.
        told: name of a state -> frames in which it was told.

    Args:
        count: of objects that there truly are.
    """

    def __init__(self, count: int) -> None:
        self.frames = self.kept = self.swapped = 0
        self.told: dict[str, int] = {}
        self._first: dict[int, float] = {}
        self._owner: dict[float, int] = {}
        self._warned: set[float] = set()
        self._count = count

    def look(self, rows: Array, places: Array) -> None:
        """A frame: (k, ROW) what is seen, (n, 2) the places of the objects [m]."""
        places = places[: self._count]
        whose = np.full(self._count, -1.0)
        for row in rows:
            thing, state = float(row[at.THING]), SeenState(int(row[at.STATE]))
            self.told[state.name.lower()] = self.told.get(state.name.lower(), 0) + 1
            if state in _TOLD:
                self._warned.add(thing)
            if state == SeenState.TAKEN_AWAY:
                continue
            apart = np.hypot(*(places - row[[at.X, at.Y]]).T)
            near = int(np.argmin(apart))
            if apart[near] > _NEAR:
                continue
            if self._owner.setdefault(thing, near) != near:
                self.swapped += thing not in self._warned
                self._owner[thing] = near
            if state in (SeenState.SEEN, SeenState.MERGED):
                self._warned.discard(thing)
            whose[near] = thing
        for i, thing in enumerate(whose.tolist()):
            self.frames += 1
            self.kept += thing > 0.0 and self._first.setdefault(i, thing) == thing


def judge(cases: Sequence[SceneCase], seed: int) -> DrawnFindings:
    """What it comes to."""
    reached: list[Reached] = []
    for case in cases:
        name = f"{case.plant}, seed {case.number}"
        for thing, error in case.worst_again.items():
            target = SECOND_TOUCH if case.plant == "own" else SECOND_TOUCH_FOREIGN
            reached.append(Reached(f"{name}, {thing}", target, error))
        reached += [
            Reached(name, TOUCH_LATE, case.late_s, never=case.late_s is None),
            Reached(name, ENERGY_GIVEN, case.energy),
            Reached(name, SLOWNESS, 1.0 / case.times),
        ]
        if case.minutes > 0.0:
            reached += [Reached(name, IDENTITY_LOST, 1.0 - case.kept), Reached(name, SWAPPED, float(case.swapped))]
        if case.carried is not None:
            reached += [Reached(name, CARRIED, case.carried.force), Reached(name, CARRIED_MASS, case.mass)]
    first = [visit.first for case in cases for visit in case.visits if visit.before == 0]
    again = [visit.first for case in cases for visit in case.visits if visit.before > 0]
    medians = [f"{plant} plant: {_medians(case for case in cases if case.plant == plant)}" for plant in PLANTS]
    minutes = sum(case.minutes for case in cases)
    lifted = [
        f"{case.plant}, seed {case.number}: {case.carried.line()}; mass {100 * case.mass:.2g} % off."
        for case in cases
        if case.carried is not None
    ]
    sentences = [
        f"In the first half second of a touch the rendered force was {100 * np.median(first):.2g} % off (median) where "
        f"the object had never been touched, and {100 * np.median(again):.2g} % where it had.",
        f"By object, at the second touch, {'; '.join(medians)}.",
        f"Of {minutes:.1f} object-minutes of pushing the identity was kept in "
        f"{100 * sum(case.kept * case.minutes for case in cases) / max(minutes, 1e-9):.2f} %; "
        f"{sum(case.swapped for case in cases)} identities were swapped without a word.",
        *lifted,
    ]
    lead = (
        "Set-up 4: three objects, a simulated depth camera with noise 1, 400 ms each way with jitter; "
        f"{SECONDS:g} s of visits from one to the next. And {PUSHING_S / 60.0:g} minutes of pushing in directions "
        "drawn at random, with the camera alone. Errors are of the rendered force along x and y against the "
        "plant's without noise. The foreign plant shares no physics with the model; nothing stiffens there; "
        f"seed {seed}."
    )
    return DrawnFindings(lead, visits_table(cases), sentences, reached)


def _medians(cases: Iterable[SceneCase]) -> str:
    """Of each object how far off a first half second after the first touch is, in the median."""
    found: dict[str, list[float]] = {}
    for case in cases:
        for name, error in case.worst_again.items():
            found.setdefault(name, []).append(error)
    return ", ".join(f"{name} {100 * np.median(errors):.2g} %" for name, errors in found.items()) or "none"


def visits_table(cases: Sequence[SceneCase]) -> Table:
    """Touch by touch."""
    rows: list[list[Cell]] = [
        [case.plant, case.number, visit.object, visit.before, 100.0 * visit.first, 100.0 * visit.whole]
        for case in cases
        for visit in case.visits
    ]
    headers = ["plant", "seed", "object", "touched before", "off in the first 0.5 s [%]", "in all [%]"]
    return Table(headers, rows, "What was felt of each object, touch by touch.")


CASES: Final = DrawnCases(
    name="scene",
    label="seeds",
    usual=1,
    tasks=each_draw(run_case, PLANTS),
    title="Several objects",
    heading="Several objects",
    by="By touch",
    judge=judge,
    one_by_one=True,
)
STUDIES: Final = CASES.studies
