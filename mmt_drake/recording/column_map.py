"""What the columns of a file of one's own are: what each stands for, its unit and sign; and which axis is read."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from mmt_drake.errors import BadInput, suggest
from mmt_drake.recording.signals import AXES, SIGNALS, columns_of, kind_of, signal_names
from mmt_drake.recording.units import in_si, known, split
from mmt_drake.typed_yaml import parse, read_text

_UNITS = {"position": ("m",), "velocity": ("m/s",), "force": ("N",)}
_ONE_AXIS = {"position": ("m", "rad"), "velocity": ("m/s", "rad/s"), "force": ("N", "N m")}
_ANY: tuple[str, ...] = ()  # of a driven body
_TARGETS: dict[str, tuple[str, ...]] = {"time": ("s",)}
"""Column of a recording -> SI units that it may have."""
for _signal in SIGNALS:
    for _column in _signal.columns:
        _known = _ONE_AXIS if _signal.quantity == "number" else _UNITS
        _TARGETS[_column] = _known.get(_column if _signal.quantity == "number" else _signal.quantity, _ANY)
_MORE = " (docs/files.md)"
"""Where refusals say that the reader finds more."""


@dataclass(frozen=True)
class Taken:
    """A column of a file that is read.

    Attributes:
        name: what it is in the recording.
        column: its header in the file.
        factor: to the SI, with its sign.
        unit: SI unit, where one was told.
    """

    name: str
    column: str
    factor: float = 1.0
    unit: str | None = None


@dataclass(frozen=True)
class ColumnMap:
    """What the columns of a file are.

    Attributes:
        entries: name in the recording -> column of the file, `-` before it for the other sign, `:UNIT` behind it.
        axis: of three that is read, as a recording of one axis; None: all.

    Raises:
        BadInput: an entry for no column of a recording, a column that stands for two, a unit that does not fit.
    """

    entries: Mapping[str, str] = field(default_factory=dict)
    axis: str | None = None

    def __post_init__(self) -> None:
        columns: dict[str, str] = {}
        for name, entry in self.entries.items():
            if name not in _TARGETS:
                expected = f"a column of a recording{suggest(name, _TARGETS) or ': time, ' + ', '.join(signal_names())}"
                raise BadInput("--map", at=f"{name}={entry}", found=repr(name), expected=expected + _MORE)
            column, unit, _ = _parts(entry)
            if not column:
                raise BadInput("--map", at=f"{name}={entry}", found="no column", expected=f"{name}=COLUMN:UNIT{_MORE}")
            if column in columns:
                found = f"column {column!r} for {columns[column]} and for {name}"
                raise BadInput("--map", at=f"{name}={entry}", found=found, expected="each column once" + _MORE)
            columns[column] = name
            if unit is not None:
                _converted(name, unit, f"--map {name}={entry}")
        if self.axis not in (None, *AXES):
            raise BadInput("--axis", found=repr(self.axis), expected="x, y or z")

    def __bool__(self) -> bool:
        return bool(self.entries) or self.axis is not None

    @classmethod
    def of(cls, written: Sequence[str], axis: str | None = None) -> "ColumnMap":
        """The map that options say: each NAME=COLUMN:UNIT, or a file of such lines as `NAME: COLUMN:UNIT` (YAML).

        Raises:
            BadInput: see the class; a name twice, a file that is none.
        """
        entries: dict[str, str] = {}
        for option in written:
            name, equals, entry = option.partition("=")
            own = {name: entry} if equals else _read(option)
            axis = own.pop("axis", None) or axis if not equals else axis
            for key, value in own.items():
                if key in entries:
                    found = f"{key} twice: {entries[key]!r} and {value!r}"
                    raise BadInput("--map", at=key, found=found, expected="each name once" + _MORE)
                entries[key] = value
        return cls(entries, axis)

    def taken(self, headers: Sequence[str], source: str) -> list[Taken]:
        """Which columns of a file are read, and as what.

        What has no entry is read if it has the name of a column of a recording, with or without a unit; anything else
        is left out where there are entries, and kept as it is, to be refused by its name, where there are none.

        Args:
            headers: of the file.
            source: the file, for messages.

        Raises:
            BadInput: an entry's column is not there, or several; a unit that does not fit; a name twice.
        """
        found = [self._mapped(name, entry, headers, source) for name, entry in self.entries.items()]
        used = {taken.column for taken in found}
        for header in headers:
            if header in used:
                continue
            name, unit = (header, None) if header in _TARGETS else split(header)
            if name in _TARGETS and name not in self.entries:
                found.append(Taken(name, header, unit=unit))
            elif not self:
                found.append(Taken(header, header))
        for name in (names := [taken.name for taken in found]):
            if names.count(name) > 1:
                twice = " and ".join(repr(taken.column) for taken in found if taken.name == name)
                raise BadInput(
                    source, at="header", found=f"column {name!r} twice: {twice}", expected="each column once"
                )
        if self.axis is not None:
            found = _along(found, self.axis, headers, source)
        if self:  # of a mapped file, what its kind of recording has no place for is left out
            fitting = {"time", *columns_of(kind_of(taken.name for taken in found))}
            found = [taken for taken in found if taken.name in fitting or taken.column in used]
        return [taken if taken.column in used else _to_si(taken, source) for taken in found]

    def _mapped(self, name: str, entry: str, headers: Sequence[str], source: str) -> Taken:
        column, unit, sign = _parts(entry)
        if entry in headers:  # a header may begin with a minus, or hold a colon
            column, unit, sign = entry, None, 1.0
        fitting = [column] if column in headers else [header for header in headers if split(header)[0] == column]
        if len(fitting) != 1:
            found = f"{len(fitting)} columns {column!r}" if fitting else f"no column {column!r}"
            expected = f"one of {', '.join(headers)}{_MORE}"
            raise BadInput(source, at=f"--map {name}={entry}", found=found, expected=expected)
        told = split(fitting[0])[1]
        if unit is not None and told is not None and fitting[0][-1] in ")]" and in_si(unit) != in_si(told):
            found = f"unit {unit} of column {fitting[0]!r}"
            raise BadInput(
                source, at=f"--map {name}={entry}", found=found, expected=f"{told}, as its header says{_MORE}"
            )
        if unit is None:
            return _with_unit(name, fitting[0], told, source, sign)
        si, factor = _converted(name, unit, f"--map {name}={entry}")
        return Taken(name, fitting[0], sign * factor, si)


def left_out(headers: Iterable[str], taken: Iterable[Taken]) -> list[str]:
    """A note of the columns that are not read; none where all are."""
    used = {column.column for column in taken}
    unread = [header for header in headers if header not in used]
    return [f"columns left out: {', '.join(unread)}"] if unread else []


def units_of(taken: Iterable[Taken]) -> dict[str, str]:
    """The SI unit of each column of a recording whose unit is told."""
    return {column.name: column.unit for column in taken if column.unit is not None}


AS_NAMED = ColumnMap()
"""Of a file whose columns have the names of a recording's."""


