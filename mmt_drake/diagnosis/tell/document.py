"""The parts of the document that a diagnosis is: what is named, with what numbers, and what else was thought of."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.decide.depth import Depth
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.errors import HeldOutPart
from mmt_drake.diagnosis.fit.hypothesis import SKEW
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.search.equal import equal_sets
from mmt_drake.diagnosis.search.learn import Learned
from mmt_drake.diagnosis.tell.reasons import Reasons
from mmt_drake.diagnosis.tell.result import (
    Alternative,
    AxisFit,
    Candidate,
    EffectParameter,
    Fit,
    FittedCurve,
    FittedParameter,
    HeldoutNrmse,
    NamedEffect,
    Status,
)
from mmt_drake.effects import tabulated_force
from mmt_drake.errors import attempt
from mmt_drake.model.structure import Structure
from mmt_drake.windows import blocks_of

MOST_LISTED = 25


def figures(held: HeldOutPart, models: tuple[Structure, Structure, Structure]) -> Fit:
    """The contract's figures of a recording as it is.

    Args:
        held: what of it is held out.
        models: nominal, with its parameters fitted, and delivered.

    Raises:
        MmtError: the simulation of the recording diverges.
    """
    axes = held.axes if held.recording.kind == "contact" else ()
    errors = HeldoutNrmse(*map(held.nrmse, models))
    by_axis = tuple(_along(replace(held, axes=(axis,)), models) for axis in axes)
    free = HeldoutNrmse(*(attempt(held.nrmse, replace(model, window_s=None)) for model in models))
    time = held.recording.time
    window = float(time[-1] - time[0])
    if models[0].window_s is not None:
        window /= blocks_of(time, models[0].window_s)
    unit = models[0].unit("m" if held.recording.kind == "driven_body" else "N")
    return Fit(axes, held.blocks, held.floor(models[-1]), errors, free, window, by_axis, held.spread(models[0]), unit)


def _along(held: HeldOutPart, models: tuple[Structure, Structure, Structure]) -> AxisFit:
    (axis,) = held.axes
    return AxisFit(axis, held.floor(models[-1]), HeldoutNrmse(*map(held.nrmse, models)))


def named(
    best: Fitted, ci: Sequence[tuple[float, float]], depths: Mapping[str, Depth | None]
) -> tuple[NamedEffect, ...]:
    """The effects of a fit that have a depth, with the intervals of all their numbers, and how deep each name holds."""
    index = {p.key: i for i, p in enumerate(best.hypothesis.free_parameters())}
    values = best.effect_values
    unit = best.hypothesis.nominal.unit
    result = []
    for effect in (e for e in best.hypothesis.effects if e.name in depths):
        numbers = {}
        for p in dict.fromkeys((*effect.parameters, *best.hypothesis.fitted_parameters(effect))):  # and those of curves
            told = f"{effect.name}.{p.symbol}" not in best.hypothesis.unseen
            if (
                told
                and p.symbol in values[effect.name]
                and not best.hypothesis.nominal.curve(f"{effect.name}.{p.symbol}")
            ):
                i = index.get((effect.name, p.symbol))
                interval = None if i is None or not np.isfinite(ci[i]).all() else ci[i]
                value = values[effect.name][p.symbol]
                value = tuple(value) if p.kind == "list" else float(value)
                numbers[p.symbol] = EffectParameter(value, unit(p.unit), interval)
        result.append(NamedEffect(effect.name, effect.family, effect.block, depths[effect.name], numbers, effect.axis))
    return tuple(result)


def tabulated(learned: Learned | None) -> tuple[NamedEffect, ...]:
    """A learned table as the document has it; nothing if none was learned."""
    if learned is None:
        return ()
    table = learned.values
    value = tuple(table["value"])
    low, high = (tuple(float(v + sign * h) for v, h in zip(value, learned.half_width, strict=True)) for sign in (-1, 1))
    known = bool(np.isfinite((low, high)).all())
    signal = tabulated_force.SIGNALS[table["of"]]
    numbers = {
        "of": EffectParameter(table["of"], "signal"),
        "at": EffectParameter(tuple(table["at"]), "unit of the signal"),
        "value": EffectParameter(value, learned.fitted.model.unit(signal.unit), (low, high) if known else None),
    }
    return (NamedEffect(tabulated_force.EFFECT.name, tabulated_force.EFFECT.family, signal.block, None, numbers),)


def parameters(best: Fitted, ci: Sequence[tuple[float, float]]) -> Mapping[str, FittedParameter]:
    """Parameters handed in whose interval excludes what they were; those of effects by name and symbol, `name.Fs`."""
    result, unit = {}, best.hypothesis.nominal.unit
    handed = {effect.name: values for effect, values in best.hypothesis.believed}
    for parameter, value, (low, high) in zip(best.hypothesis.free_parameters(), best.x, ci, strict=True):
        if parameter.symbol != SKEW and (not parameter.effect or parameter.effect in handed):
            own = parameter.effect and handed[parameter.effect]
            nominal = float(own[parameter.symbol]) if own else best.hypothesis.nominal.number(parameter.symbol)
            if not low <= nominal <= high:
                symbol = f"{parameter.effect}.{parameter.symbol}" if own else parameter.symbol
                result[symbol] = FittedParameter(nominal, float(value), unit(parameter.unit), (low, high))
    return result


def curves(best: Fitted, ci: Sequence[tuple[float, float]]) -> tuple[FittedCurve, ...]:
    """The numbers of a fit that are curves."""
    result = []
    handed = {effect.name for effect, _ in best.hypothesis.believed}
    for curve in best.hypothesis.nominal.over:
        free = zip(best.hypothesis.free_parameters(), best.x, ci, strict=True)
        own = [
            (p.unit, float(x), ends) for p, x, ends in free if p.effect == curve.effect and p.symbol in curve.symbols
        ]
        if own:
            value, (low, high) = tuple(x for _, x, _ in own), zip(*(ends for _, _, ends in own), strict=True)
            nominal = curve.value if not curve.effect or curve.effect in handed else None
            unit = best.hypothesis.nominal.unit(own[0][0])
            known = bool(np.isfinite((low, high)).all())
            result.append(
                FittedCurve(curve.number, curve.of, curve.at, nominal, value, unit, (low, high) if known else None)
            )
    return tuple(result)


def alternatives(
    best: Fitted, rivals: Sequence[Fitted], ranked: Sequence[Fitted], believed: ConfidenceSet, reasons: Reasons
) -> tuple[Alternative, ...]:
    """Rivals, sets that are equal by construction, and the next best with the reason why they are out."""
    errors = reasons.errors
    result = [Alternative(f.hypothesis.label, errors[f.hypothesis.key], True, reasons.of(f)) for f in rivals]
    known = {f.hypothesis.key for f in rivals}
    for names in equal_sets(best, believed.turning):
        if names not in known:
            result.append(Alternative(" + ".join(sorted(names)), None, True, "equal by construction"))
    behind = [f for f in ranked if f not in rivals and f.hypothesis.key != best.hypothesis.key][:5]
    result += [Alternative(f.hypothesis.label, errors[f.hypothesis.key], False, reasons.of(f)) for f in behind]
    return tuple(result)


def candidates(ranked: Sequence[Fitted], rivals: Sequence[Fitted], reasons: Reasons) -> tuple[Candidate, ...]:
    """The best of what was tried and what became of it.

    Args:
        ranked: the candidates, best first.
        rivals: of them, what cannot be ruled out.
        reasons: why they were taken or not.
    """
    result, best = [], reasons.named
    for f in ranked[:MOST_LISTED]:
        own = reasons.errors[f.hypothesis.key]
        status: Status = "rejected"
        if best is not None and f.hypothesis.key == best.hypothesis.key:
            status = "accepted"
        elif f in rivals:
            status = "ambiguous"
        elif at_bounds(f):
            status = "at a bound"
        gained = None if own is None or reasons.refit is None else reasons.refit - own
        p = None if reasons.believed is None else reasons.believed.chances.get(f.hypothesis.key)
        result.append(Candidate(f.hypothesis.names, own, gained, p, status, reasons.of(f)))
    return tuple(result)
