"""Objects that are lifted, swung and put down: what is felt of them, what is told, and whether it makes energy."""

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from numba import njit

from mmt_drake.analysis.carried import LIFTED, carried_errors, share_of
from mmt_drake.analysis.signals import vector
from mmt_drake.analysis.wording import in_percent, significant
from mmt_drake.diagrams.proof.experiments.passivity import ALLOWED, STEP, strokes, wild_sets
from mmt_drake.diagrams.proof.experiments.targets import (
    CARRIED,
    CARRIED_LATE,
    CARRIED_MASS,
    CARRIED_PACE,
    CARRIED_SLIP,
    GIVEN,
)
from mmt_drake.diagrams.proof.studies.columns import Column, tabled
from mmt_drake.diagrams.proof.studies.drawn import DrawnCases, DrawnFindings
from mmt_drake.diagrams.proof.studies.of_known import of_known
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.estimation.carried import SLIPS
from mmt_drake.model.held_body import NO_REPORT
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.recording import Recording, load
from mmt_drake.rendering import carried
from mmt_drake.rendering.impedance import MEMORY_SIZE, READOUT_SIZES, render
from mmt_drake.rendering.updates import EnergyPermitting, renderer_rule

ADVERSARIES: Final = 50
"""To a draw."""
TICKS: Final = 4000
"""Of one."""
SIGNALS: Final = ("true", "dead", "noisy")
"""What becomes of the velocity that the renderer on the table reads."""
_TOLD_S, _SOON_S = 3.0, 0.03  # [s]


@dataclass(frozen=True)
class CarryingKind:
    """A kind of run: plant `own` or `foreign`, delay each way [s], force of the grip [N], whether that is too weak."""

    plant: str
    delay: float
    grip: float = 10.0
    slips: bool = False

    @property
    def label(self) -> str:
        """For a table."""
        return f"{self.plant}, {1e3 * self.delay:g} ms{', a weak grip' if self.slips else ''}"

    def scenario(self, number: int, seed: int) -> Scenario:
        """`setup1-carrying` so; of each number another draw of object and noise, the first as it ships."""
        random = np.random.default_rng((seed, number))
        m, centre = (0.3, 0.05) * (random.uniform(0.7, 1.4, 2) if number else np.ones(2))
        changes: dict[str, str | float] = {
            "seed": 1000 * seed + number,
            "environment.object.parameters.m": m,
            "carrying.hang.centre": centre,
        }
        changes |= {"carrying.grip": self.grip * m / 0.3, "to_telerobot.delay": self.delay}
        changes |= {"to_operator.delay": self.delay, "clouds": "none"}
        changes |= {"environment.!": "ForeignBox"} if self.plant == "foreign" else {}
        return load_scenario("setup1-carrying", [f"{key}={json.dumps(value)}" for key, value in changes.items()])


KINDS: Final = (
    *(CarryingKind(plant, delay) for plant in ("own", "foreign") for delay in (0.0, 0.4)),
    *(CarryingKind(plant, 0.0, 5.2, slips=True) for plant in ("own", "foreign")),
)


@dataclass(frozen=True)
class CarryingCase:
    """One run, or one adversary, of which only the energy is known.

    Attributes:
        number: of the draw.
        kind: `CarryingKind.label`, or what became of the velocity.
        force: error of the rendered force while it is carried, against the plant's without noise a delay later, RMS.
        across: the same along x and y alone, where only the swing is felt: before its centre is told, none is.
        mass: error of the mass 3 s after it was lifted.
        late_s: how far lift and landing of the operator's copy, and as the telerobot tells them, are from the truth at
            most [s].
        slip_s: how long after the first slip in the air it was told [s]; infinite: never; None: there was none.
        given: the most energy that the hand had got out beyond what it had put in, at any time [J].
        pace: real time over simulated time.
    """

    number: int
    kind: str
    force: float | None
    across: float | None
    mass: float | None
    late_s: float | None
    slip_s: float | None
    given: float
    pace: float | None


def run_case(number: int, kind: CarryingKind, seed: int) -> CarryingCase:
    """One object, carried."""
    scenario = kind.scenario(number, seed)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        station = build_station(scenario, record=file)
        began = time.perf_counter()
        station.simulate()
        pace = (time.perf_counter() - began) / station.duration
        return measured(number, kind, load(file), scenario.environment.object.parameters.m, pace)


