"""Explanations of a tip on a surface, held against times and against places that a fit has not seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.place_tables import Numbers, Tables, learned_by
from mmt_drake.diagnosis.fit.problem import BLOCK_S, Fitted, Problem, share
from mmt_drake.diagnosis.fit.surface_fit import LearnedSurface, SurfaceFit
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.numeric.arrays import Array

FOLDS = 4
"""Times, and places, are left out in so many turns."""
_PLACES = 8.0
"""Places are squares, so many along the mean side of what the probe was over."""
_STRETCHES = 32.0
"""Times are stretches, so many in all: a longer one would be a part of the surface where the probe never was."""
_STEPS = 5  # from the fit to all, to one without a fold


@dataclass(frozen=True)
class Explained:
    """A set of effects, fitted.

    Attributes:
        hypothesis: with the effects.
        found: fitted to all that is not held out.
        by_time, by_place: (n,) residuals over the noise of what is not held out, each as if the fit had not seen the
            stretch of time, or the place, that it belongs to.
    """

    hypothesis: Hypothesis
    found: LearnedSurface
    by_time: Array
    by_place: Array

    @property
    def unseen_cost(self) -> float:
        """Sum of squares of what was not seen."""
        return float(self.by_time @ self.by_time + self.by_place @ self.by_place)


@dataclass(frozen=True)
class Scan:
    """Recordings of a tip on one surface, and how they are cut.

    Attributes:
        surface: how a surface is fitted to them.
        stretch: (n,) of each residual the number of its stretch of time.
        block: (n,) that of its block of time, within which errors may depend on each other.
        cell: (n,) that of its place.
    """

    surface: SurfaceFit
    stretch: Numbers
    block: Numbers
    cell: Numbers

    @classmethod
    def of(cls, surface: SurfaceFit) -> Scan:
        """The recordings of a fit, cut."""
        time, at = surface.time, surface.place
        stretch = np.floor(time * (_STRETCHES / max(float(time.max()), 1e-9)))
        size = np.ptp(at, axis=0)
        side = max(float(np.sqrt(size[0] * size[1])), 0.1 * float(size.max()), 1e-9) / _PLACES
        square = np.floor((at - at.min(axis=0)) / side).astype(int)
        return cls(
            surface, _numbered(stretch), _numbered(np.floor(time / BLOCK_S)), _numbered(square[:, 0], square[:, 1])
        )

    @property
    def noise(self) -> float:
        """Mean square of noise alone: independent samples per residual."""
        surface = self.surface
        counts = [(share(t.smoothed) * min(1.0, _every(t, rows)), len(rows)) for t, rows in surface.track_rows]
        return sum(part * count for part, count in counts) / sum(count for _, count in counts)

    def held_to(self, problem: Problem, explained: Sequence[Explained]) -> tuple[Scan, list[Explained]]:
        """The same with other noise floors, one for all axes of a recording as before."""
        surface = replace(self.surface, problem=problem)
        pairs = zip(self.surface.track_rows, surface.track_rows, strict=True)
        ratio = np.concatenate([np.full(len(rows), before.floor / after.floor) for (before, rows), (after, _) in pairs])
        seen = ratio[~surface.heldout]
        scaled = [
            replace(
                one,
                found=one.found._replace(residual=one.found.residual * ratio),
                by_time=one.by_time * seen,
                by_place=one.by_place * seen,
            )
            for one in explained
        ]
        return replace(self, surface=surface), scaled

    def explained(self, hypothesis: Hypothesis, x: Array, tables: Tables) -> Explained:
        """A set of effects, fitted and held against what it has not seen.

        Args:
            hypothesis: with the effects.
            x, tables: where the fit begins, see `SurfaceFit.fit`.
        """
        found = self.surface.fit(hypothesis, x, tables, ~self.surface.heldout)
        turns = np.random.default_rng(0).permutation(int(self.cell.max()) + 1) % FOLDS
        by_time, by_place = (
            self._without(hypothesis, found, turn) for turn in (self.stretch % FOLDS, turns[self.cell])
        )
        return Explained(hypothesis, found, by_time, by_place)

    def _without(self, hypothesis: Hypothesis, found: LearnedSurface, turn: Numbers) -> Array:
        """Residuals of what is not held out, from fits that each leave out one turn."""
        surface, result = self.surface, found.residual.copy()
        seen = ~surface.heldout
        for number in np.unique(turn[seen]):
            own = turn == number
            if (seen & ~own).any():
                other = surface.fit(hypothesis, found.x, found.tables, seen & ~own, steps=_STEPS)
                result[own] = other.residual[own]
        return result[seen]

    def fitted(self, explained: Explained) -> Fitted:
        """The fit, on all samples: of its numbers the derivatives that are left once what is learned has followed."""
        hypothesis, found = explained.hypothesis, explained.found
        full = replace(self.surface, most_rows=math.inf)
        told = full.with_tables(hypothesis, found.x, found.tables)
        own = full.problem.at(told, found.x)
        learned = learned_by(hypothesis)
        if not learned:
            return own
        seen = ~full.heldout
        bent = full.derivatives(full.model_of(hypothesis, found), learned)[seen]
        weight = np.sqrt([share(t.smoothed) for t, rows in full.track_rows for _ in rows])[seen]
        bent = sparse.csr_matrix(sparse.diags(weight) @ bent)
        count = bent.shape[0]
        known = (bent.T @ bent + full.smoothness(bent)).toarray()
        size = np.sqrt(np.maximum(np.diag(known), 1e-300))  # heights and stiffness are of different units
        scaled = known / np.outer(size, size) + 1e-9 * np.eye(len(known))
        inverse = np.linalg.inv(scaled) / np.outer(size, size)
        jacobian, residual = own.minimum.jacobian.copy(), own.minimum.residual
        jacobian[:count] -= bent @ (inverse @ (bent.T @ jacobian[:count]))
        known_to = _deviations(bent, inverse, residual[:count], Scan.of(full).block[seen])
        deviations = dict(zip(learned, np.split(known_to, len(learned)), strict=True))
        told = full.with_tables(hypothesis, found.x, found.tables, deviations)
        return Fitted(told, replace(own.minimum, jacobian=jacobian))


def _deviations(bent: sparse.csr_matrix, inverse: Array, residual: Array, block: Numbers) -> Array:
    """(m,) of what is learned: what their scatter over blocks is, or what residuals without a memory would make it.

    The greater of the two: the first sees that residuals depend on each other, the second that some say nothing.
    """
    own = np.arange(len(block))
    sums = sparse.csr_matrix((residual, (block, own)), shape=(int(block.max()) + 1, len(block))) @ bent
    scattered = np.sum((sums @ inverse) ** 2, axis=0)
    white = max(1.0, float(np.mean(residual**2))) * np.diag(inverse)
    return np.asarray(np.sqrt(np.maximum(scattered, white)))


def _every(track: Track, rows: Numbers) -> float:
    """Samples per row."""
    return float(np.count_nonzero(track.weight > 0.0)) / max(len(rows), 1)


def _numbered(*keys: Array | Numbers) -> Numbers:
    """(n,) numbers from 0 on, one for each combination of keys that occurs, in their order."""
    return np.unique(np.column_stack(keys), axis=0, return_inverse=True)[1].ravel().astype(np.intp)
