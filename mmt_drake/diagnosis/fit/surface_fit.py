"""The fit of a surface that nobody recorded: all its heights together with the numbers of the contact on it.

Gauss-Newton with the damping of Levenberg and Marquardt; what is learned over places has sparse derivatives
(`place_tables`). How smooth a table is taken to be stands beside the residual as the integral of its squared second
derivatives (a thin plate: Duchon 1977).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.place_tables import LEARNED, Numbers, Tables, learned_by, table_derivatives
from mmt_drake.diagnosis.fit.problem import Problem
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.effects import tool_offset
from mmt_drake.errors import attempt
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.motion.hand import Place
from mmt_drake.numeric.arrays import Array, Flags

TOOL = tool_offset.EFFECT.name
_NODES = 300
"""Heights of a map, about so many: an organ under a probe has no more to it than forces show."""
_MOST_ROWS = 6000.0
_DIFFERENCE, _LONGEST = 1e-3, 0.5  # of the scale of a number: its step in a difference, and at most in a step
_CONVERGED = 1e-5


class LearnedSurface(NamedTuple):
    """What a surface fit has found.

    Attributes:
        x: (k,) numbers of the hypothesis.
        tables: of what was learned; what was not is as begun.
        residual: (n,) of all rows, over the noise.
        cost: of the rows that were fitted, and what smoothness costs.
    """

    x: Array
    tables: Tables
    residual: Array
    cost: float


@dataclass(frozen=True)
class SurfaceFit:
    """Recordings of a tip on one surface, made ready for fits of that.

    Attributes:
        problem: with a floor for each axis.
        stiff: how strongly a surface is held smooth, over what the data say of it.
        most_rows: samples of a recording that a surface is fitted to, evenly spread.
    """

    problem: Problem
    stiff: float = 1.0
    most_rows: float = _MOST_ROWS

    @cached_property
    def recordings(self) -> tuple[Smoothed, ...]:
        """One for each recording."""
        return tuple(tracks[0].smoothed for tracks in self.problem.by_recording())

    @cached_property
    def rows(self) -> tuple[Numbers, ...]:
        """Of each recording the samples that are compared."""
        found = []
        for tracks in self.problem.by_recording():
            used = np.flatnonzero(np.all([track.weight > 0.0 for track in tracks], axis=0))
            found.append(used[:: max(1, math.ceil(len(used) / self.most_rows))])
        return tuple(found)

    @property
    def track_rows(self) -> list[tuple[Track, Numbers]]:
        """Every track with its samples that are compared, in the order of residuals."""
        parts = zip(self.problem.by_recording(), self.rows, strict=True)
        return [(track, rows) for tracks, rows in parts for track in tracks]

    def _stacked(self, values: list[Array] | list[Flags]) -> Array:
        """(n,) one for each residual, of values (n_i,) for each row of each recording."""
        return np.concatenate([v for own in values for v in (own, own, own)])

    @cached_property
    def heldout(self) -> Flags:
        """(n,) residuals of samples that no fit looks at."""
        parts = self.problem.by_recording()
        return self._stacked([t[0].heldout[rows] for t, rows in zip(parts, self.rows, strict=True)]).astype(bool)

    @cached_property
    def place(self) -> Array:
        """(n, 2) x and y of the probe at each residual [m]."""
        at = [s.input[rows] for s, rows in zip(self.recordings, self.rows, strict=True)]
        return np.column_stack([self._stacked([p[:, i] for p in at]) for i in (0, 1)])

    @cached_property
    def time(self) -> Array:
        """(n,) of each residual [s], recordings one after the other."""
        begin, found = 0.0, []
        for s, rows in zip(self.recordings, self.rows, strict=True):
            found.append(s.time[rows] - s.time[0] + begin)
            begin += float(s.time[-1] - s.time[0])
        return self._stacked(found)

    @cached_property
    def grid(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Columns and rows of the map: it covers where the probe was, as recorded."""
        low, high = self.place.min(axis=0), self.place.max(axis=0)
        size = np.maximum(high - low, 1e-2 * float((high - low).max()) + 1e-9)
        apart = float(np.sqrt(size[0] * size[1] / _NODES))
        counts = np.clip(np.ceil(size / apart).astype(int) + 1, 2, _NODES)
        x, y = (np.linspace(a, a + s, n) for a, s, n in zip(low, size, counts, strict=True))
        return tuple(map(float, x)), tuple(map(float, y))

    @cached_property
    def _mean_turn(self) -> Array:
        """(3, 3) rotation of the hand, the mean over the rows."""
        pairs = zip(self.recordings, self.rows, strict=True)
        turns = [s.hand.turn[rows] for s, rows in pairs if s.hand is not None]
        return np.asarray(np.concatenate(turns).mean(axis=0))

    def _moved_grid(self, tool: Place) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The same as far off as the tip is on average: a map that stayed would end where the tip is."""
        if not any(tool):
            return self.grid
        off = self._mean_turn @ tool
        x, y = (tuple(float(v) + float(o) for v in at) for at, o in zip(self.grid, off[:2], strict=True))
        return x, y

    @cached_property
    def _bending(self) -> sparse.csr_matrix:
        """(r, m): root of the integral of the squared second derivatives [1/m each]."""
        x, y = self.grid
        dx, dy = x[1] - x[0], y[1] - y[0]
        (ix, ex, bx), (iy, ey, by) = (_differences(len(at)) for at in (x, y))
        own = np.sqrt(dx * dy)
        parts = (sparse.kron(iy, bx) / dx**2, sparse.kron(by, ix) / dy**2, sparse.kron(ey, ex) * (2.0**0.5 / (dx * dy)))
        return (own * sparse.vstack(parts)).tocsr()

    def with_tables(
        self, hypothesis: Hypothesis, numbers: Array, tables: Tables, deviations: Tables | None = None
    ) -> Hypothesis:
        """The hypothesis with what it has learned over places.

        Args:
            hypothesis: of which.
            numbers: (k,) of it.
            tables: of what its effects learn, and perhaps of more.
            deviations: of these; 0 unless said.
        """
        learned = learned_by(hypothesis)
        if not learned:
            return hypothesis
        tool = hypothesis.effect_values(numbers).get(TOOL, {})
        x, y = self._moved_grid((tool.get("x", 0.0), tool.get("y", 0.0), tool.get("z", 0.0)))
        held: dict[str, Mapping[str, Any]] = {}
        for name in learned:
            known = np.zeros(len(tables[name])) if deviations is None else deviations[name]
            own = {LEARNED[name]: tables[name].tolist(), "deviation": known.tolist()}
            held[name] = {"x": list(x), "y": list(y), **own}
        return replace(hypothesis, held={**hypothesis.held, **held})

    def model(self, hypothesis: Hypothesis, x: Array, tables: Tables) -> SurfaceContact:
        """The model with these numbers and tables."""
        model = self.with_tables(hypothesis, x, tables).model(x)
        assert isinstance(model, SurfaceContact)  # nothing else has a surface
        return model

    def model_of(self, hypothesis: Hypothesis, found: LearnedSurface) -> SurfaceContact:
        """The model that was found."""
        return self.model(hypothesis, found.x, found.tables)

    def residual(self, model: SurfaceContact, skew: float = 0.0) -> Array:
        """(n,) measured less simulated of all rows, over the noise; in the order of `heldout`."""
        return np.concatenate(
            [(t.measured - t.simulated(model, skew, 1.0))[rows] / t.floor for t, rows in self.track_rows]
        )

    def derivatives(self, model: SurfaceContact, learned: Sequence[str]) -> sparse.csr_matrix:
        """(n, m) of the residual after the values of tables, one after the other, that the model has."""
        found = []
        for tracks, rows in zip(self.problem.by_recording(), self.rows, strict=True):
            own = table_derivatives(tracks, rows, model)
            found += [sparse.hstack([after[name] for name in learned]) for after in own]
        return sparse.vstack(found).tocsr()

    def smoothness(self, bent: sparse.csr_matrix) -> sparse.csc_matrix:
        """(m, m) what tables cost that are bent, beside residuals with these derivatives after their values."""
        bending = self._bending.T @ self._bending
        whole, size = float(self._bending.multiply(self._bending).sum()), self._bending.shape[1]
        tables = [bent[:, first : first + size] for first in range(0, bent.shape[1], size)]
        costs = [self.stiff * float(own.multiply(own).sum()) / whole * bending for own in tables]
        return sparse.block_diag(costs, format="csc")

    def fit(
        self, hypothesis: Hypothesis, x: Array, tables: Tables, chosen: Flags, *, steps: int = 30
    ) -> LearnedSurface:
        """All numbers and tables, to some of the rows.

        Args:
            hypothesis: some of its effects may be learned.
            x: (k,) where its numbers begin.
            tables: where what is learned begins.
            chosen: (n,) residuals that are fitted.
            steps: at most.
        """
        learned = learned_by(hypothesis)
        # Behind the residual, as in `Problem.objective`: how far the skew is from none, over what may be expected.
        weight = np.zeros(len(x))
        weight[len(x) - 1 :] = 1.0 / self.problem.expected_skew if hypothesis.has_skew else 0.0
        values = np.concatenate([tables[name] for name in learned]) if learned else np.zeros(0)
        low, high, scale = hypothesis.limits(x)
        scale = np.where(scale > 0.0, scale, 1.0)
        size, smooth = len(values), None
        r = self.residual(self.model(hypothesis, x, tables), hypothesis.skew_of(x))
        damping, cost = 1e-4, np.inf
        for _ in range(steps):
            tables = _apart(values, learned, tables)
            columns = [self._moved(hypothesis, x, tables, r, i, scale[i], high[i])[chosen] for i in range(len(x))]
            numbers = np.vstack(
                [np.column_stack([*columns, np.zeros((int(chosen.sum()), 0))]), np.diag(weight * scale)]
            )
            left = np.concatenate([r[chosen], weight * x])
            if learned:
                bent = self.derivatives(self.model(hypothesis, x, tables), learned)[chosen]
                if smooth is None:
                    smooth = self.smoothness(bent)
                    cost = _cost(r[chosen], weight * x) + float(values @ (smooth @ values))
                mixed = sparse.csr_matrix(bent.T @ numbers[: -len(x) or None])
                normal = sparse.bmat(
                    [[bent.T @ bent + smooth, mixed], [mixed.T, sparse.csr_matrix(numbers.T @ numbers)]], format="csc"
                )
                slope = np.concatenate([bent.T @ r[chosen] + smooth @ values, numbers.T @ left])
            else:
                normal, slope = sparse.csc_matrix(numbers.T @ numbers), numbers.T @ left
                cost = min(cost, _cost(r[chosen], weight * x))
            held = ((x <= low) & (slope[size:] > 0.0)) | ((x >= high) & (slope[size:] < 0.0))
            free = np.flatnonzero(np.concatenate([np.ones(size, dtype=bool), ~held]))
            normal, slope = normal[free][:, free], slope[free]
            own = np.maximum(normal.diagonal(), 1e-12 * float(normal.diagonal().max()))
            better, step = None, np.zeros(size + len(x))
            while better is None and damping < 1e6:
                step[free] = -splu((normal + damping * sparse.diags(own)).tocsc()).solve(slope)
                moved = np.clip(x + scale * np.clip(step[size:], -_LONGEST, _LONGEST), low, high)
                raised = values + step[:size]
                trial = self._attempt(hypothesis, moved, _apart(raised, learned, tables))
                if trial is not None:
                    found = _cost(trial[chosen], weight * moved)
                    found += float(raised @ (smooth @ raised)) if smooth is not None else 0.0
                    if found < cost:
                        better = moved, raised, trial, found
                damping *= 10.0 if better is None else 1.0
            if better is None:
                break
            done = cost - better[3] < _CONVERGED * cost
            x, values, r, cost = better
            damping = max(damping / 10.0, 1e-8)
            if done:
                break
        return LearnedSurface(x, _apart(values, learned, tables), r, cost)

    def _attempt(self, hypothesis: Hypothesis, x: Array, tables: Tables) -> Array | None:
        r = attempt(lambda: self.residual(self.model(hypothesis, x, tables), hypothesis.skew_of(x)))
        return r if r is not None and np.isfinite(r @ r) else None

    def _moved(
        self, hypothesis: Hypothesis, x: Array, tables: Tables, r: Array, i: int, scale: float, high: float
    ) -> Array:
        """Derivative of the residual after a number over its scale."""
        step = _DIFFERENCE * scale if x[i] + _DIFFERENCE * scale <= high else -_DIFFERENCE * scale
        other = x.copy()
        other[i] += step
        moved = self._attempt(hypothesis, other, tables)
        return np.zeros_like(r) if moved is None else (moved - r) * (scale / step)


def _cost(residual: Array, prior: Array) -> float:
    return float(residual @ residual + prior @ prior)


def _apart(values: Array, learned: Sequence[str], tables: Tables) -> Tables:
    """Tables whose values one after the other are these, beside others as they were."""
    parts = np.split(values, len(learned)) if learned else []
    return {**tables, **dict(zip(learned, parts, strict=True))}


def _differences(n: int) -> tuple[sparse.csr_matrix, sparse.csr_matrix, sparse.csr_matrix]:
    """Identity, first and second differences of n values; without second ones where there are two."""
    eye = sparse.identity(n, format="csr")
    first = eye[1:] - eye[:-1]
    return eye, first, first[1:] - first[:-1]