def measured(number: int, kind: CarryingKind, recording: Recording, m: float, pace: float) -> CarryingCase:
    """What a recording says; `m` is the true mass [kg]."""
    columns, ticks = recording.columns, round(kind.delay / STEP)
    there = slice(ticks, None)  # what the plant does with what the operator does `ticks` before
    here = slice(None, len(recording.time) - ticks)
    rendered, hand = vector(recording, "rendered_force"), vector(recording, "master_position")
    height, copy, state = columns["body_height"][there], columns["carries"][here] > 0.0, columns["carried_state"][there]
    flies = height > LIFTED
    off, true = carried_errors(recording, ticks)
    lifted = int(np.argmax(flies))
    told = columns["carried_m"][there][lifted + round(_TOLD_S / STEP)]
    edges = [(int(np.argmax(what)), len(what) - int(np.argmax(what[::-1]))) for what in (flies, copy, state >= 2.0)]
    late = max(abs(edge - true) for found in edges[1:] for edge, true in zip(found, edges[0], strict=True)) * STEP
    slipping = np.flatnonzero((np.diff(columns["grip_slipped"][there], prepend=0.0) > 0.0) & flies)
    slip = None
    if len(slipping):
        after = np.flatnonzero(state[slipping[0] :] >= SLIPS)
        slip = float(after[0]) * STEP if len(after) else np.inf
    energy = -np.cumsum(np.sum(rendered[:-1] * np.diff(hand, axis=0), axis=1))
    return CarryingCase(
        number,
        kind.label,
        None if kind.slips else share_of(off, true),
        None if kind.slips else share_of(off[:, :2], true[:, :2]),
        None if kind.slips else float(abs(told / m - 1.0)),
        None if kind.slips else float(late),
        slip,
        float(max(0.0, -energy.min())),
        pace,
    )


@njit(cache=True)
def _played(
    path: Array,
    seen: Array,
    theta: Array,
    contact: Array,
    load: Array,
    grip: Array,
    believed: Array,
    rule: Array,
    yields: float,
) -> float:
    """The least energy [J] that the hand had put in at any time; arguments as for `passivity.played`."""
    on, off = np.zeros(sum(READOUT_SIZES)), np.zeros(carried.MEMORY + carried.MEMORY_SIZE)
    memory, own, force = np.zeros(MEMORY_SIZE), np.zeros(carried.MEMORY_SIZE), np.zeros(3)
    hand, motion, away, rate = path[0].copy(), np.zeros(6), np.zeros(3), np.zeros(3)
    energy, least = 0.0, 0.0
    for k in range(len(path)):
        for i in range(3):
            rate[i] += STEP * min(max(yields * force[i] - 20.0 * rate[i] - 100.0 * away[i], -15.0), 15.0)
            away[i] += STEP * rate[i]
            step = path[k, i] + away[i] - hand[i]
            energy -= force[i] * step
            hand[i] += step
            motion[i], motion[3 + i] = hand[i], seen[k, 0] * step / STEP + seen[k, 1 + i]
        least = min(least, energy)
        touches = contact[k] if hand[2] < 0.0 else 0.0
        flag = carried.holds_contact(own, touches)
        render(memory, k * STEP, motion, motion, theta[k], 1.0, flag, rule, False, NO_REPORT, on)
        assign(memory, on[len(on) - MEMORY_SIZE :])
        given = own, k * STEP, STEP, motion, on[:3], grip[k], touches, theta[k], load[k]
        carried.carried_force(*given, 0.0, believed[k, 0], believed[k, 1], rule, off)
        assign(own, off[carried.MEMORY :])
        assign(force, off[:3])
    return least


