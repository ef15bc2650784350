"""The search for what is missing where a tip presses on a surface: its shape, and what rubs on it."""

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.fit.box_tracks import NORMAL_COLUMN
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.place_tables import SHAPE, STIFFNESS, Tables
from mmt_drake.diagnosis.fit.places import Explained, Scan
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.surface_fit import TOOL, SurfaceFit
from mmt_drake.diagnosis.search.watch import NOTHING, Watch
from mmt_drake.effects.effect import Effect
from mmt_drake.errors import attempt
from mmt_drake.numeric.arrays import Array

SMOOTHNESS, MISSING, ONE_MORE = "how smooth the surface is", "what is missing", "one more missing effect"
OFFSET = "whether the tip is elsewhere"
"""What is done, stage by stage."""
RUBBING = ("probe_slip", "coulomb_friction", "viscous_friction")
"""What may act along a surface, one of these."""
STICKING = RUBBING[:2]
"""Those in which it may stick."""
TURNED = "frame_misalignment"
STIFF = (0.03, 0.3, 3.0)
"""How smooth a surface may be held, see `SurfaceFit`: the one that predicts unseen places and times best."""
WITHIN = (STIFFNESS, "viscoelastic_relaxation", "hunt_crossley_damping", "nonlinear_stiffness")
"""What may act within the contact, one of these beside the best of all that."""
_TURNS = math.radians(1.0)
"""RMS of a hand's turning about its mean from which on an offset of its tool may be told."""
_AT_FIRST, _OFF = 0.2, 2e-3
_MORE = 1.5
"""RMS of the residual over the noise above which a further effect is looked for."""


