"""A recording in memory: columns over one clock."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput, MissingDependency, check_kind
from mmt_drake.notebook import html_table
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.signals import AXES, UNITS, Kind, kind_of, signals_in

Points = NDArray[np.float32]
Cloud = tuple[float, Points]

_RATES = {"position": "velocity", "output": "output_rate"}
"""Of those whose unit is the recording's: a rate has that of its position, unless another was told."""


@dataclass(frozen=True)
class Recording:
    """Columns of one recording, all sampled at the same times.

    Column names, units and signs are those of CONVENTIONS.md ("Recordings").

    Attributes:
        time: (n,) sample times [s], strictly increasing.
        columns: name -> (n,) values, SI units, table frame. Of a long recording that was read from a file they stand on
            disk (`stored.LongColumns`): each is read when it is asked for.
        source: where it was read from; opens every error message about it.
        clouds: point clouds, each a pair of its time [s] and an (m, 3) array [m].
        notes: what the reader derived, left out or found damaged, one line each.
        derived: columns that the source does not hold but the reader has added.
        own_units: column -> SI unit, of those whose unit the file or its reader told.
        constants: what stood still during the recording (``mass_kg``, ``current_A`` ...), unit in the name.
        made_by: how it was made, in words: ``version``, ``scenario``, ``seed``, ``command`` ...; of an ``.mcap`` file
            of this project alone.
    """

    time: Array
    columns: Mapping[str, Array]
    source: str = "recording"
    clouds: Sequence[Cloud] = ()
    notes: tuple[str, ...] = field(default=())
    constants: Mapping[str, float] = field(default_factory=dict)
    derived: frozenset[str] = frozenset()
    own_units: Mapping[str, str] = field(default_factory=dict)
    made_by: Mapping[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        return f"Recording({self._told()})"

    def _told(self) -> str:
        length = self.time[-1] - self.time[0] if len(self) else 0.0
        clouds = f", {len(self.clouds)} clouds" if self.clouds else ""
        return f"{self.source}: {self.kind}, {length:g} s, {len(self)} rows of {len(self.columns)} columns{clouds}"

    def _repr_html_(self) -> str:
        rows = [(", ".join(s.columns), ", ".join(dict.fromkeys(s.units))) for s in signals_in(self.columns)]
        return html_table([self._told(), "unit"], rows)

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __iter__(self) -> NoReturn:
        """It is no list of its columns, nor of itself.

        Raises:
            TypeError: always; without it Python would ask for a column called 0.
        """
        raise TypeError("one recording, where several are expected: put it into a list, [recording]")

    def __getitem__(self, name: str) -> Array:
        """One column, (n,).

        Raises:
            BadInput: the recording has no such column.
        """
        try:
            return self.columns[name]
        except KeyError:
            found = f"columns {', '.join(self.columns)}"
            raise BadInput(self.source, found=found, expected=f"a column {name!r}") from None

    @property
    def kind(self) -> Kind:
        """``contact`` (three axes), ``single_axis``, ``driven_body``, or ``motion`` (positions without forces)."""
        return kind_of(self.columns)

    @property
    def units(self) -> dict[str, str]:
        """Column -> its unit, `time` among them; empty where there is none, or it is a driven body's own, not told."""
        rates = {rate: f"{self.own_units[name]}/s" for name, rate in _RATES.items() if name in self.own_units}
        own = {**UNITS, **rates, **self.own_units}
        return {"time": "s"} | {name: own.get(name, "") for name in self.columns}

    def to_dataframe(self) -> Any:
        """The columns as a pandas DataFrame, the time its index [s]; `attrs["units"]` has the units.

        Raises:
            MissingDependency: pandas is not installed.
        """
        try:
            pandas: Any = import_module("pandas")  # whoever asks for it has it: nothing else here needs it
        except ImportError:
            raise MissingDependency("to_dataframe: pandas is not installed: pip install pandas") from None
        frame = pandas.DataFrame(dict(self.columns), index=pandas.Index(self.time, name="time"))
        frame.attrs["units"] = self.units
        return frame

    def has_vector(self, name: str) -> bool:
        """True if all of name_x, name_y, name_z are here."""
        return all(f"{name}_{axis}" in self.columns for axis in AXES)

    def vector(self, name: str) -> Array:
        """The columns name_x, name_y, name_z as (n, 3).

        Raises:
            BadInput: one of the three is missing.
        """
        return np.column_stack([self[f"{name}_{axis}"] for axis in AXES])


def check_recordings(source: str, recordings: Iterable[Recording]) -> None:
    """Refuse whatever is no recording, as the name of its file.

    Raises:
        BadInput: there is such a thing.
    """
    for recording in recordings:
        check_kind(source, "recording", recording, Recording, "a recording: mmt_drake.load(path) reads one")
