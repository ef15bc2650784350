"""A first model, from recordings alone: numbers sought from wide bounds and many starts, and which of them are told."""

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import cast

import numpy as np
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from mmt_drake.diagnosis.decide.budget import Ruler
from mmt_drake.diagnosis.decide.gate import NOTHING_LEFT, NoiseReference
from mmt_drake.diagnosis.fit.comparison import RULED_OUT, at_bounds
from mmt_drake.diagnosis.fit.errors import Interval
from mmt_drake.diagnosis.fit.floors import with_floors
from mmt_drake.diagnosis.fit.hypothesis import FARTHEST, SKEW, Hypothesis
from mmt_drake.diagnosis.fit.prepare import Prepared, prepare
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.rough import rough_model
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagnosis.fit.workers import given_or_own
from mmt_drake.diagnosis.search.base import CONVERGED, STEPS
from mmt_drake.diagnosis.search.in_plane import fit_near, said
from mmt_drake.diagnosis.search.watch import OnStage, Stage
from mmt_drake.diagnosis.tell.first import FirstModel, FirstNumber, Told
from mmt_drake.errors import BadInput, Interrupted, attempt
from mmt_drake.model.parameters import NORMAL, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Structure, Units
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import Model, compared
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.recording.recording import check_recordings

STARTS = 32
FUNNEL = ((12, 5), (5, 8))
"""Spread over all that numbers may be; so many of the best go on after so many steps from each."""
ROUNDS = 4
"""At most: one is looked about what the last one found while that ended at a bound, and noise is told by its model."""

WIDER = 1.25
"""Intervals are so much wider than the residual alone says. That does not show what noise of the position does to a fit
which takes the motion as given: unwidened, 91 of 100 numbers of 19 drawn recordings lay in theirs, of boxes 57 of 66.
"""
_UNKNOWN_SURFACE = (
    "The shape of the surface is not known, so these are guesses from quick presses, where its slope matters least. "
    "`mmt-drake diagnose` learns the shape, and the stiffness with it."
)
_SPREAD = 0.9  # of that, on a logarithmic scale
_NEAR = 0.98  # of a bound
_APART = 0.1
_PARAMETERS, _INTERVALS = "parameters", "intervals"


def fit(
    recordings: Sequence[Recording],
    structure: str | None = None,
    *,
    executor: Executor | None = None,
    on_stage: OnStage = lambda _: None,
) -> FirstModel:
    """A first model of recordings of one system, from them alone.

    All numbers of the structure are free, from a thirtieth of what the recording suggests (`rough_model`) to thirty
    times that, and from there on where the fit ends at a bound. Blocks are held out as in a diagnosis. A number that
    may as well be 0 is 0 in the model, if that is no worse.

    Args:
        recordings: of the same system.
        structure: `flexible_box`, `kelvin_voigt`, `driven_body`, `surface_contact`; by default what goes with the
            columns. Of a tip on a surface, which is unknown, numbers are guessed from quick presses and not fitted.
        executor: runs the fits; by default as many threads as there are processors.
        on_stage: called with what is being done.

    Raises:
        BadInput: recordings of different kinds, or a structure that does not belong to them; see `rough_model`.
        Interrupted: a KeyboardInterrupt, with the best numbers by then.
    """
    check_recordings("fit", recordings)
    for recording in recordings[1:]:
        if recording.kind != recordings[0].kind:
            raise BadInput(recording.source, found=f"a {recording.kind} recording", expected=recordings[0].kind)
    model = rough_model(recordings[0], structure)
    if isinstance(model, SurfaceContact):
        return _guessed(recordings, model)
    with given_or_own(executor) as workers, threadpool_limits(limits=1, user_api="blas"):
        return _Search(recordings, workers, on_stage).run(model)


def _guessed(recordings: Sequence[Recording], model: SurfaceContact) -> FirstModel:
    """A model that was not fitted, since what is pressed on is not known."""
    prepared = prepare(recordings, model)
    if prepared.problem is None:
        return FirstModel(model, prepared.findings, reason=prepared.refusal)
    numbers = (
        FirstNumber(symbol, value, unit, (value / FARTHEST, value * FARTHEST), "cannot be told")
        for symbol, value, unit in (("k", model.k, "N/m"), ("b", model.b, "N s/m"))
    )
    return FirstModel(model, prepared.findings, tuple(numbers), caution=_UNKNOWN_SURFACE)


