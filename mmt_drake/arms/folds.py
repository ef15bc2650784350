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
        x: numbers fitted to all inner blocks, those of the links first where they are free.
    """

    held_out: Array
    x: Array

    @property
    def cost(self) -> float:
        """Mean squared error of what was held out."""
        return float(self.held_out.mean())


class Folds:
    """One joint under one belief about the links, ready to fit sets of terms.

    The inertial numbers are eliminated: with those of the terms x, they are at - across x. What that makes of a fold
    that is held out is a quadratic form in x, which is summed up once.

    Args:
        sums: of each block of the joint, see `JointRows.sums`.
        inner: blocks that choose.
        prior: (10 links,) how strongly each inertial number is held where it is; None: they are as believed.
    """

    def __init__(self, sums: tuple[Array, Array, Array, Array], inner: Sequence[int], prior: Array | None) -> None:
        gram, rhs, _, samples = sums
        used = [b for b in inner if samples[b] > 0]
        parts = [used[f::FOLDS] for f in range(min(FOLDS, len(used)))]
        held = [tuple(a[part].sum(axis=0) for a in sums) for part in parts]
        total = gram[used].sum(axis=0), rhs[used].sum(axis=0)
        trained = [(total[0] - g, total[1] - c) for g, c, _, _ in held]
        self._links = 0 if prior is None else len(prior)
        reduced = [self._without_links(g, c, prior) for g, c in [*trained, total]]
        self._gram, self._rhs, self._across, self._at = (np.stack(one) for one in zip(*reduced, strict=True))
        forms = [
            self._form(g, c, e, across, at)
            for (g, c, e, _), across, at in zip(held, self._across[:-1], self._at[:-1], strict=True)
        ]
        self._square, self._line, self._rest = (np.stack(one) for one in zip(*forms, strict=True))
        self._samples = np.array([n for _, _, _, n in held])
        self._known: dict[tuple[int, ...], FoldFit] = {}

    def _without_links(self, gram: Array, rhs: Array, prior: Array | None) -> tuple[Array, Array, Array, Array]:
        """The sums once the inertial numbers are eliminated, and what gives these back."""
        if prior is None:
            return gram, rhs, np.empty((0, len(rhs))), np.empty(0)
        free = slice(self._links)
        factor = linalg.cho_factor(gram[free, free] + np.diag(prior))
        across, at = linalg.cho_solve(factor, gram[free]), linalg.cho_solve(factor, rhs[free])
        return gram - gram[:, free] @ across, rhs - gram[:, free] @ at, across, at

    def _form(self, gram: Array, rhs: Array, energy: Array, across: Array, at: Array) -> tuple[Array, Array, Array]:
        """Squared error of a fold as a form in the terms' numbers: quadratic, linear and constant part."""
        free = slice(self._links)
        own, between = gram[free, free], gram[free] - gram[free, free] @ across
        square = gram - across.T @ gram[free] - between.T @ across
        line = 2.0 * (across.T @ rhs[free] - rhs + between.T @ at)
        return square, line, energy - 2.0 * at @ rhs[free] + at @ own @ at

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
        links = self._at[-1] - self._across[-1][:, own] @ x[-1]
        return FoldFit(np.maximum(left, 0.0) / self._samples, np.concatenate([links, x[-1]]))
