"""The parts of the document that a diagnosis is: what is named, with what numbers, and what else was thought of."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.decide.confidence import ConfidenceSet, Depth
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.errors import Interval, heldout_nrmse, intervals_of, noise_floor
from mmt_drake.diagnosis.fit.hypothesis import SKEW
from mmt_drake.diagnosis.fit.prepare import NormalFit, Prepared
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.search.equal import equal_sets
from mmt_drake.diagnosis.search.learn import Learned
from mmt_drake.diagnosis.tell.result import (
    Alternative,
    Candidate,
    EffectParameter,
    Fit,
    FittedParameter,
    HeldoutNrmse,
    NamedEffect,
    Status,
)
from mmt_drake.effects import tabulated_force
from mmt_drake.errors import MmtError
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Structure
from mmt_drake.recording import Recording
from mmt_drake.windows import blocks_of

MOST_CANDIDATES_TOLD = 25

HeldOutErrors = Mapping[frozenset[str], float | None]
"""Set of effects -> held-out error of its fit; None where the simulation of the raw recording diverges."""


def figures(prepared: Prepared, problem: Problem, models: tuple[Structure, Structure, Structure]) -> tuple[Fit, ...]:
    """The contract's figures of every recording as it is.

    Args:
        prepared: the recordings.
        problem: whose blocks are held out.
        models: nominal, with its parameters fitted, and delivered.

    Raises:
        MmtError: the simulation of a recording diverges.
    """
    result = []
    pairs = zip(prepared.recordings, prepared.preflights, problem.by_recording(), strict=True)
    for recording, check, (track, *_) in pairs:
        axes, blocks = check.axes, intervals_of(track.time, track.heldout)
        errors = HeldoutNrmse(*(heldout_nrmse(recording, model, blocks, axes) for model in models))
        free = HeldoutNrmse(*(_free(recording, model, blocks, axes) for model in models))
        floor = noise_floor(recording, models[-1], blocks, axes, track.smoothed)
        window = float(recording.time[-1] - recording.time[0])
        if models[0].window_s is not None:
            window /= blocks_of(recording.time, models[0].window_s)
        told = axes if isinstance(models[0], FlexibleBoxModel) and recording.kind == "contact" else ()
        result.append(Fit(told, blocks, floor, errors, free, window))
    return tuple(result)


def _free(recording: Recording, model: Structure, blocks: Sequence[Interval], axes: Sequence[str]) -> float | None:
    """The held-out error free-running; None where that diverges."""
    try:
        return heldout_nrmse(recording, replace(model, window_s=None), blocks, axes)
    except MmtError:
        return None


def named(
    best: Fitted, ci: Sequence[tuple[float, float]], depths: Mapping[str, Depth | None]
) -> tuple[NamedEffect, ...]:
    """The effects of a fit that have a depth, with the intervals of all their numbers, and how deep each name holds."""
    places = {(p.effect, p.symbol): i for i, p in enumerate(best.hypothesis.free_parameters())}
    values = best.hypothesis.effect_values(best.x)
    result = []
    for effect in (e for e in best.hypothesis.effects if e.name in depths):
        numbers = {}
        for p in effect.parameters:
            if p.symbol in values[effect.name]:
                i = places.get((effect.name, p.symbol))
                interval = None if i is None or not np.isfinite(ci[i]).all() else ci[i]
                numbers[p.symbol] = EffectParameter(float(values[effect.name][p.symbol]), p.unit, interval)
        result.append(NamedEffect(effect.name, effect.family, effect.block, depths[effect.name], numbers))
    return tuple(result)


def tabulated(learned: Learned | None) -> tuple[NamedEffect, ...]:
    """A learned table as the document has it; nothing if none was learned."""
    if learned is None:
        return ()
    table = learned.values
    value = tuple(table["value"])
    low, high = (tuple(float(v + sign * h) for v, h in zip(value, learned.half_width, strict=True)) for sign in (-1, 1))
    signal = tabulated_force.SIGNALS[table["of"]]
    numbers = {
        "of": EffectParameter(table["of"], "signal"),
        "at": EffectParameter(tuple(table["at"]), "unit of the signal"),
        "value": EffectParameter(value, signal.unit, (low, high)),
    }
    return (NamedEffect(tabulated_force.EFFECT.name, tabulated_force.EFFECT.family, signal.block, None, numbers),)


def parameters(
    model: Structure, best: Fitted, ci: Sequence[tuple[float, float]], normal: NormalFit | None
) -> Mapping[str, FittedParameter]:
    """Parameters handed in whose interval excludes what they were; those of effects by name and symbol, `name.Fs`."""
    result = {}
    handed = {effect.name: values for effect, values in best.hypothesis.believed}
    for place, value, (low, high) in zip(best.hypothesis.free_parameters(), best.x, ci, strict=True):
        if place.symbol != SKEW and (not place.effect or place.effect in handed):
            own = place.effect and handed[place.effect]
            nominal = float(own[place.symbol]) if own else best.hypothesis.nominal.parameter(place.symbol)
            if not low <= nominal <= high:
                symbol = f"{place.effect}.{place.symbol}" if own else place.symbol
                result[symbol] = FittedParameter(nominal, float(value), place.unit, (low, high))
    if normal is not None and isinstance(model, FlexibleBoxModel):
        for symbol, unit, (low, high) in zip(("k", "b"), ("N/m", "N s/m"), normal.ci95, strict=True):
            nominal = getattr(model.normal, symbol)
            if not low <= nominal <= high:
                value = getattr(normal.normal, symbol)
                result[f"normal.{symbol}"] = FittedParameter(nominal, value, unit, (low, high))
    return result


def _name(fitted: Fitted) -> str:
    return " + ".join(fitted.hypothesis.names)


def alternatives(
    best: Fitted, rivals: Sequence[Fitted], ranked: Sequence[Fitted], believed: ConfidenceSet, errors: HeldOutErrors
) -> tuple[Alternative, ...]:
    """Rivals, sets that are equal by construction, and the next best with the reason why they are out."""
    result = [Alternative(_name(f), errors[f.hypothesis.key], True, "is not ruled out") for f in rivals]
    told = {f.hypothesis.key for f in rivals}
    for names in equal_sets(best, believed.turning):
        if names not in told:
            result.append(Alternative(" + ".join(sorted(names)), None, True, "equal by construction"))
    behind = [f for f in ranked if f not in rivals and f.hypothesis.key != best.hypothesis.key][:5]
    result += [Alternative(_name(f), errors[f.hypothesis.key], False, _out(f, believed)) for f in behind]
    return tuple(result)


def _out(fitted: Fitted, believed: ConfidenceSet | None) -> str:
    chance = None if believed is None else believed.chances.get(fitted.hypothesis.key)
    if believed is None or chance is None:
        return "fits worse, and was not compared in full"
    if fitted.hypothesis.key in believed.standing and not believed.unsaid.get(fitted.hypothesis.key):
        return "not ruled out, but it takes too little off to be named"
    if fitted.hypothesis.key in believed.standing:
        return "not ruled out, but with an effect that may as well be nothing, or does not happen in the recordings"
    return f"ruled out: as good by chance with probability {chance:.2g}"


def candidates(
    refit: float | None,
    best: Fitted | None,
    ranked: Sequence[Fitted],
    rivals: Sequence[Fitted],
    errors: HeldOutErrors,
    believed: ConfidenceSet | None,
) -> tuple[Candidate, ...]:
    """The best of what was tried and what became of it.

    Args:
        refit: held-out error without any effect.
        best: what is named, if anything is.
        ranked: the candidates, best first.
        rivals: of them, what cannot be ruled out.
        errors: held-out error of each set of effects.
        believed: what the sets that were fitted to the end came to.
    """
    result = []
    for f in ranked[:MOST_CANDIDATES_TOLD]:
        own = errors[f.hypothesis.key]
        status: Status = "rejected"
        reason = _out(f, believed)
        if best is not None and f.hypothesis.key == best.hypothesis.key:
            status, reason = "accepted", "the simplest that is not ruled out"
        elif f in rivals:
            status, reason = "ambiguous", "is not ruled out"
        elif at_bounds(f):
            status, reason = "at a bound", f"{' and '.join(sorted(at_bounds(f)))} at a bound: it proves nothing"
        gained = None if own is None or refit is None else refit - own
        p = None if believed is None else believed.chances.get(f.hypothesis.key)
        result.append(Candidate(f.hypothesis.names, own, gained, p, status, reason))
    return tuple(result)