@dataclass(frozen=True)
class _Search:
    """One search for a first model; `_best` holds the best fit so far."""

    recordings: Sequence[Recording]
    executor: Executor
    on_stage: OnStage
    _best: list[Fitted] = field(default_factory=list)

    def run(self, model: Model) -> FirstModel:
        """See `fit`."""
        try:
            return self._searched(model)
        except KeyboardInterrupt:
            raise self._interrupted() from None

    def _interrupted(self) -> Interrupted:
        if not self._best:
            return Interrupted("no number is known yet")
        (best,) = self._best
        numbers = best.structure_values
        said = ", ".join(f"{symbol} {value:.3g}" for symbol, value in numbers.items())
        name = best.hypothesis.nominal.NAME
        return Interrupted(f"so far {said}, not fitted to the end", {"structure": name, "unfinished_numbers": numbers})

    def _searched(self, model: Model) -> FirstModel:
        minima: list[Fitted] = []
        for _ in range(ROUNDS):
            self.on_stage(Stage("recordings", then=(_PARAMETERS, _INTERVALS)))
            prepared = prepare(self.recordings, model)
            if prepared.problem is None:
                return FirstModel(model, prepared.findings, reason=prepared.refusal)
            hypothesis = Hypothesis.of(compared(model, prepared.window_s, prepared.initial), prepared.skew)
            hypothesis = replace(hypothesis, unseen=prepared.problem.unseen)
            hypothesis = replace(hypothesis, widened=frozenset(hypothesis.free))
            settled = minima and not at_bounds(minima[0])
            starts = [(hypothesis, f.x) for f in minima] if settled else self._begun(prepared.problem, hypothesis)
            self.on_stage(Stage(_PARAMETERS, f"{len(starts)} minima", len(FUNNEL), 1 + len(FUNNEL), (_INTERVALS,)))
            minima = self._fitted(prepared.problem, starts)
            if settled and not at_bounds(minima[0]):
                break
            model = _about(minima[0])
        return self._told(prepared, minima)

    def _begun(self, problem: Problem, hypothesis: Hypothesis) -> list[tuple[Hypothesis, Array]]:
        """The best after a few steps from starts spread over all that the numbers may be, all clocks taken for right.

        With the skew free from the start, m, dampers and skew make up for each other: fits end with it at its bound.
        """
        nominal = hypothesis.structure_values(hypothesis.base())
        spread = 2.0 * qmc.LatinHypercube(len(nominal), seed=0).random(STARTS) - 1.0
        factors = FARTHEST ** (_SPREAD * spread)
        far = [{s: v * f for (s, v), f in zip(nominal.items(), row, strict=True)} for row in factors]
        clocked = replace(hypothesis, skew=0.0)
        starts = [(clocked, clocked.vector(values, {})) for values in (nominal, *far)]
        for level, (kept, steps) in enumerate(FUNNEL):
            self.on_stage(Stage(_PARAMETERS, f"{len(starts)} starts", level, 1 + len(FUNNEL), (_INTERVALS,)))
            begun = sorted(problem.fits(starts, self.executor, steps=steps, secant=True), key=lambda f: f.cost)
            self._best[:] = begun[:1]
            starts = [(clocked, f.x) for f in _distinct(begun)[:kept]]
        return [(hypothesis, hypothesis.vector(clocked.structure_values(x), {})) for _, x in starts]

    def _fitted(self, problem: Problem, starts: Sequence[tuple[Hypothesis, Array]]) -> list[Fitted]:
        """Fits to the end, those that are as good as the best of them, best first, each minimum once."""
        found = problem.fits(starts, self.executor, steps=STEPS, converged_at=CONVERGED)
        if not found:
            source = problem.tracks[0].smoothed.source
            raise BadInput(source, found="only numbers that no simulation can follow", expected="another --structure")
        found.sort(key=lambda f: f.cost)
        self._best[:] = found[:1]
        return [f for f in found if f.cost <= found[0].cost + _tolerated(problem, found[0])]

    def _told(self, prepared: Prepared, minima: Sequence[Fitted]) -> FirstModel:
        """The numbers on the fine clock, held against the noise that the best model makes of perfect data."""
        self.on_stage(Stage(_INTERVALS))
        assert prepared.fine is not None  # nothing was refused
        fine = replace(prepared.fine, coarse=1.0, tracks=with_floors(prepared.fine.tracks, minima[0].model))
        nominal = _with_friction_said(fine, minima[0], prepared.skew)
        minima = self._fitted(fine, [(replace(f.hypothesis, nominal=nominal), f.x) for f in minima])
        ci = _hull(fine, minima, self.executor)
        best = _simplest(fine, minima[0], ci)
        if best is not minima[0]:
            ci |= {s: _joined(ci[s], own) for s, own in _hull(fine, [best], self.executor).items()}
        model = cast(Model, best.model)
        if isinstance(model, FlexibleBoxModel) and set(NORMAL) <= set(fine.unseen):
            model = replace(model, normal=NormalContact(0.0, 0.0))
        units, caution = _units(self.recordings[0])
        model = replace(model, units=units)
        ruler, left = Ruler(prepared, fine), NoiseReference.of(fine).left(best)
        numbers = _numbers(model, minima[0], ci)
        if left > NOTHING_LEFT:
            numbers = [replace(n, told="of this structure") if n.told == "determined" else n for n in numbers]
        return FirstModel(
            model=model,
            findings=prepared.findings,
            numbers=tuple(numbers),
            heldout=tuple(held.nrmse(model) for held in ruler.heldout),
            noise=tuple(held.floor(model) for held in ruler.heldout),
            left=left,
            minima=len(_distinct(minima)),
            caution=caution,
        )


