"""Fit of all joints at once: one set of inertial numbers for the whole arm, and the effects of every joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import linalg, stats

from mmt_drake.arms.folds import FOLDS, HELD, SharedNumbers
from mmt_drake.arms.problem import ArmProblem, JointRows, Term
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

_FEWEST_DEGREES = 3
FREE_SAMPLES = 0.05
"""One in so many samples is worth a sample of its own: what is left hangs together in time."""
_TOLD = 1e4
"""... and is told apart if what the others leave of its column is more than one part in so many, in variance."""
OTHER_NUMBERS = "other inertial numbers"
"""The belief that the file's are wrong, in words."""


@dataclass(frozen=True)
class Belief:
    """A belief about the links.

    Attributes:
        name: `none`: they are as the file says; `refit`: each inertial number may be another; else the first effect of
            the whole arm that is added.
        held: terms of what is added, by joint.
        prior: (10 links,) how strongly an inertial number is held where it is [1/unit^2]; None: it is as believed.
    """

    name: str
    held: tuple[Term, ...] = ()
    prior: Array | None = None

    def held_in(self, row: JointRows) -> list[Term]:
        """The terms of the effect among those of a joint, which has it by its name."""
        return [term for held in self.held for term in row.terms if term.key == held.key]

    @property
    def said(self) -> str:
        """What it adds to the file."""
        added = [f"{term.effect} of {term.where}" if term.where else term.effect for term in self.held]
        return " and ".join([OTHER_NUMBERS, *added] if self.name == "refit" else added) or self.name


