"""Adversaries of a renderer: parameters, contact, velocity and hands that are made to get energy out of it.

Renderers of the shipped scenarios, tick by tick in a compiled loop, as they are and with other policies of updates.
Parameters are drawn anew all the time, far apart, some of them no model, and others whenever the force pushes the hand;
the estimator is now sure of them and now not; contact comes late or flickers; where friction holds the body is
invented; where there is a learner laws come and go, out of turn now and then; the hand strokes and presses, stiff or
yielding to what it feels, within `HAND_ACCELERATION`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Final

import numpy as np
from numba import njit

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import significant
from mmt_drake.diagrams.proof.experiments.learning import LAWS
from mmt_drake.diagrams.proof.experiments.targets import GIVEN, UPDATE_JUMP_N
from mmt_drake.diagrams.proof.studies.drawn import DrawnCases, DrawnFindings
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.diagrams.stations.renderers import ImpedanceReflection
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.shipped import shipped
from mmt_drake.errors import BadInput
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model_message import ModelMessage, ToldEffect
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.rendering.impedance import MEMORY_SIZE, NO_PLANE, PORT_SIZES, drop_laws, render_on
from mmt_drake.rendering.updates import AtOnce, Blended, Policy, RateLimited, renderer_rules
from mmt_drake.systems.compliant_tip import advance_tip, step_of_tip
from mmt_drake.told_laws import NO_LAWS, NUMBER, told_by

STEP: Final = 1e-3
TICKS: Final = 2000
"""Of a run."""
ALLOWED: Final = 1e-5
"""Energy [J] that may be given before a run counts."""
SIGNALS: Final = ("true", "dead", "frozen", "noisy")
"""What becomes of the velocity: differences of positions; 0; it stays as it is for a while; up to 0.5 m/s of noise."""
AS_SHIPPED: Final = "as shipped"
POLICIES: Final[Mapping[str, Policy | None]] = {
    AS_SHIPPED: None,
    "at once": AtOnce(),
    "rate-limited": RateLimited(),
    "blended": Blended(),
}

_JUMP = PORT_SIZES["force"] + PORT_SIZES["status"]
_MEMORY = sum(PORT_SIZES.values())
_LAWS = {**LAWS, "contact_gap": {"gap": 0.004}, "asymmetric_friction": {"Fc_plus": 2.0, "Fc_minus": 0.5}}
"""All that messages may tell of the friction, the body and the contact."""
_LOW = np.array([0.05, 0.1, 10.0, 0.1, 0.1, 0.01, 10.0, 0.1, 0.01, 1e-3])
_HIGH = np.array([5.0, 1000.0, 5000.0, 200.0, 200.0, 5.0, 5000.0, 200.0, 5.0, 0.02])
_YIELDING_HZ, _YIELDS = 1.5, 15.0  # of a hand that is led back to its path; its acceleration at most [m/s^2] an axis


@dataclass(frozen=True)
class EnergyRun:
    """One adversary against one renderer.

    Attributes:
        number: of the draw.
        policy: a key of `POLICIES`.
        scenario: whose renderer it is.
        signal: one of `SIGNALS`.
        given: the most energy that the hand had got out beyond what it had put in, at any time [J].
        jump: the largest change of the force that an update made [N].
    """

    number: int
    policy: str
    scenario: str
    signal: str
    given: float
    jump: float


@njit(cache=True)
def played(
    path: Array,
    theta: Array,
    pushing: Array,
    stable: Array,
    contact: Array,
    held: Array,
    late: int,
    signal: Array,
    noise: Array,
    yields: float,
    rules: tuple[Array, Array],
    unsure: Array,
    placed: bool,
    arm: tuple[Array, Array, Array] | None,
    told: Array,
    which: Array,
) -> tuple[float, float]:
    """The least energy [J] that the hand had put in at any time, and the largest jump of an update [N].

    The force of a tick is held until the next. The energy is counted with it, at the hand.

    Args:
        path: (n, 3) of the hand [m].
        theta, pushing: (n, 10) parameters, and those in their place while the force pushes the hand on.
        stable: (n,) of both.
        contact: (n,) 1: as the probe is below the surface, 0: the other way round.
        held: (n, HELD_SIZE) where friction holds the body, as is said.
        late: by how many ticks contact comes late.
        signal: (n,) the part of the velocity that is seen; NaN: what was seen last.
        noise: (n, 3) that is added to it [m/s].
        yields: acceleration of the hand by a force [1/kg].
        rules: of the policy, while the estimator is sure and while it is not.
        unsure: (n,) 1 while it is not.
        placed: the renderer has no velocity.
        arm: `step_of_tip` of one between hand and probe.
        told: (k, TOLD_SIZE) what messages tell of laws.
        which: (n,) of them is the latest.
    """
    memory, out = np.zeros(MEMORY_SIZE), np.zeros(_MEMORY + MEMORY_SIZE)
    motion, tip, hand, force = np.zeros(6), np.zeros(7), np.zeros(3), np.zeros(3)
    away, rate, touching = np.zeros(3), np.zeros(3), np.zeros(len(path))
    assign(tip[:3], path[0])
    assign(hand, path[0])
    energy, least, jump, stiff = 0.0, 0.0, 0.0, 2.0 * np.pi * _YIELDING_HZ
    for k in range(len(path)):
        power = 0.0
        for i in range(3):
            pull = yields * force[i] - 2.0 * stiff * rate[i] - stiff * stiff * away[i]
            rate[i] += STEP * min(max(pull, -_YIELDS), _YIELDS)
            away[i] += STEP * rate[i]
            step = path[k, i] + away[i] - hand[i]
            power += force[i] * step
            hand[i] += step
            if np.isfinite(signal[k]):
                motion[3 + i] = 0.0 if placed else signal[k] * step / STEP + noise[k, i]
            motion[i] = hand[i]
        energy -= power
        least = min(least, energy)
        probe = motion
        if arm is not None:
            probe = tip[:6]
        touching[k] = contact[k] if probe[2] < 0.0 else 1.0 - contact[k]
        flag = touching[max(k - late, 0)]
        latest = pushing[k] if power > 0.0 else theta[k]
        laws, rule = told[int(which[k])], rules[int(unsure[k])]
        t, sure, told_held = k * STEP, stable[k], held[k]
        try:
            render_on(
                memory, t, probe, motion, latest, sure, flag, rule, placed, told_held, NO_PLANE, 1.0, np.inf, laws, out
            )
        except Exception:  # laws that are too fast: the renderer goes on without them
            drop_laws(memory, laws[NUMBER])
            render_on(
                memory, t, probe, motion, latest, sure, flag, rule, placed, told_held, NO_PLANE, 1.0, np.inf, laws, out
            )
        if arm is not None:
            advance_tip(tip, motion, out[:3], *arm)
        assign(memory, out[_MEMORY:])
        assign(force, out[:3])
        jump = max(jump, np.sqrt(out[_JUMP] ** 2 + out[_JUMP + 1] ** 2 + out[_JUMP + 2] ** 2))
    return least, jump


def run_adversary(number: int, policy: str, seed: int) -> EnergyRun:
    """One draw against one policy; the draws are the same for all of them."""
    names = shipped()
    name, signal = names[number % len(names)], SIGNALS[number // len(names) % len(SIGNALS)]
    renderer = _renderer(name)
    rules = renderer_rules(POLICIES[policy] or renderer.updates, STEP, renderer.substeps, renderer.in_plane)
    random = np.random.default_rng((seed, number))
    theta, stable = wild_sets(random)
    pushing = wild_sets(random)[0] if random.random() < 0.5 else theta
    contact = np.repeat(random.random(TICKS // 20) > random.choice([0.0, 0.05]), 20).astype(float)
    late = int(random.choice([0, 0, 5, 200]))
    noise = np.zeros((TICKS, 3))
    seen = np.ones(TICKS)
    if signal == "dead":
        seen[:] = 0.0
    elif signal == "frozen":
        seen[np.repeat(random.random(TICKS // 500) < 0.7, 500)] = np.nan
    elif signal == "noisy":
        noise = random.normal(0.0, random.uniform(0.02, 0.5), noise.shape)
    arm = None if renderer.arm is None else step_of_tip(renderer.arm.tip, STEP)
    given, jump = played(
        _hand(random),
        theta,
        pushing,
        stable,
        contact,
        _invented(random),
        late,
        seen,
        noise,
        float(random.choice([0.0, 0.5, 5.0])),
        rules,
        _unsure(random),
        renderer.probe == "placed",
        arm,
        *_messages(random, load_scenario(name).learner is not None),
    )
    return EnergyRun(number, policy, name, signal, max(0.0, -given), jump)


@cache
def _renderer(scenario: str) -> ImpedanceReflection:
    renderer = load_scenario(scenario).renderer
    assert isinstance(renderer, ImpedanceReflection)  # every shipped one is
    return renderer


def wild_sets(random: np.random.Generator) -> tuple[Array, Array]:
    """(n, 10) parameters that are drawn anew every 1 to 300 ms, and which of them may be rendered."""
    every = int(random.choice([1, 10, 50, 300]))
    count = TICKS // every + 1
    sets = _LOW * (_HIGH / _LOW) ** random.random((count, len(_LOW)))
    sets[random.random(count) < 0.05] *= np.where(random.random(len(_LOW)) < 0.2, -1.0, 1.0)
    sets[random.random(count) < 0.02] = np.nan
    stable = (random.random(count) > 0.05) * 1.0
    return np.repeat(sets, every, axis=0)[:TICKS], np.repeat(stable, every)[:TICKS]


def _messages(random: np.random.Generator, learner: bool) -> tuple[Array, Array]:
    """What messages tell of laws (k, TOLD_SIZE), and which is the latest (n,): nothing where there is no learner.

    A new one every 0.1 s of none to two laws, of sizes far apart; some come late, behind a later one.
    """
    if not learner:
        return NO_LAWS[np.newaxis], np.zeros(TICKS)
    told = []
    for number in range(1, TICKS // 100 + 1):
        names = random.permutation(list(_LAWS))[: random.integers(3)]
        effects = tuple(
            ToldEffect(
                name, {symbol: value * 5.0 ** random.uniform(-1.0, 1.0) for symbol, value in _LAWS[name].items()}
            )
            for name in names.tolist()
        )
        told.append(_told(effects, number))
    which = np.arange(len(told))
    late = np.flatnonzero(random.random(len(told) - 1) < 0.1)
    which[late], which[late + 1] = late + 1, late
    return np.array(told), np.repeat(which, 100).astype(np.float64)


def _told(effects: tuple[ToldEffect, ...], number: int) -> Array:
    """(TOLD_SIZE,) of a message with these effects; of one without any, where they cannot stand side by side."""
    theta = tuple(map(float, np.sqrt(_LOW * _HIGH)))
    try:
        return told_by(ModelMessage(theta, effects, number=number))
    except BadInput:
        return told_by(ModelMessage(theta, number=number))


def strokes(random: np.random.Generator, ticks: int, sizes: Sequence[float], fastest: float) -> Array:
    """(n, 3) a hand that strokes by three sines along each axis, of these sizes [m], at `fastest` at most [rad/s]."""
    time = np.arange(ticks) * STEP
    path = np.zeros((ticks, 3))
    for axis, size in enumerate(sizes):
        for _ in range(3):
            rate = np.exp(random.uniform(0.0, np.log(fastest)))
            path[:, axis] += size / 3.0 * np.sin(rate * time + random.uniform(0.0, 6.3))
    return path


def _hand(random: np.random.Generator) -> Array:
    """(n, 3) strokes in and out of contact [m]."""
    path = strokes(random, TICKS, (0.01, 0.02, 0.006), 25.0)
    path[:, 2] -= random.uniform(-0.002, 0.006)
    return path


def _invented(random: np.random.Generator) -> Array:
    """(n, HELD_SIZE) reports of where friction holds the body that have nothing to do with it."""
    held = np.repeat(random.normal(0.0, 0.01, (TICKS // 100, HELD_SIZE)), 100, axis=0)
    held[:, [2, 5, 6]] = (np.arange(TICKS) * STEP)[:, np.newaxis]
    return held if random.random() < 0.5 else np.zeros_like(held)


def _unsure(random: np.random.Generator) -> Array:
    """(n,) 1 while the estimator is not sure of its numbers: never, or half of the time."""
    return np.repeat(random.random(TICKS // 100) < random.choice([0.0, 0.5]), 100).astype(np.float64)


def tasks_of(count: int, seed: int) -> list[partial[EnergyRun]]:
    """Every draw against what is shipped, a tenth of them against each other policy."""
    return [
        partial(run_adversary, number, policy, seed)
        for policy in POLICIES
        for number in range(count if policy == AS_SHIPPED else -(-count // 10))
    ]


def judge(runs: Sequence[EnergyRun], seed: int) -> DrawnFindings:
    """What it comes to."""
    count = sum(run.policy == AS_SHIPPED for run in runs)
    reached, sentences = [], []
    for policy in POLICIES:
        some = [run for run in runs if run.policy == policy]
        broken, worst = sum(run.given > ALLOWED for run in some), max(run.given for run in some)
        said = GIVEN if policy == AS_SHIPPED else replace(GIVEN, to_reach=None)
        reached.append(Reached(policy, said, float(broken)))
        if policy == AS_SHIPPED:
            reached.append(Reached(policy, UPDATE_JUMP_N, max(run.jump for run in some)))
        sentences.append(
            f"{policy}: {broken} of {len(some)} runs give more than {ALLOWED:g} J that was not put in"
            + (f"; the most is {significant(worst, 2)} J." if broken == 0 else ".")
        )
    lead = (
        f"{count} adversaries of {TICKS * STEP:g} s each against the renderers of the shipped scenarios in turn, "
        "and the first tenth against these with other policies of updates: wild parameters, contact that is late "
        "or flickers, an estimator that is now sure and now not, invented reports of where the body is held, laws "
        f"that come and go where there is a learner, a velocity that is {', '.join(SIGNALS)}; seed {seed}. Each "
        "force is held until the next tick and counted "
        "with what the hand moves in it."
    )
    return DrawnFindings(lead, passivity_table(runs), sentences, reached)


def passivity_table(runs: Sequence[EnergyRun]) -> Table:
    """By policy and signal: how many runs gave energy, and the most."""
    rows: list[list[Cell]] = []
    for policy in POLICIES:
        row: list[Cell] = [policy]
        for signal in SIGNALS:
            given = [run.given for run in runs if (run.policy, run.signal) == (policy, signal)]
            broken = sum(each > ALLOWED for each in given)
            row.append(f"{broken} of {len(given)}")
        rows.append(row)
    headers = ["updates", *(f"velocity {signal}" for signal in SIGNALS)]
    return Table(headers, rows, f"Runs that gave more than {ALLOWED:g} J that was not put in.")


CASES: Final = DrawnCases(
    name="passivity",
    label="runs",
    usual=2000,
    tasks=tasks_of,
    title="Whether a hand gets out more energy than it puts in",
    heading="Energy that nobody put in",
    by="By what becomes of the velocity",
    judge=judge,
)
STUDIES: Final = CASES.studies