def offered(name: str, unit: str | None) -> str | None:
    """The unit that a header tells, if it may be that of a column of a recording; else None."""
    found = None if unit is None else in_si(unit)
    fits = found is not None and (not _TARGETS[name] or found[0] in _TARGETS[name])
    return unit if fits else None


def _with_unit(name: str, header: str, unit: str | None, source: str, sign: float) -> Taken:
    """An entry's column whose header may tell its unit: in brackets it must fit, behind a `_` it may be of the name."""
    if unit is not None and header[-1] not in ")]" and offered(name, unit) is None:
        unit = None
    return _to_si(Taken(name, header, sign, unit), source)


def _to_si(taken: Taken, source: str) -> Taken:
    """A column with the unit that its header tells, if any, in the SI."""
    if taken.unit is None:
        return taken
    si, factor = _converted(taken.name, taken.unit, f"{source}: header, column {taken.column!r}")
    return replace(taken, factor=taken.factor * factor, unit=si)


def _converted(name: str, unit: str, source: str) -> tuple[str, float]:
    allowed = _TARGETS[name]
    found = in_si(unit)
    if found is None or (allowed and found[0] not in allowed):
        fitting = (written for si in allowed or ("m", "rad", "N", "N m", "V", "A") for written in known(si))
        raise BadInput(source, found=f"unit {unit!r}", expected=f"a unit of {name}: {', '.join(fitting)}{_MORE}")
    return found


def _parts(entry: str) -> tuple[str, str | None, float]:
    """Column, unit and sign of an entry."""
    column, colon, unit = entry.rpartition(":")
    if not colon:
        column, unit = entry, ""
    sign = -1.0 if column.startswith("-") else 1.0
    return column.removeprefix("-").strip(), unit.strip() if colon else None, sign


def _along(found: Sequence[Taken], axis: str, headers: Sequence[str], source: str) -> list[Taken]:
    """One axis of three, called as that of a recording of one axis."""
    wanted = {f"{name}_{axis}": name for name in ("position", "velocity", "force")}
    missing = [name for name, alone in wanted.items() if alone != "velocity" and name not in {t.name for t in found}]
    if missing:
        columns = f"columns {', '.join(headers)}"
        raise BadInput(source, at=f"--axis {axis}", found=columns, expected=f"also {', '.join(missing)}")
    return [replace(taken, name=wanted.get(taken.name, taken.name)) for taken in found]


def _read(path: str) -> dict[str, str]:
    """The entries of a file."""
    if not re.search(r"\.ya?ml$", path):
        raise BadInput("--map", found=repr(path), expected="NAME=COLUMN:UNIT, or a .yaml file of such lines" + _MORE)
    data = parse(read_text(path, "a mapping of columns (YAML)"), path)
    if not isinstance(data, dict) or not all(isinstance(value, str) for value in data.values()):
        raise BadInput(
            Path(path), found=type(data).__name__, expected="lines NAME: COLUMN:UNIT, as `init` writes" + _MORE
        )
    return {str(key): value for key, value in data.items()}
