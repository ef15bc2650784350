"""Numbers of a model that are curves over what was recorded beside the motion: what they are in a recording.

`over: {Fc: current}` in a model file. A diagnosis fits the number at a few knots of that column, and it is linear
between them. A column that stands still in each recording gives one value for each; one that changes within a recording
is followed sample by sample. `over: {Fc: recording}` is a value for each recording, whatever its columns.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from mmt_drake.effects import LIBRARY, Effect, Parameter
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.over import RECORDING, Course, Over
from mmt_drake.model.parameters import COURSE, FD, FS, MAX_STEP, PLANAR, FlexibleBoxModel
from mmt_drake.model.structure import Structure
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model.transmission import TransmissionModel
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.typed_yaml import known_keys

Model = TypeVar("Model", bound=Structure)
Conditions = Mapping[str, Array | float | str]
"""Column -> its values (n,), or the one that it has throughout; `RECORDING` -> the recording's name."""

KNOTS = 4
"""Of a curve over a column that changes within a recording; where fewer values occur, these."""
_CLOSE = 0.05
"""Knots are at least this part of the range apart."""
_DIGITS = 2
"""Decimals of the range's order to which they are rounded, for names that can be read."""
_NO_FRICTION = 1e-9
"""Times its largest level: a level of friction that is 0 for a while stays set-valued, as its neighbours are."""


def conditions(model: Structure, recording: Recording) -> Conditions:
    """What the curves of a model are over in a recording.

    Raises:
        BadInput: the recording has no such column, or not a number in every row of it.
    """
    return {curve.of: _condition(curve, recording) for curve in model.over if curve.at}


def in_recording(model: Model, recording: Recording) -> Model:
    """The model as it is in a recording, without curves.

    Raises:
        BadInput: as `conditions` and `under`.
    """
    return under(model, conditions(model, recording), recording.time - recording.time[0], recording.source)


def under(model: Model, known: Conditions, time: Array, source: str) -> Model:
    """The model as it is under conditions, without curves; where they change within a recording it has a `Course`.

    Args:
        model: with curves or without.
        known: of every column that a curve is over; values (n,) at the times.
        time: (n,) [s] since the first sample.
        source: of the recording, for messages.

    Raises:
        BadInput: a recording for which a curve has no value, or a condition that changes within one, of a flexible box.
    """
    curves = [curve for curve in model.over if curve.at and (not curve.effect or _acts(curve, model))]
    if not curves:
        return model
    values: dict[str, float] = {}
    moving: list[tuple[Over, Array]] = []
    for curve in curves:
        at = known[curve.of]
        if isinstance(at, str):
            values[curve.number] = curve.named(at, source)
            continue
        now = np.interp(at, np.array(curve.at, dtype=np.float64), curve.value)
        values[curve.number] = float(np.mean(now))
        if isinstance(at, np.ndarray):
            moving.append((curve, at))
    result = _settled(model, values)
    if not moving:
        return result
    if isinstance(model, FlexibleBoxModel | SurfaceContact):
        found = f"a {moving[0][0].of} that changes within the recording"
        raise BadInput(
            source, at=f"over.{moving[0][0].number}", found=found, expected=f"one value of it, for a {model.NAME}"
        )
    return result.with_additions(course=_course(model, result, values, moving, time))


def standing_still(known: Conditions) -> Conditions:
    """Conditions that stay what they are on average."""
    return {of: float(np.mean(at)) if isinstance(at, np.ndarray) else at for of, at in known.items()}


def with_knots(model: Model, recordings: Sequence[Recording]) -> Model:
    """A model whose curves have knots where recordings are, to be fitted; what is known of a curve stays as it is.

    A number that is 0 was left out: its curve is that of the effect that stands for it, and of those of its family that
    have a number of this name, should one of them be found.

    Raises:
        BadInput: as `conditions`; two recordings of one name, for a number that is free per recording.
    """
    handed = model.handed
    if handed is not None:
        bare = replace(handed.bare, over=_with_knots(model, recordings))
        return replace(model, over=bare.over, handed=replace(handed, bare=bare))
    return replace(model, over=_with_knots(model, recordings))


def parsed(data: Mapping[str, Any], model: Structure, source: str) -> tuple[Over, ...]:
    """The curves that the key `over` of a model file describes: number -> a column, or of, at and value.

    Raises:
        BadInput: a number that the structure and its effects do not have, or a curve that is none.
    """
    return tuple(_parsed(number, value, model, source) for number, value in data.items())


def written(curve: Over) -> Any:
    """The curve as `parsed` reads it."""
    return {"of": curve.of, "at": list(curve.at), "value": list(curve.value)} if curve.at else curve.of


def _acts(curve: Over, model: Structure) -> bool:
    return model.handed is not None and any(name == curve.effect for name, _ in model.handed.effects)