@dataclass(frozen=True)
class SharedFit:
    """Numbers of the links, of the arm and of each joint, fitted together.

    Attributes:
        problem: what was fitted.
        belief: about the links.
        sets: joint -> its terms, in the order of its numbers.
        weights: (joints,) of each joint's squared error [1/(N m)^2].
    """

    problem: ArmProblem
    belief: Belief
    sets: Mapping[int, tuple[Term, ...]]
    weights: Array

    @cached_property
    def _links(self) -> int:
        return 0 if self.belief.prior is None else len(self.belief.prior)

    @cached_property
    def _numbers(self) -> dict[int | None, list[tuple[Term, list[int]]]]:
        """Each term of the arm, None, and of the joints one after the other, and where its numbers stand in x."""
        of_joints = {row.joint: self.sets.get(row.joint, ()) for row in self.problem.rows}
        found: dict[int | None, list[tuple[Term, list[int]]]] = {}
        place = Layout()
        place(self._links)
        for of, terms in ((None, self.belief.held), *of_joints.items()):
            parts = [(term, place.part(len(term.columns))) for term in terms]
            found[of] = [(term, list(range(part.start, part.stop))) for term, part in parts]
        return found

    @cached_property
    def _places(self) -> list[tuple[list[int], list[int]]]:
        """For each joint: its columns, and where their numbers stand in x."""
        links = range(self._links)
        places = []
        for row in self.problem.rows:
            terms = [*self.belief.held_in(row), *self.sets.get(row.joint, ())]
            numbers = [n for _, at in (*self.numbers_held, *self.numbers_of(row.joint)) for n in at]
            places.append(([*links, *(c for term in terms for c in term.columns)], [*links, *numbers]))
        return places

    @cached_property
    def size(self) -> int:
        """How many numbers there are."""
        return max((numbers[-1] + 1 for _, numbers in self._places if numbers), default=0)

    def sums(self, blocks: Sequence[int], without: int | None = None) -> tuple[Array, Array]:
        """Normal equations of some blocks: (size, size) and (size,), without the prior, or a joint."""
        matrix, right = np.zeros((self.size, self.size)), np.zeros(self.size)
        for row, weight, (columns, numbers) in zip(self.problem.rows, self.weights, self._places, strict=True):
            if row.joint == without:
                continue
            gram, rhs, _, _ = row.sums
            matrix[np.ix_(numbers, numbers)] += weight * gram[blocks].sum(0)[np.ix_(columns, columns)]
            right[numbers] += weight * rhs[blocks].sum(0)[columns]
        return matrix, right

    def fitted(self, blocks: Sequence[int]) -> Array:
        """The numbers that explain some blocks best."""
        return self._solved(*self.sums(blocks))

    @cached_property
    def prior(self) -> Array:
        """How strongly each number is held at 0, (size,)."""
        prior = np.zeros(self.size)
        if self.belief.prior is not None:
            prior[: self._links] = self.belief.prior
        return prior

    def _solved(self, matrix: Array, right: Array) -> Array:
        whole = matrix + np.diag(self.prior)
        scaled, size = _scaled(whole)
        solved: Array = linalg.solve(scaled, right / size, assume_a="pos") / size if len(size) else right
        return solved

    def errors(self, x: Array, blocks: Sequence[int]) -> Array:
        """Mean squared error of each joint over some blocks [(N m)^2], (joints,); NaN where it rests there."""
        found = np.full(len(self.problem.rows), np.nan)
        for row, (columns, numbers) in zip(self.problem.rows, self._places, strict=True):
            gram, rhs, energy, samples = (part[blocks].sum(0) for part in row.sums)
            if samples:
                own = x[numbers]
                squares = energy - 2.0 * own @ rhs[columns] + own @ gram[np.ix_(columns, columns)] @ own
                found[row.joint] = max(float(squares), 0.0) / samples
        return found

    @cached_property
    def held_out(self) -> Array:
        """Mean squared error of each joint in each fold of the inner blocks, which was not fitted, (joints, folds)."""
        inner = self.problem.inner
        parts = [inner[f::FOLDS] for f in range(min(FOLDS, len(inner)))]
        matrix, right = self.sums(inner)
        found = []
        for part in parts:
            m, r = self.sums(part)
            found.append(self.errors(self._solved(matrix - m, right - r), part))
        return np.stack(found, 1)

    def known_without(self, joint: int) -> SharedNumbers | None:
        """What the inner blocks of all other joints say of the numbers that joints share; None where they share none.

        Args:
            joint: number of the joint that is left out.
        """
        shared = [*self.numbers_of_links, *(n for _, at in self.numbers_held for n in at)]
        if not shared:
            return None
        matrix, right = self.sums(self.problem.inner, without=joint)
        matrix, size = _scaled(matrix + np.diag(self.prior))
        right = right / size
        # What the others' own effects may take away is eliminated.
        rest = [n for n in range(self.size) if n not in set(shared)]
        between = matrix[np.ix_(shared, rest)]
        across = linalg.solve(matrix[np.ix_(rest, rest)], np.column_stack([between.T, right[rest]]), assume_a="pos")
        known = matrix[np.ix_(shared, shared)] - between @ across[:, :-1]
        middle = linalg.solve(known, right[shared] - between @ across[:, -1], assume_a="pos")
        unit = size[shared]
        columns = self._places[joint][0][: len(shared)]
        return SharedNumbers(columns, middle / unit, FREE_SAMPLES * known * np.outer(unit, unit) / self.weights[joint])

    def are_told(self, blocks: Sequence[int]) -> list[bool]:
        """Whether each number is told apart from all others: a mass that only ever turns about its own axis is not."""
        matrix, _ = self.sums(blocks)
        size = np.sqrt(np.maximum(np.diag(matrix), 1e-30))
        inverse = np.linalg.inv(matrix / np.outer(size, size) + HELD * np.eye(len(size)))
        return [bool(told) for told in np.diag(inverse) < _TOLD]

    def deviations(self, x: Array, blocks: Sequence[int]) -> Array:
        """Half widths of 95 % intervals, which allow for errors that hang together within a block."""
        matrix, _ = self.sums(blocks)
        inverse = np.linalg.pinv(matrix + np.diag(self.prior), hermitian=True)
        scores = []
        for b in blocks:
            score = np.zeros(self.size)
            for row, weight, (columns, numbers) in zip(self.problem.rows, self.weights, self._places, strict=True):
                gram, rhs, _, _ = row.sums
                score[numbers] += weight * (rhs[b][columns] - gram[b][np.ix_(columns, columns)] @ x[numbers])
            scores.append(score)
        spread = np.array(scores)
        covariance = inverse @ (spread.T @ spread) @ inverse * len(blocks) / max(len(blocks) - 1, 1)
        width = stats.t.ppf(0.975, max(len(blocks) - 1, _FEWEST_DEGREES))
        half: Array = width * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return half

    def numbers_of(self, joint: int) -> list[tuple[Term, list[int]]]:
        """Each term of a joint and where its numbers stand in x."""
        return self._numbers[joint]

    @property
    def numbers_of_links(self) -> list[int]:
        """Where the changes of the inertial numbers stand in x."""
        return list(range(self._links))

    @property
    def numbers_held(self) -> list[tuple[Term, list[int]]]:
        """The same of the arm's effects."""
        return self._numbers[None]


def _scaled(matrix: Array) -> tuple[Array, Array]:
    """Normal equations in units of each number in which their diagonal is 1, each number held a little; and the units.

    A number that nothing tells has a large unit.
    """
    diagonal = np.diag(matrix)
    size = np.sqrt(np.maximum(diagonal, 1e-12 * float(diagonal.max(initial=1e-12))))
    return matrix / np.outer(size, size) + HELD * np.eye(len(size)), size
