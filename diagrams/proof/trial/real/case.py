"""A case on a public data set, and how its recordings are read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mmt_drake.diagrams.proof.trial.real.preparation import between
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load_all
from mmt_drake.recording.npz_file import arrays_of
from mmt_drake.recording.public import find, read_public


@dataclass(frozen=True)
class Published:
    """The best figure that is known for a held-out test, in the unit of the case, and who reports it."""

    value: float
    source: str


@dataclass(frozen=True)
class RealPart:
    """One recording of a data set, or a stretch of it.

    Attributes:
        file: its name in the data set's folder.
        number: which of the file's recordings, from 0.
        seconds: (from, to) of the stretch by the recording's clock [s], the end not included; None is all of it.
        prepared: makes what is diagnosed out of what was recorded (before the stretch is cut out), or None.
        columns: column -> array of the file, where others are read than the data set's declaration says; else None.
    """

    file: str
    number: int = 0
    seconds: tuple[float, float] | None = None
    prepared: Callable[[Recording], Recording] | None = None
    columns: Mapping[str, str] | None = None

    def load(self, folder: Path) -> Recording:
        """The recording, read by the project's own reader.

        Raises:
            BadInput: no such file, fewer recordings in it, too little in the stretch, or what the reader refuses.
        """
        path = folder / self.file
        recordings = load_all(path) if self.columns is None else self._otherwise(path, self.columns)
        if self.number >= len(recordings):
            raise BadInput(path, found=f"{len(recordings)} recordings", expected=f"at least {self.number + 1}")
        recording = recordings[self.number]
        if self.prepared is not None:
            recording = self.prepared(recording)
        return recording if self.seconds is None else between(recording, *self.seconds)

    def _otherwise(self, path: Path, columns: Mapping[str, str]) -> list[Recording]:
        arrays, notes = arrays_of(path), tuple(f"{name}: {array}" for name, array in columns.items())
        return read_public(replace(find(arrays, str(path)), columns=columns, notes=notes), arrays, str(path))


@dataclass(frozen=True)
class HeldOut:
    """Recordings that no model was fitted to.

    Attributes:
        name: what they test.
        parts: their errors are put together, every sample counting once.
        published: best known figure; None where nobody reports one.
    """

    name: str
    parts: tuple[RealPart, ...]
    published: Published | None = None


@dataclass(frozen=True, kw_only=True)
class RealCase:
    """A data set, the model that is handed in, and what it is tested on.

    Attributes:
        name: of the case: the folder of the data set, and where it has several cases something behind a stroke.
        fitted: what the diagnosis sees.
        held_out: what it does not see; none where there is no other recording of the same system.
        model: the nominal model, as a model file's mapping.
        concealed: the physics that is known, or said in the literature, to be missing from it; for the reader.
        families: of laws that are right to name for it; none where nothing is missing.
        unit: of the errors that are reported: the recording's own, or a thousandth of it (`mm`).
        simple: held-out error of a simple fit of the right law to `fitted`, over the standard deviation, as stated
            beside the recordings; None where none is.
    """

    name: str
    fitted: tuple[RealPart, ...]
    held_out: tuple[HeldOut, ...] = ()
    model: Mapping[str, Any]
    concealed: str
    families: tuple[str, ...]
    unit: str
    simple: float | None = None

    @property
    def folder(self) -> str:
        """Of the data set; a case that shares it with others has a name of its own behind it."""
        return self.name.partition("/")[0]

    @property
    def per_si(self) -> float:
        """Errors in `unit` per error in the recording's own unit."""
        return 1e3 if len(self.unit) > 1 and self.unit[0] == "m" else 1.0

    def path(self, directory: str | Path) -> Path:
        """The data set's folder under `directory`.

        Raises:
            BadInput: there is none.
        """
        folder = Path(directory) / self.folder
        if not folder.is_dir():
            raise BadInput(directory, at=self.folder, found="no such folder", expected=f"the recordings of {self.name}")
        return folder

    def load_fitted(self, directory: str | Path) -> list[Recording]:
        """The recordings that the diagnosis sees; raises as `path` and `RealPart.load`."""
        folder = self.path(directory)
        return [part.load(folder) for part in self.fitted]

    def load_held_out(self, directory: str | Path) -> dict[str, list[Recording]]:
        """Name of a test -> its recordings; raises as `path` and `RealPart.load`."""
        folder = self.path(directory)
        return {test.name: [part.load(folder) for part in test.parts] for test in self.held_out}
