"""Logs of an arm as sums over blocks, from which any set of effects is fitted and held out at no cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from mmt_drake.arms.arm_effect import Shape
from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.believed import PreparedLog, coefficients, inertias, prepared
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.joint_motion import JointMotion
from mmt_drake.arms.laws import ARM_EFFECTS, ARM_WIDE, BESIDE, DRY, OF_THE_LINKS, VISCOUS
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.shapes import likely_delay, likely_geared, likely_ripples
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags

BLOCKS = 24
"""Blocks of one log, if it is long enough; every third is outer: it reports, and nothing is chosen or fitted by it."""
OUTER_EVERY = 3
_FAINT = 0.02
"""Effects of the torque that moves the links are not told where that is less than this part of the torque."""
_SHORTEST_S = 0.5
_FEWEST = 12
"""Blocks of all logs together."""
_WAVES = 5
"""Half waves of a curve over the way of a joint that stands for anything smooth."""
STILL = 2e-3
"""A joint whose way is shorter than this [rad] or [m] does not move."""


@dataclass(frozen=True)
class Term:
    """One effect with a shape on one joint, or on the arm: the columns that stand for it.

    Attributes:
        effect: its name.
        where: joint or link, or empty.
        shape: numbers that are not fitted by themselves.
        columns: where they stand among the columns of a joint.
    """

    effect: str
    where: str
    shape: Shape
    columns: tuple[int, ...]

    @property
    def key(self) -> tuple[str, str]:
        """Which effect it is, and where; shapes apart."""
        return self.effect, self.where


@dataclass(frozen=True)
class JointRows:
    """What one joint has to explain, and with what.

    Attributes:
        joint: its number.
        target: (n,) torque that the believed model does not explain [N m].
        measured: (n,) torque [N m].
        columns: (n, 10 links + terms) torque for one unit of each number.
        counted: (n,) samples that were recorded and at which the joint moves.
        turns: (n,) samples at which it turns over, or nearly so.
        block: (n,) number of the block of each sample.
        blocks: how many there are.
        terms: of this joint.
        held: effect and place -> numbers that the model has of it: what is found comes on top.
        curve: columns of a smooth curve over its way, which have no name.
    """

    joint: int
    target: Array
    measured: Array
    columns: Array
    counted: Flags
    turns: Flags
    block: Array
    blocks: int
    terms: tuple[Term, ...]
    held: Mapping[tuple[str, str], Array] = field(default_factory=dict)
    curve: tuple[int, ...] = ()

    @cached_property
    def sums(self) -> tuple[Array, Array, Array, Array]:
        """Of each block: columns by columns (b, k, k), columns by target (b, k), target squared (b,), samples (b,)."""
        count, k = self.blocks, self.columns.shape[1]
        gram, rhs = np.zeros((count, k, k)), np.zeros((count, k))
        energy, samples = np.zeros(count), np.zeros(count)
        for b in range(count):
            own = self.counted & (self.block == b)
            x, y = self.columns[own], self.target[own]
            gram[b], rhs[b], energy[b], samples[b] = x.T @ x, x.T @ y, y @ y, len(y)
        return gram, rhs, energy, samples

    @cached_property
    def told(self) -> Flags:
        """Columns that are not next to nothing, (k,): a number of one that is would be anything."""
        size = np.sqrt(np.einsum("bkk->k", self.sums[0]) / max(float(self.sums[3].sum()), 1.0))
        told: Flags = size > 0.0
        for term in self.terms:
            if term.effect in OF_THE_LINKS:
                told[list(term.columns)] = size[list(term.columns)] > _FAINT * self.measured.std()
        return told

    def spread(self, blocks: Sequence[int] | Array) -> float:
        """Standard deviation of the measured torque over blocks [N m]."""
        own = self.counted & np.isin(self.block, blocks)
        return float(self.measured[own].std()) if own.any() else 0.0


@dataclass(frozen=True)
class ArmProblem:
    """Logs of one arm.

    Attributes:
        arm: whose.
        links: names of the links whose inertial numbers may be others.
        nominal: (10 links,) the numbers believed.
        rows: of each joint.
        starts: time at which each block begins and ends [s], and its log, (blocks, 3).
        moving: joints that move.
        delay: by which all torques may be late [s].
    """

    arm: ArmPlant
    nominal: Array
    rows: tuple[JointRows, ...]
    starts: Array
    moving: tuple[int, ...]
    delay: float

    @property
    def links(self) -> tuple[str, ...]:
        """Whose inertial numbers may be others."""
        return self.arm.links

    @property
    def inner(self) -> list[int]:
        """Blocks that choose."""
        return [b for b in range(len(self.starts)) if b % OUTER_EVERY != OUTER_EVERY - 1]

    @property
    def outer(self) -> list[int]:
        """Blocks that report."""
        return [b for b in range(len(self.starts)) if b % OUTER_EVERY == OUTER_EVERY - 1]

    @property
    def mass(self) -> float:
        """Of all its links [kg]."""
        return float(self.nominal[::10].sum())

    @cached_property
    def between_turns(self) -> ArmProblem:
        """The same logs, each joint only while it is under way."""
        return replace(self, rows=tuple(replace(row, counted=row.counted & ~row.turns) for row in self.rows))

    def known(self, key: tuple[str, str]) -> Array:
        """Numbers that the model has of an effect at a place."""
        return next(row.held[key] for row in self.rows if key in row.held)

    @cached_property
    def scale(self) -> Array:
        """How far each inertial number may be expected to be off, (10 links,)."""
        return expected_sizes(self.nominal)


def expected_sizes(nominal: Array) -> Array:
    """What each inertial number may be, by mass and size of its link, (10 links,).

    Args:
        nominal: (10 links,) as believed.
    """
    scales = []
    heaviest = max(float(nominal.reshape(-1, 10)[:, 0].max()), 1e-3)
    for numbers in nominal.reshape(-1, 10):
        mass = max(float(numbers[0]), 0.05 * heaviest)
        arm = max(float(np.sqrt(abs(numbers[4:7]).max() / mass)), float(np.linalg.norm(numbers[1:4])) / mass, 0.05)
        scales += [mass, *[mass * arm] * 3, *[mass * arm**2] * 6]
    return np.array(scales)


def arm_problem(arm: ArmPlant, model: ArmModel, logs: Sequence[JointLog]) -> ArmProblem:
    """The problem of explaining logs, see `problem_of`."""
    return problem_of(arm, model, [prepared(arm, model, log) for log in logs])


def problem_of(arm: ArmPlant, model: ArmModel, every: Sequence[PreparedLog], delay: float | None = None) -> ArmProblem:
    """The problem of explaining logs.

    Args:
        arm: of the model.
        model: what is believed.
        every: logs of that arm, held against the model.
        delay: by which all torques may be late [s]; what the logs suggest unless given.

    Raises:
        BadInput: a log is too short, or nothing moves.
    """
    edges = [_edges(one.motion) for one in every]
    if (count := sum(len(e) - 1 for e in edges)) < _FEWEST:
        seconds = sum(one.log.duration for one in every)
        found, expected = f"{seconds:.3g} s", f"{_FEWEST * _SHORTEST_S + 1:g} s or more, of one log or of several"
        raise BadInput(every[0].log.source, found=f"{found} ({count} blocks)", expected=expected)
    moves = tuple(j for j in range(len(arm.joints)) if any(np.ptp(one.motion.q[:, j]) > STILL for one in every))
    if not moves:
        raise BadInput(every[0].log.source, found="no joint that moves", expected=f"a way of {STILL:g} rad or more")
    numbers = inertias(arm, model)
    delay = likely_delay(every, moves) if delay is None else delay
    rows = tuple(_joint_rows(arm, model, numbers, every, j, j in moves, delay) for j in range(len(arm.joints)))
    starts = np.concatenate([np.column_stack([e[:-1], e[1:], np.full(len(e) - 1, i)]) for i, e in enumerate(edges)])
    return ArmProblem(arm, numbers.ravel(), rows, starts, moves, delay)


def _edges(motion: ArmMotion) -> Array:
    """Times at which the blocks of a log begin and end; one alone where none is long enough."""
    kept = motion.time[motion.thinning]
    if len(kept) < 2:
        return np.empty(0)
    count = min(BLOCKS, max(1, int((kept[-1] - kept[0]) / _SHORTEST_S)))
    return np.linspace(kept[0], kept[-1], count + 1)


def _joint_rows(
    arm: ArmPlant, model: ArmModel, numbers: Array, every: Sequence[PreparedLog], j: int, moves: bool, delay: float
) -> JointRows:
    motions = [one.joint(j) for one in every]
    ripples = likely_ripples(every, j) if moves else ()
    fastest = max(motions, key=lambda motion: motion.fastest)
    likely = replace(fastest, ripples=ripples, delays=(delay,), geared=likely_geared(every, j))
    terms, held = _terms(arm, model, likely, j, moves)
    stacked, target, measured, counted, turns, block, first = [], [], [], [], [], [], 0
    low, high = min(own.q.min() for own in motions), max(own.q.max() for own in motions)
    for one, own in zip(every, motions, strict=True):
        parts = [one.asked.inertial[:, j]]
        for term in terms:
            if term.columns[0] >= len(numbers) * 10:
                columns = one.columns(arm, term.effect, term.where, term.shape, j)
                assert columns is not None  # of a term of this joint
                parts.append(columns)
        parts.append(_curve(own.q, low, high))
        taken = one.motion.thinning
        whole = one.motion.filtered(np.concatenate([*parts, one.believed[:, [j]]], axis=1))[taken]
        stacked.append(whole[:, :-1])
        measured.append(one.motion.torque[taken, j])
        target.append(measured[-1] - whole[:, -1])
        counted.append((one.counted(j) if moves else one.motion.recorded)[taken])
        turns.append(one.turns(j)[taken])
        edges = _edges(one.motion)
        number = np.searchsorted(edges, one.motion.time[taken], side="right") - 1
        block.append(first + np.clip(number, 0, len(edges) - 2))
        first += len(edges) - 1
    columns = np.concatenate(stacked)
    return JointRows(
        joint=j,
        target=np.concatenate(target),
        measured=np.concatenate(measured),
        columns=columns,
        counted=np.concatenate(counted),
        turns=np.concatenate(turns),
        block=np.concatenate(block),
        blocks=first,
        terms=terms,
        held=held,
        curve=tuple(range(columns.shape[1] - _WAVES, columns.shape[1])),
    )


def _curve(q: Array, low: float, high: float) -> Array:
    """Half a wave over the way of a joint, two, ..., (n, _WAVES): with a constant they make any smooth curve."""
    way = (q - low) / max(high - low, 1e-9)
    return np.cos(np.pi * np.outer(way, np.arange(1, _WAVES + 1)))


def _terms(
    arm: ArmPlant, model: ArmModel, motion: JointMotion, j: int, moves: bool
) -> tuple[tuple[Term, ...], dict[tuple[str, str], Array]]:
    """The terms of a joint, those that the regressor has columns for last; and numbers that the model has of some."""
    names = (*DRY, *VISCOUS, *BESIDE) if moves else ("constant_force",)
    known = {(e.name, e.where): coefficients(arm, e) for e in model.effects}
    terms, at = list[Term](), 10 * len(arm.links)
    placed = [(name, arm.joints[j] if ARM_EFFECTS[name].place == "joint" else "") for name in (*names, *ARM_WIDE)]
    for name, where in [*placed, *(("joint_elasticity", joint) for joint in arm.joints)]:
        own = known.get((name, where))
        for shape in [own[1]] if own is not None else ARM_EFFECTS[name].shapes(motion):
            width = len(ARM_EFFECTS[name].least)
            terms.append(Term(name, where, shape, tuple(range(at, at + width))))
            at += width
    terms += [Term("payload", link, (), tuple(range(10 * k, 10 * k + 10))) for k, link in enumerate(arm.links)]
    return tuple(terms), {key: x for key, (x, _) in known.items()}
