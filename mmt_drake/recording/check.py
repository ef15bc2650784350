"""Checks that every recording must pass, whatever file it comes from."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from mmt_drake.errors import BadInput, some, suggest
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.column_map import ColumnMap, left_out, units_of
from mmt_drake.recording.derive import HOW, rate_of, touches
from mmt_drake.recording.recording import Cloud, Recording
from mmt_drake.recording.signals import AXES, FLAGS, ORIENTATION, REQUIRED, SIGNALS, Kind, columns_of, kind_of
from mmt_drake.recording.stored import LongColumns

# Beyond these no recording of a probe, a carriage or a servo is plausible: the unit is wrong.
SLOWEST_STEP = 0.5
FASTEST_STEP = 1e-6
FARTHEST = 5.0
STRONGEST = 1e3
STRONGEST_SINGLE_AXIS = 2e4
LARGEST = 1e100  # whatever a driven body's unit is
LATEST = 1e12  # seconds
_RATE_MISMATCH = 300.0

_ESTIMATED = ("theta", "theta_deviation", "model")
_MAY_BE_UNKNOWN = {column for signal in SIGNALS if signal.name in _ESTIMATED for column in signal.columns}
_MAY_BE_UNKNOWN |= {column for signal in SIGNALS if signal.name == "scene" for column in signal.groups[1]}
_FEWEST = 3
_UNIT_LENGTH = 0.01  # of a quaternion: what rounding, or a line between two of them, may take


def completed(
    time: Array,
    columns: Mapping[str, Array],
    source: str,
    *,
    forces: bool = True,
    notes: Sequence[str] = (),
    clouds: Sequence[Cloud] = (),
    constants: Mapping[str, float] | None = None,
    units: Mapping[str, str] | None = None,
) -> Recording:
    """Check the columns of one recording, derive the optional ones that are missing, and put them together.

    Derived are the velocity (``output_rate`` of a driven body) by ``derive.rate_of`` and, for
    three axes, ``in_contact`` by z < 0. Each is listed in ``notes``.

    Args:
        time: (n,) [s].
        columns: name -> (n,), names and units of CONVENTIONS.md ("Recordings").
        source: file that they come from, for messages.
        forces: whether a contact recording must have them; an operator's motion need not.
        notes: of the reader, to stand before those of what is derived.
        clouds: as of ``Recording``.
        constants: as of ``Recording``.
        units: column -> SI unit, where one was told.

    Raises:
        BadInput: a column is unknown, missing, of another length, not finite; times do not
            increase strictly; values that no unit of the contract makes plausible.
    """
    kind = kind_of(columns)
    if kind == "motion" and forces:
        kind = "contact"
    check_names(columns, kind, source)
    if len(time) < _FEWEST:
        raise BadInput(source, found=f"{len(time)} samples", expected=f"at least {_FEWEST}")
    for name, values in columns.items():
        if len(values) != len(time):
            raise BadInput(source, at=name, found=f"{len(values)} values", expected=f"{len(time)}, as many as times")
    _check_values(time, columns, source)
    _check_orientation(columns, source)
    _check_clock(time, source)
    _check_units(time, columns, kind, units or {}, source)
    for name, value in (constants or {}).items():
        if name in columns or name == "time":
            raise BadInput(source, at=name, found="a constant", expected="a column alone of this name")
        if not math.isfinite(value):
            raise BadInput(source, at=f"constant {name!r}", found=value, expected="a finite number")
    derived, more = _derived(time, columns, kind)
    return Recording(
        time,
        LongColumns(columns, derived),
        source,
        clouds,
        (*notes, *more),
        constants or {},
        frozenset(derived),
        units or {},
    )


def mapped(recording: Recording, columns: ColumnMap, forces: bool) -> Recording:
    """A recording whose columns are to be taken for others; as it is where nothing is said of them.

    Raises:
        BadInput: what ``columns`` asks for is not there, or what ``completed`` finds.
    """
    if not columns:
        return recording
    own = [name for name in recording.columns if name not in recording.derived]
    headers = ["time", *own]
    taken = {column.name: column for column in columns.taken(headers, recording.source)}
    notes = [*recording.notes, *left_out(headers, taken.values())]
    clock = taken.pop("time")
    time = clock.factor * (recording.time if clock.column == "time" else recording[clock.column])
    read = {name: column.factor * recording[column.column] for name, column in taken.items()}
    taken_for = completed(
        time,
        read,
        recording.source,
        forces=forces,
        notes=notes,
        clouds=recording.clouds,
        constants=recording.constants,
        units=units_of(taken.values()),
    )
    return replace(taken_for, made_by=recording.made_by)


def check_names(names: Mapping[str, object], kind: Kind, source: str) -> None:
    """Every name known to this kind and every required one there, vectors and theta whole.

    Raises:
        BadInput: not so.
    """
    known = columns_of(kind)
    for name in names:
        if name not in known:
            what = kind.replace("_", " ")
            hint = suggest(name, known) or ": " + some(known)
            expected = f"a column of a {what} recording{hint}; --map says what a column of another name is"
            if re.match(r"(.*_)?(q|tau|position|effort)[_\[.]?\d+\]?$", name):
                expected += (
                    "; a log of an arm's joints takes the model of an arm, `structure: multibody` (docs/arms.md)"
                )
            raise BadInput(source, at="columns", found=f"unknown column {name!r}", expected=expected)
    missing = [name for name in REQUIRED[kind] if name not in names]
    if not missing and kind in ("contact", "motion"):
        for signal in SIGNALS:
            for group in signal.groups:
                if any(name in names for name in group):
                    missing += [name for name in group if name not in names]
    if missing:
        columns = ", ".join(["time", *names])
        alone = [axis for axis in AXES if {f"position_{axis}", f"force_{axis}"} <= set(names)]
        offer = f"; or --axis {' or '.join(alone)}, that axis alone" if alone and kind == "contact" else ""
        raise BadInput(source, at="columns", found=columns, expected=f"also {', '.join(dict.fromkeys(missing))}{offer}")


def _bad_value(source: str, index: int, name: str, found: object, expected: str) -> BadInput:
    return BadInput(source, at=f"row {index + 1}, column {name!r}", found=found, expected=expected)


def _check_values(time: Array, columns: Mapping[str, Array], source: str) -> None:
    for name, values in chain([("time", time)], columns.items()):  # one at a time: long ones stand on disk
        bad = ~np.isfinite(values)
        if name in _MAY_BE_UNKNOWN:
            bad &= ~np.isnan(values)
        if bad.any():
            index = int(np.argmax(bad))
            raise _bad_value(source, index, name, values[index], "a finite number")
        if name in FLAGS:
            bad = (values != 0.0) & (values != 1.0)
            if bad.any():
                index = int(np.argmax(bad))
                raise _bad_value(source, index, name, values[index], "0 or 1")


def _check_orientation(columns: Mapping[str, Array], source: str) -> None:
    if not all(name in columns for name in ORIENTATION):
        return
    length = np.sqrt(sum(columns[name] ** 2 for name in ORIENTATION))
    bad = np.abs(length - 1.0) > _UNIT_LENGTH
    if bad.any():
        index = int(np.argmax(bad))
        at = f"row {index + 1}, columns {', '.join(ORIENTATION)}"
        raise BadInput(source, at=at, found=f"a length of {length[index]:.4g}", expected="a unit quaternion")


def _check_clock(time: Array, source: str) -> None:
    _check_limit(time, "time", LATEST, "s, is this ms, us or ns?", source)
    steps = np.diff(time)
    if (steps <= 0.0).any():
        index = int(np.argmax(steps <= 0.0)) + 1
        what = "the same time again" if steps[index - 1] == 0.0 else "time going back"
        found = f"{what}, {time[index]} s after {time[index - 1]} s"
        raise _bad_value(source, index, "time", found, "times that increase strictly")
    step = float(np.median(steps))
    if not FASTEST_STEP <= step <= SLOWEST_STEP:
        expected = f"{FASTEST_STEP:g} to {SLOWEST_STEP:g} s; time is in seconds, is this ms, us or ns?"
        raise BadInput(source, at="column 'time'", found=f"a median step of {step:.6g} s", expected=expected)


# Only what a sensor read has a plausible size; what was computed from an early estimate may be anything.
_SENSED_FORCES = ("force", "command_force")


def _check_units(time: Array, columns: Mapping[str, Array], kind: Kind, units: Mapping[str, str], source: str) -> None:
    _check_rates(time, columns, source)
    if kind == "driven_body":  # its units are its own
        for name, values in columns.items():
            _check_limit(values, name, LARGEST, "in any unit", source)
        return
    strongest = STRONGEST_SINGLE_AXIS if kind == "single_axis" else STRONGEST
    for signal in SIGNALS:
        for name in signal.columns:
            if name not in columns:
                continue
            if signal.quantity == "position" or name == "position":
                unit, limit, hint = "m", FARTHEST, "m, is it in mm?"
            elif signal.name in _SENSED_FORCES:
                unit, limit, hint = "N", strongest, "N, is it in mN?"
            else:
                continue
            if units.get(name, unit) != unit:
                limit, hint = LARGEST, "in any unit"
            _check_limit(columns[name], name, limit, hint, source)


def _check_limit(values: Array, name: str, limit: float, hint: str, source: str) -> None:
    index = int(np.argmax(np.abs(values)))
    if abs(values[index]) > limit:
        raise _bad_value(source, index, name, f"{values[index]:g}", f"at most {limit:g} {hint}")


_RATED = [
    ([f"{owner}position_{axis}" for axis in AXES], [f"{owner}velocity_{axis}" for axis in AXES])
    for owner in ("", "master_")
] + [(["position"], ["velocity"]), (["output"], ["output_rate"])]


def _check_rates(time: Array, columns: Mapping[str, Array], source: str) -> None:
    """A velocity that belongs to its position integrates to it; a thousand times more or less is a unit."""
    for names, rate_names in _RATED:
        if not all(name in columns for name in names + rate_names):
            continue
        extent = extent_of_integral = overlap = 0.0
        for name, rate_name in zip(names, rate_names, strict=True):  # by axis: long recordings leave no room for tables
            with np.errstate(over="ignore", invalid="ignore"):  # what overflows belongs to no position
                integral = _integral(time, columns[rate_name])
                moved = columns[name] - columns[name].mean()
                overlap += float(np.sum(moved * integral))
                extent += float(np.sum(np.square(moved, out=moved)))
                extent_of_integral += float(np.sum(np.square(integral, out=integral)))
                del integral, moved
        extent, extent_of_integral = math.sqrt(extent), math.sqrt(extent_of_integral)
        belongs = overlap > 0.9 * extent * extent_of_integral
        if not belongs:
            continue
        ratio = extent_of_integral / extent
        if not 1.0 / _RATE_MISMATCH < ratio < _RATE_MISMATCH:
            found = f"{ratio:.3g} times the rate of {names[0]!r}"
            expected = "its rate; are positions, velocities and times all in m, m/s and s?"
            raise BadInput(source, at=f"column {rate_names[0]!r}", found=found, expected=expected)


def _integral(time: Array, rate: Array) -> Array:
    """The integral of a rate, about its mean, (n,)."""
    integral = np.zeros(len(time))
    steps = np.add(rate[1:], rate[:-1], out=integral[1:])
    steps *= np.diff(time)
    steps *= 0.5
    np.cumsum(steps, out=steps)
    integral -= integral.mean()
    return integral


def _derived(time: Array, columns: Mapping[str, Array], kind: Kind) -> tuple[dict[str, Array], list[str]]:
    derived: dict[str, Array] = {}
    notes = []
    pairs = {"driven_body": [("output", "output_rate")], "single_axis": [("position", "velocity")]}.get(
        kind, [(f"position_{axis}", f"velocity_{axis}") for axis in AXES]
    )
    missing = [(name, rate_name) for name, rate_name in pairs if rate_name not in columns]
    if missing:
        derived.update({rate_name: rate_of(time, columns[name]) for name, rate_name in missing})
        notes.append(f"{', '.join(derived)}: {HOW}")
    if kind in ("contact", "motion") and "in_contact" not in columns:
        derived["in_contact"] = touches(columns["position_z"])
        notes.append("in_contact: derived, 1 where position_z < 0")
    return derived, notes
