"""Fits of one joint with parts of its blocks held out in turn, at next to no cost for each set of terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from mmt_drake.numeric.arrays import Array

FOLDS = 16
"""Parts of the inner blocks that are held out in turn when sets of effects are compared."""
HELD = 1e-8
"""Numbers that no torque depends on stay 0: each is held so strongly, in parts of what the data say of it."""


@dataclass(frozen=True)
class FoldFit:
    """Fits of one joint on the inner blocks, each fold held out in turn.

    Attributes:
        held_out: (folds,) mean squared error of each fold when it was not fitted [(N m)^2].
        x: numbers fitted to all inner blocks, those that joints share first.
    """

    held_out: Array
    x: Array

    @property
    def cost(self) -> float:
        """Mean squared error of what was held out."""
        return float(self.held_out.mean())


@dataclass(frozen=True)
class SharedNumbers:
    """Numbers that a joint shares with others, and what is known of them without it.

    Attributes:
        columns: theirs among those of the joint.
        middle: (k,) where they are expected.
        held: (k, k) how strongly they are held there, as a sum of squares of the joint's error [(N m)^2 / unit^2].
    """

    columns: Sequence[int]
    middle: Array
    held: Array

    def from_middle(self, sums: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        """Sums of each block with what these numbers explain, where they are expected, taken from the target."""
        gram, rhs, energy, samples = sums
        at, x = list(self.columns), self.middle
        own = gram[:, at][:, :, at]
        return gram, rhs - gram[:, :, at] @ x, energy - 2.0 * rhs[:, at] @ x + x @ own @ x, samples


class Folds:
    """One joint under one belief about the links, ready to fit sets of terms.

    Numbers that joints share are eliminated: with those of the terms x, they are at - across x. What that makes of a
    fold that is held out is a quadratic form in x, which is summed up once.

    Args:
        sums: of each block of the joint, see `JointRows.sums`.
        inner: blocks that choose.
        shared: numbers that joints share; None: the links are as believed, and nothing else is shared.
    """

    def __init__(
        self, sums: tuple[Array, Array, Array, Array], inner: Sequence[int], shared: SharedNumbers | None
    ) -> None:
        if shared is not None:
            sums = shared.from_middle(sums)
        gram, rhs, _, samples = sums
        used = [b for b in inner if samples[b] > 0]
        parts = [used[f::FOLDS] for f in range(min(FOLDS, len(used)))]
        held = [tuple(a[part].sum(axis=0) for a in sums) for part in parts]
        total = gram[used].sum(axis=0), rhs[used].sum(axis=0)
        trained = [(total[0] - g, total[1] - c) for g, c, _, _ in held]
        self._free = [] if shared is None else list(shared.columns)
        self._middle = np.empty(0) if shared is None else shared.middle
        reduced = [self._without_shared(g, c, shared) for g, c in [*trained, total]]
        self._gram, self._rhs, self._across, self._at = (np.stack(one) for one in zip(*reduced, strict=True))
        forms = [
            self._form(g, c, e, across, at)
            for (g, c, e, _), across, at in zip(held, self._across[:-1], self._at[:-1], strict=True)
        ]
        self._square, self._line, self._rest = (np.stack(one) for one in zip(*forms, strict=True))
        self._samples = np.array([n for _, _, _, n in held])
        self._whole = gram[used].sum(axis=0) / max(float(samples[used].sum()), 1.0)
        self._known: dict[tuple[int, ...], FoldFit] = {}

    def _without_shared(
        self, gram: Array, rhs: Array, shared: SharedNumbers | None
    ) -> tuple[Array, Array, Array, Array]:
        """The sums once the shared numbers are eliminated, and what gives these back."""
        if shared is None:
            return gram, rhs, np.empty((0, len(rhs))), np.empty(0)
        free = self._free
        own = gram[np.ix_(free, free)] + shared.held
        factor = linalg.cho_factor(own + HELD * np.diag(np.maximum(np.diag(own), 1e-12 * np.diag(own).max())))
        across, at = linalg.cho_solve(factor, gram[free]), linalg.cho_solve(factor, rhs[free])
        return gram - gram[:, free] @ across, rhs - gram[:, free] @ at, across, at

    def _form(self, gram: Array, rhs: Array, energy: Array, across: Array, at: Array) -> tuple[Array, Array, Array]:
        """Squared error of a fold as a form in the terms' numbers: quadratic, linear and constant part."""
        free = self._free
        own = gram[np.ix_(free, free)]
        between = gram[free] - own @ across
        square = gram - across.T @ gram[free] - between.T @ across
        line = 2.0 * (across.T @ rhs[free] - rhs + between.T @ at)
        return square, line, energy - 2.0 * at @ rhs[free] + at @ own @ at

    def mean_square(self, columns: Sequence[int], x: Array) -> float:
        """Of the torque that some columns make with numbers x, over the blocks that choose [(N m)^2]."""
        return float(x @ self._whole[np.ix_(columns, columns)] @ x)

    def fit(self, columns: Sequence[int]) -> FoldFit:
        """The fit of a set of columns."""
        key = tuple(columns)
        if key not in self._known:
            self._known[key] = self._fitted(list(columns))
        return self._known[key]

    def _fitted(self, own: list[int]) -> FoldFit:
        matrix = self._gram[:, own][:, :, own]
        diagonal = np.einsum("fkk->fk", matrix)
        size = np.sqrt(np.maximum(diagonal, 1e-12 * np.maximum(diagonal.max(axis=1, initial=1e-12), 1e-12)[:, None]))
        scaled = matrix / (size[:, :, None] * size[:, None, :]) + HELD * np.eye(len(own))
        x = np.linalg.solve(scaled, (self._rhs[:, own] / size)[:, :, None])[:, :, 0] / size
        held = x[:-1]
        square = self._square[:, own][:, :, own]
        left = (
            self._rest + np.einsum("fk,fk->f", self._line[:, own], held) + np.einsum("fj,fjk,fk->f", held, square, held)
        )
        shared = self._middle + self._at[-1] - self._across[-1][:, own] @ x[-1]
        return FoldFit(np.maximum(left, 0.0) / self._samples, np.concatenate([shared, x[-1]]))