@dataclass(frozen=True)
class SurfaceSearch:
    """What may be missing.

    Attributes:
        problem: the recordings; the three axes of each held to one noise, for a slope takes from one what it gives
            another.
        base: the fit without effects.
        library: effects that may be missing.
        executor: runs the fits.
        watch: sees to the time.
    """

    problem: Problem
    base: Fitted
    library: Sequence[Effect]
    executor: Executor
    watch: Watch

    def run(self) -> tuple[Scan, list[Explained]]:
        """How the recordings are cut, and every set of effects that was tried, that of none first."""
        known = {e.name: e for e in self.library if self.base.hypothesis.admits(e)}
        if not self._turns():
            known.pop(TOOL, None)
        scan = self._as_smooth_as_predicts(known) if SHAPE in known else Scan.of(SurfaceFit(self.problem))
        rubbing = [*((name,) for name in RUBBING if name in known), ()]
        # Those that explain most come first: there may be no time for all.
        sets: list[tuple[str, ...]] = [()]
        sets += [(SHAPE, *rubs) for rubs in rubbing] if SHAPE in known else []
        sets += rubbing[:-1]
        sets += [(TURNED, *rubs) for rubs in dict.fromkeys((rubbing[0], ()))] if TURNED in known else []
        begun = [self._begun(names, known) for names in sets]
        self.watch.begin(MISSING)
        found = self._tried(scan, [(*start, self._level(scan.surface)) for start in begun])
        if TOOL in known:
            # From where they ended: far off the surface that the tip seems to have touched is another one.
            self.watch.begin(OFFSET)
            aligned = [one for one in found if TURNED not in one.hypothesis.key]
            found += self._tried(scan, [self._beside(scan, one, known[TOOL]) for one in aligned])
        best = min(found, key=lambda e: e.unseen_cost, default=None)
        if best is not None and _left(scan, best) > _MORE:
            self.watch.begin(ONE_MORE)
            more = [self._beside(scan, best, known[name]) for name in WITHIN if name in known]
            if STIFFNESS in known and SHAPE in best.hypothesis.key:
                # What seems to be high may be stiff, and nothing else.
                elsewhere = best.hypothesis.key & {TOOL}
                level = [one for one in found if one.hypothesis.key - set(RUBBING) == elsewhere]
                more += [self._beside(scan, one, known[STIFFNESS]) for one in level]
            found += self._tried(scan, more)
        return scan, found

    def _tried(self, scan: Scan, starts: Sequence[tuple[Hypothesis, Array, Tables]]) -> list[Explained]:
        """Sets of effects, as long as there is time, without those that cannot be simulated."""
        found: list[Explained] = []
        names = [hypothesis.label or NOTHING for hypothesis, *_ in starts]
        results = self.executor.map(lambda start: attempt(scan.explained, *start), starts)
        for number, explained in enumerate(results):
            self.watch.did(names[number], number + 1, len(starts))
            if explained is not None:
                found.append(explained)
                self.watch.saw(names[number], _left(scan, explained))
                if explained.hypothesis.effects:
                    self.watch.answer()
            if self.watch.is_late():
                self.watch.miss(names[number + 1 :])
                break
        return found

    def _beside(self, scan: Scan, best: Explained, effect: Effect) -> tuple[Hypothesis, Array, Tables]:
        """One more effect of the contact beside the best set, begun where that ended and slight."""
        hypothesis, found = best.hypothesis, best.found
        values = hypothesis.effect_values(found.x)
        k = max(scan.surface.model_of(hypothesis, found).k, 1e-9)
        depth = self._load() / k
        first = {"k_maxwell": 0.3 * k, "tau": 0.3, "lambda": 0.1 / depth, "k3": 0.1 * k / depth**2}
        first |= dict.fromkeys("xyz", _OFF)
        values[effect.name] = {p.symbol: first[p.symbol] for p in effect.parameters if p.symbol in first}
        added = hypothesis.adding(effect)
        x = added.vector(hypothesis.structure_values(found.x), values, hypothesis.skew_of(found.x))
        tables = found.tables
        if effect.name == STIFFNESS:
            tables = {**tables, STIFFNESS: np.full(len(tables[STIFFNESS]), k)}
        return added, x, tables

    def _turns(self) -> bool:
        """Whether the hand was recorded and turns, in every recording."""
        hands = [tracks[0].smoothed.hand for tracks in self.problem.by_recording()]
        return all(hand is not None and hand.spread > _TURNS for hand in hands)

    def _load(self) -> float:
        """About how strongly the tip presses [N]."""
        along = [t for t in self.problem.tracks if t.column == NORMAL_COLUMN]
        return float(np.mean([np.mean(t.measured[t.weight > 0.0]) for t in along]))

    def _as_smooth_as_predicts(self, known: dict[str, Effect]) -> Scan:
        """The recordings, with the surface held as smooth as predicts unseen places and times best."""
        names = [SHAPE, *(name for name in RUBBING[:1] if name in known)]
        scans = [Scan.of(SurfaceFit(self.problem, stiff)) for stiff in STIFF]

        def cost(scan: Scan) -> float:
            hypothesis, x = self._begun(names, known)
            found = scan.explained(hypothesis, x, self._level(scan.surface))
            costs = [found.unseen_cost]
            if TOOL in known:
                costs.append(scan.explained(*self._beside(scan, found, known[TOOL])).unseen_cost)
            return min(costs)

        self.watch.begin(SMOOTHNESS)
        costs = []
        for scan, one in zip(scans, self.executor.map(cost, scans), strict=True):
            costs.append(one)
            self.watch.did(f"held smooth by {scan.surface.stiff:g}", len(costs), len(scans))
        return scans[int(np.argmin(costs))]

    def _begun(self, names: Sequence[str], known: dict[str, Effect]) -> tuple[Hypothesis, Array]:
        """A set of effects beside the base, and where its numbers begin."""
        hypothesis = self.base.hypothesis
        hypothesis = replace(hypothesis, widened=hypothesis.widened | {s for s in ("k", "b") if s in hypothesis.free})
        values: dict[str, dict[str, float]] = {}
        loads = [t.measured[t.weight > 0.0] for t in self.problem.tracks]
        force, speed = rms(np.concatenate(loads)), max(rms(t.smoothed.input_rate) for t in self.problem.tracks)
        first = {"mu": _AT_FIRST, "Fc": _AT_FIRST * force, "b": _AT_FIRST * force / max(speed, 1e-9)}
        if set(names) & set(STICKING):  # how stiffly the tip is held shows only where it sticks
            hypothesis = replace(hypothesis, doubted=hypothesis.nominal.GIVEN)
        for name in names:
            hypothesis = hypothesis.adding(known[name])
            values[name] = {p.symbol: first.get(p.symbol, 0.0) for p in known[name].parameters}
        structure = self.base.structure_values
        if SHAPE in names:  # a level surface may have driven the stiffness anywhere
            nominal = self.base.hypothesis.nominal
            structure = {s: nominal.parameter(s) for s in structure}
        return hypothesis, hypothesis.vector(structure, values)

    def _level(self, surface: SurfaceFit) -> Tables:
        """A level surface of even stiffness: on average the tip presses into it by what its load asks for."""
        x, y = surface.grid
        k = max(self.base.hypothesis.nominal.value("k2"), 1e-9)
        tip = float(np.mean([np.mean(s.input[:, NORMAL_COLUMN]) for s in surface.recordings]))
        begun = {SHAPE: tip + self._load() / k, STIFFNESS: k}
        return {name: np.full(len(x) * len(y), value) for name, value in begun.items()}


def _left(scan: Scan, explained: Explained) -> float:
    """RMS of what is left of unseen times and places over the noise."""
    return math.sqrt(explained.unseen_cost / (scan.noise * 2.0 * len(explained.by_time)))