def _settled(model: Model, values: Mapping[str, float]) -> Model:
    """The model with numbers in the place of its curves."""
    handed = model.handed
    bare = model if handed is None else handed.bare
    own = {number: value for number, value in values.items() if "." not in number}
    settled: Any = replace(bare.with_parameters(**own), over=(), handed=None)
    for name, numbers in () if handed is None else handed.effects:
        changed = {symbol: values.get(f"{name}.{symbol}", value) for symbol, value in numbers.items()}
        settled = LIBRARY[name].apply(settled, changed)
    result: Model = settled  # of its type, as effects leave it
    return result


def _course(
    model: Structure, mean: Any, values: Mapping[str, float], moving: Sequence[tuple[Over, Array]], time: Array
) -> Course:
    """What changes of the kernel vector.

    Every number of it is linear in each parameter, so it is interpolated between the vectors at the knots. One
    condition changes it by what it would change it alone.
    """
    middle = mean.kernel_vector()
    changes: dict[int, Array] = {}
    steps = [middle[MAX_STEP]]
    for curve, at in moving:
        ends: list[Any] = [_settled(model, {**values, curve.number: value}) for value in curve.value]
        rows = np.array([end.kernel_vector() for end in ends])
        steps += rows[:, MAX_STEP].tolist()
        for i in np.flatnonzero((rows != rows[0]).any(axis=0)).tolist():
            if i not in (MAX_STEP, COURSE, PLANAR):
                now = np.interp(at, np.array(curve.at, dtype=np.float64), rows[:, i])
                changes[i] = changes.get(i, np.full(len(time), middle[i])) + now - middle[i]
    for i in {FS, FD} & set(changes):
        changes[i] = np.maximum(changes[i], _NO_FRICTION * float(np.max(changes[i])))
    return Course(tuple(changes), time, np.array([*changes.values()]).reshape(len(changes), len(time)), min(steps))


def _condition(curve: Over, recording: Recording) -> Array | float | str:
    """The values (n,) of what a curve is over, one number where it stands still, or the recording's name."""
    if curve.of == RECORDING:
        return Path(recording.source).name
    if curve.of in recording:
        values = recording[curve.of]
        bad = ~np.isfinite(values)
        if bad.any():
            at = f"row {int(np.argmax(bad)) + 1}, column {curve.of!r}"
            raise BadInput(recording.source, at=at, found=values[np.argmax(bad)], expected="a finite number")
        return values if np.ptp(values) > 0.0 else float(values[0])
    for name, value in recording.constants.items():
        if curve.of in (name, name.rpartition("_")[0]):  # the unit stands in the name
            return value
    columns = [name for name in recording.columns if name not in recording.derived]
    found = f"columns {', '.join(columns)}; constants {', '.join(recording.constants) or 'none'}"
    expected = f"a column or constant {curve.of!r}"
    raise BadInput(recording.source, at=f"over.{curve.number}", found=found, expected=expected)


def _with_knots(model: Structure, recordings: Sequence[Recording]) -> tuple[Over, ...]:
    result = []
    for begun, start in (begun for curve in model.over for begun in _begun(curve, model)):
        known = [_condition(begun, recording) for recording in recordings]
        names = [value for value in known if isinstance(value, str)]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise BadInput(
                f"over.{begun.number}", found=f"two recordings called {twice!r}", expected="names that differ"
            )
        at: tuple[Any, ...] = tuple(names) or _knots([np.atleast_1d(np.asarray(value)) for value in known])
        if begun.at:
            low, high = begun.at[0], begun.at[-1]
            at = tuple(x for x in at if (x not in begun.at if names else not low <= x <= high))
        pairs: dict[Any, float] = dict(zip(begun.at, begun.value, strict=True)) | dict.fromkeys(at, start)
        if begun.at and not names:  # held beyond its ends, as it was
            pairs |= {x: begun.value[0 if x < begun.at[0] else -1] for x in at}
            pairs = dict(sorted(pairs.items()))
        result.append(replace(begun, at=tuple(pairs), value=tuple(pairs.values())))
    return tuple(result)


def _begun(curve: Over, model: Structure) -> list[tuple[Over, float]]:
    """The curve, or those of effects where its number was left out; each with the number that it begins with."""
    if curve.at:
        return [(curve, curve.mean)]
    bare, effects = (model, ()) if model.handed is None else (model.handed.bare, model.handed.effects)
    if curve.effect:
        values = next((values for name, values in effects if name == curve.effect), {})
        return [(curve, float(values.get(curve.symbol, 0.0)))]
    start = bare.parameter(curve.symbol) if curve.symbol in bare.determinable else 0.0
    if start != 0.0 or curve.symbol in bare.ALWAYS:
        return [(curve, start)]
    missing = _standing_for(curve.symbol, bare)
    if not missing:
        expected = "a number that is not, or effect.symbol of the effect that may be missing"
        raise BadInput("model", at=f"over.{curve.number}", found=f"{curve.symbol} = 0, left out", expected=expected)
    begun = (replace(curve, number=number) for number in missing)
    return [one for own in begun for one in _begun(own, model)]


def _standing_for(symbol: str, model: Structure) -> list[str]:
    """Numbers of effects that a structural number stands for: of the one that adds to it, and of its family."""
    acting = [effect.within(model) for effect in LIBRARY.values() if effect.acts_on(model)]
    families = {e.family for e in acting if e.adds_to is not None and model.SYMBOLS.get(e.adds_to, e.adds_to) == symbol}
    return [f"{e.name}.{symbol}" for e in acting if e.family in families and symbol in _fitted(e)]


