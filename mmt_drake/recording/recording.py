"""A recording in memory: columns over one clock."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.recording.signals import AXES, Kind, kind_of

Array = NDArray[np.float64]
Points = NDArray[np.float32]
Cloud = tuple[float, Points]


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
        constants: what stood still during the recording (``mass_kg``, ``current_A`` ...), unit in the name.
    """

    time: Array
    columns: Mapping[str, Array]
    source: str = "recording"
    clouds: Sequence[Cloud] = ()
    notes: tuple[str, ...] = field(default=())
    constants: Mapping[str, float] = field(default_factory=dict)
    derived: frozenset[str] = frozenset()

    def __len__(self) -> int:
        return len(self.time)

    def __contains__(self, name: str) -> bool:
        return name in self.columns

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

    def has_vector(self, name: str) -> bool:
        """True if all of name_x, name_y, name_z are here."""
        return all(f"{name}_{axis}" in self.columns for axis in AXES)

    def vector(self, name: str) -> Array:
        """The columns name_x, name_y, name_z as (n, 3).

        Raises:
            BadInput: one of the three is missing.
        """
        return np.column_stack([self[f"{name}_{axis}"] for axis in AXES])