def run_adversary(number: int, seed: int) -> CarryingCase:
    """Wild numbers of contact and load, a grip that opens in the air, a velocity that is wrong."""
    random = np.random.default_rng((seed, number, 7))
    signal = SIGNALS[number % len(SIGNALS)]
    path = strokes(random, TICKS, (0.02, 0.02, 0.03), 20.0)
    seen = np.zeros((TICKS, 4))
    seen[:, 0] = 0.0 if signal == "dead" else 1.0
    if signal == "noisy":
        seen[:, 1:] = random.normal(0.0, random.uniform(0.02, 0.5), (TICKS, 3))
    theta = np.concatenate([wild_sets(random)[0] for _ in range(2)])[:TICKS]
    every = int(random.choice([1, 30, 300]))
    count = TICKS // every + 1
    load = np.zeros((count, 5))
    load[:, 0] = random.choice([1.0, 2.0, 2.0, 2.0, 3.0, 4.0], count) if random.random() < 0.3 else 2.0
    load[:, 1:4] = np.exp(random.uniform(np.log([0.01, 0.003, 1e-3]), np.log([2.0, 0.5, 2.0]), (count, 3)))
    load[random.random(count) < 0.05, 1:4] = np.nan
    load[:, 4] = 10.0
    grip = np.repeat(10.0 * (random.random(TICKS // 200) > 0.1), 200)
    contact = np.repeat((random.random(TICKS // 50) > 0.05) * 1.0, 50)
    believed = np.column_stack([random.choice([0.0, 1.0, 2.0], 20), np.exp(random.uniform(-5.3, -0.7, 20))])
    given = _played(
        path,
        seen,
        theta,
        contact,
        np.ascontiguousarray(np.repeat(load, every, axis=0)[:TICKS]),
        grip,
        np.ascontiguousarray(np.repeat(believed, TICKS // 20, axis=0)),
        renderer_rule(EnergyPermitting(), STEP, 1),
        float(random.choice([0.0, 0.5, 5.0])),
    )
    return CarryingCase(number, f"adversary, velocity {signal}", None, None, None, None, None, max(0.0, -given), None)


def tasks_of(count: int, seed: int) -> list[partial[CarryingCase]]:
    """Every kind with so many objects, and `ADVERSARIES` for each."""
    runs = [partial(run_case, number, kind, seed) for number in range(count) for kind in KINDS]
    return runs + [partial(run_adversary, number, seed) for number in range(ADVERSARIES * count)]


def _milliseconds(span: float | None) -> float | None:
    return None if span is None else 1e3 * span


COLUMNS: Final[tuple[Column[CarryingCase], ...]] = (
    Column(lambda case: case.kind, "", "plant and delay"),
    Column(lambda case: case.number, "", "draw"),
    Column(lambda case: case.force, "", "force off [%]", in_percent),
    Column(lambda case: case.across, "", "along x and y [%]", in_percent),
    Column(lambda case: case.mass, "", "mass off after 3 s [%]", in_percent),
    Column(lambda case: case.late_s, "", "lift and landing late [ms]", _milliseconds),
    Column(lambda case: case.slip_s, "", "slip told after [ms]", _milliseconds),
    Column(lambda case: case.given, "", "energy given [J]"),
    Column(lambda case: case.pace, "", "times real time", lambda pace: 1.0 / pace if pace else None),
)
"""Of the table, run by run."""


def judge(cases: Sequence[CarryingCase], seed: int) -> DrawnFindings:
    """What it comes to."""
    runs = [case for case in cases if case.pace is not None]
    reached: list[Reached] = []
    for kind in dict.fromkeys(case.kind for case in runs):
        some = [case for case in runs if case.kind == kind]
        figures = {CARRIED: "force", CARRIED_MASS: "mass", CARRIED_LATE: "late_s", CARRIED_PACE: "pace"}
        for target, name in figures.items():
            worst = of_known(max, (getattr(case, name) for case in some))
            reached += [] if worst is None else [Reached(kind, target, worst)]
    slips = [case.slip_s for case in runs if case.slip_s is not None]
    untold = float(sum(slip > _SOON_S for slip in slips))
    reached += [Reached(f"{len(slips)} runs with a slip", CARRIED_SLIP, untold)] if slips else []
    broken, worst_given = sum(case.given > ALLOWED for case in cases), max(case.given for case in cases)
    reached.append(Reached(f"{len(cases)} runs and adversaries", GIVEN, float(broken)))
    sentences = [
        f"{broken} of {len(runs)} runs and {len(cases) - len(runs)} adversaries give more than {ALLOWED:g} J that was "
        f"not put in; the most is {significant(worst_given, 2)} J.",
        f"{len(slips) - int(untold)} of {len(slips)} slips were told within {_SOON_S:g} s.",
    ]
    lead = (
        "Set-up 1 as `setup1-carrying` has it: an object is pushed, lifted, swung, carried across and put down "
        "(the first draw; others scatter by 0.7 to 1.4 in mass and centre). Errors are of the rendered force "
        "while it is off the table, all three axes, against the plant's without noise. The foreign plant is a "
        "rigid rod in space that shares nothing with the model. Adversaries "
        "change every number, the grip and the contact at random "
        f"for {TICKS * STEP:g} s; seed {seed}."
    )
    return DrawnFindings(lead, tabled(runs, COLUMNS, "What was felt, and what was told."), sentences, reached)


CASES: Final = DrawnCases(
    name="carrying",
    label="runs",
    usual=1,
    tasks=tasks_of,
    title="What is carried is felt",
    heading="Carried",
    by="By plant and delay",
    judge=judge,
)
STUDIES: Final = CASES.studies