def _fitted(effect: Effect) -> dict[str, Parameter]:
    """The numbers of an effect that a diagnosis fits, by symbol."""
    return {p.symbol: p for p in effect.parameters if p.default is None and p.kind == "number"}


def _knots(values: Sequence[Array]) -> tuple[float, ...]:
    """All values that occur where they are few, or each recording has one; else quantiles, not too close."""
    distinct = np.unique(np.concatenate(values))
    if len(distinct) <= KNOTS or all(len(own) == 1 for own in values):
        return tuple(distinct.tolist())
    spread = float(np.ptp(distinct))
    decimals = _DIGITS - math.floor(math.log10(spread))
    chosen: list[float] = []
    for x in np.quantile(np.concatenate(values), np.linspace(0.0, 1.0, KNOTS)).tolist():
        rounded = round(x, decimals)
        if not chosen or rounded - chosen[-1] > _CLOSE * spread:
            chosen.append(rounded)
    return tuple(chosen)


def _parsed(number: str, value: object, model: Structure, source: str) -> Over:
    at = f"over.{number}"
    own = _own(number, model, source)
    if isinstance(value, str) and value:
        return Over(number, _beside(value, model, source, at))
    if not isinstance(value, dict):
        raise BadInput(source, at=at, found=repr(value), expected=f"a column, {RECORDING!r}, or of, at and value")
    known_keys(value, ("of", "at", "value"), source, at)
    of, knots, values = (value.get(key) for key in ("of", "at", "value"))
    if not isinstance(of, str) or not of:
        raise BadInput(source, at=f"{at}.of", found=repr(of), expected=f"a column or {RECORDING!r}")
    if not (isinstance(knots, list) and isinstance(values, list) and len(knots) == len(values) > 0):
        found = f"{len(knots) if isinstance(knots, list) else 'no'} knots, "
        found += f"{len(values) if isinstance(values, list) else 'no'} values"
        raise BadInput(source, at=at, found=found, expected="lists at and value, as many of both")
    _beside(of, model, source, f"{at}.of")
    if of == RECORDING:
        if not all(isinstance(name, str) for name in knots) or len(set(knots)) < len(knots):
            raise BadInput(source, at=f"{at}.at", found=knots, expected="names of recordings that differ")
    else:
        knots = [Parameter("at", f"of {of}").checked(x, f"{source}: {at}") for x in knots]
        if any(b <= a for a, b in pairwise(knots)):
            raise BadInput(source, at=f"{at}.at", found=knots, expected="numbers that increase")
    checked = tuple(own.checked(x, f"{source}: {at}.value") for x in values)
    if number in model.determinable:
        _possible(number, checked, model, source, f"{at}.value")
    return Over(number, of, tuple(knots), checked)


def _beside(of: str, model: Structure, source: str, at: str) -> str:
    """The column that a curve is over.

    Raises:
        BadInput: it is the goal of a closed loop, or what its controller put out.
    """
    if of in ("goal", "input") and isinstance(model, DrivenBodyModel) and model.controller is not None:
        raise BadInput(source, at=at, found=f"{of!r} beside a controller", expected="a column that is not of the loop")
    return of


def _possible(symbol: str, values: Sequence[float], model: Structure, source: str, at: str) -> None:
    """Refuse values that the structure cannot have, or that make it another kind of simulation between knots."""
    for value in values:
        try:
            model.with_parameters(**{symbol: value})
        except BadInput as error:
            raise BadInput(source, at=at, found=error.found, expected=error.expected) from None
    kinds = {value == 0.0 for value in (*values, float(np.mean(values)))}
    if isinstance(model, TransmissionModel) and symbol in ("m", "load") and len(kinds) > 1:
        expected = f"{symbol} = 0 throughout, or nowhere and not on average"
        raise BadInput(source, at=at, found=list(values), expected=expected)


def _own(number: str, model: Structure, source: str) -> Parameter:
    """The number that may be a curve: one that a diagnosis fits.

    Raises:
        BadInput: there is no such number.
    """
    name, _, symbol = number.rpartition(".")
    effect = LIBRARY.get(name)
    if not name:
        own = {s: q for s, q in model.determinable.items() if s not in model.GIVEN}
        if symbol in own:
            return Parameter(symbol, own[symbol].unit, (own[symbol].least, own[symbol].most))
        missing = _standing_for(symbol, model)
        if missing:
            return _own(missing[0], model, source)
        expected = f"{', '.join(own)}, or effect.symbol"
    elif effect is None or not effect.within(model).acts_on(model):
        expected = f"an effect of a {model.NAME}"
    else:
        fitted = _fitted(effect)
        if symbol in fitted:
            return fitted[symbol]
        expected = ", ".join(f"{name}.{s}" for s in fitted) or "an effect with numbers that are fitted"
    raise BadInput(source, at="over", found=repr(number), expected=expected)