def _with_friction_said(problem: Problem, best: Fitted, skew: float) -> Structure:
    """The numbers that were looked about, with friction as a vector or for each axis: what fits better.

    Neither they nor those that were found need be such as can be simulated at this rate: then nothing is said of it.
    """
    nominal = best.hypothesis.nominal
    for model in (nominal, best.model):
        found = attempt(said, problem, cast(Model, model), partial(fit_near, problem, skew))
        if found is not None:
            better, _ = found
            if isinstance(better, FlexibleBoxModel) and isinstance(nominal, FlexibleBoxModel):
                return replace(nominal, in_plane=better.in_plane)
            return better
    return nominal


def _tolerated(problem: Problem, best: Fitted) -> float:
    """By how much another fit may be worse than the best and still not be ruled out."""
    return RULED_OUT * max(1.0, best.cost / problem.samples())


def _about(best: Fitted) -> Model:
    """The model that a further turn looks about: what was found, nothing of it 0."""
    nominal = best.hypothesis.nominal
    found = {
        symbol: math.copysign(max(abs(value), abs(nominal.parameter(symbol)) / FARTHEST), value)
        for symbol, value in best.structure_values.items()
    }
    return cast(Model, replace(nominal.with_parameters(**found), window_s=None, initial="rest"))


def _hull(problem: Problem, fits: Sequence[Fitted], executor: Executor) -> dict[str, Interval]:
    """Of each number of the structure the 95 % interval, over all of these fits; alike ones are known alike well."""
    apart = _distinct(fits)
    known = list(zip(apart, executor.map(intervals, [problem] * len(apart), apart), strict=True))
    hull: dict[str, Interval] = {}
    for fitted in fits:
        like, known_to = next((other, spans) for other, spans in known if other is fitted or _alike(fitted, other))
        free = fitted.hypothesis.free_parameters(fitted.x)
        for parameter, x, x_like, (low, high) in zip(free, fitted.x, like.x, known_to, strict=True):
            own = float(x) + WIDER * (low - float(x_like)), float(x) + WIDER * (high - float(x_like))
            hull[parameter.symbol] = _joined(hull.get(parameter.symbol, own), own)
    return hull


def _joined(one: Interval, other: Interval) -> Interval:
    return min(one[0], other[0]), max(one[1], other[1])


def _simplest(problem: Problem, best: Fitted, ci: Mapping[str, Interval]) -> Fitted:
    """The fit with all numbers 0 that may be, one after the other, the least certain first."""
    may_be = [s for s in best.hypothesis.free if ci[s][0] <= 0.0 <= ci[s][1]]
    tolerated = best.cost + _tolerated(problem, best)
    for symbol in sorted(may_be, key=lambda s: abs(best.structure_values[s]) / np.ptp(ci[s])):
        nominal = attempt(best.hypothesis.nominal.with_parameters, **{symbol: 0.0})
        if nominal is None:  # a mass is never 0, however little is known of it
            continue
        hypothesis = replace(best.hypothesis, nominal=nominal)
        start = hypothesis.vector(best.structure_values, {}, best.skew)
        without = attempt(problem.fit, hypothesis, start, steps=STEPS, converged_at=CONVERGED)
        if without is not None and without.cost <= tolerated:
            best = without
    return best


def _numbers(model: Model, fitted: Fitted, ci: Mapping[str, Interval]) -> list[FirstNumber]:
    """The numbers of the structure: with all of them free, and as they are in the model."""
    found = []
    for parameter in fitted.hypothesis.free_parameters(fitted.x):
        symbol, (low, high) = parameter.symbol, ci[parameter.symbol]
        if symbol == SKEW:
            continue
        told: Told = "determined"
        if high >= _NEAR * parameter.high:
            told = "cannot be told"
        elif low <= parameter.low / _NEAR:
            told = "at most"
        shown = (max(low, parameter.low), min(high, parameter.high))
        found.append(FirstNumber(symbol, model.parameter(symbol), model.unit(parameter.unit), shown, told))
    return found


def _distinct(fits: Sequence[Fitted]) -> list[Fitted]:
    """Fits without those whose numbers are all within a tenth of those of one before them."""
    kept: list[Fitted] = []
    for fitted in fits:
        if not any(_alike(fitted, other) for other in kept):
            kept.append(fitted)
    return kept


def _alike(one: Fitted, other: Fitted) -> bool:
    return bool(np.max(np.abs(one.x - other.x) / one.hypothesis.limits(one.x)[2]) <= _APART)


def _units(recording: Recording) -> tuple[Units | None, str | None]:
    """Of position and force, where both were told and are others than m and N; else why they cannot be."""
    names = ("output", "input") if recording.kind == "driven_body" else ("position", "force")
    told = [recording.own_units.get(name) for name in names]
    if told == [None, None] or told == ["m", "N"]:
        return None, None
    for name, unit in zip(names, told, strict=True):
        if unit is None or attempt(Units, unit) is None:
            why = "is not told" if unit is None else f"is {unit!r}, which has no name in a model file"
            return None, f"The unit of {name} {why}: numbers are given as if all were in m and N."
    position, force = cast(list[str], told)
    return Units(position, force), None
