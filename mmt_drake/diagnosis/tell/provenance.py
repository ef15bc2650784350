"""Where a report comes from: program, date, command, and the files that it speaks of, with their hashes."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import mmt_drake

SHOWN = 16
"""Digits of a hash on the first screen; the page has all of them further down."""


@dataclass(frozen=True)
class SourceFile:
    """A file that was read: its name, and its SHA-256, None where it is not a file or cannot be read any more."""

    name: str
    sha256: str | None

    @classmethod
    def of(cls, path: str | Path) -> "SourceFile":
        """The file as it is now."""
        try:
            return cls(str(path), hashlib.sha256(Path(path).read_bytes()).hexdigest())
        except OSError:
            return cls(str(path), None)

    def __str__(self) -> str:
        return f"{self.name} (no file)" if self.sha256 is None else f"{self.name}, sha256 {self.sha256[:SHOWN]}…"


def _now() -> str:
    return f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"


@dataclass(frozen=True)
class Provenance:
    """Where a report comes from.

    Attributes:
        recordings: that were diagnosed.
        model: that was handed in; None where it was no file.
        command: as it was typed; None from Python.
        version: of the program.
        date: of the report.
    """

    recordings: tuple[SourceFile, ...] = ()
    model: SourceFile | None = None
    command: str | None = None
    version: str = mmt_drake.__version__
    date: str = field(default_factory=_now)

    @classmethod
    def of(
        cls, recordings: Iterable[str | Path], model: str | Path | None = None, command: str | None = None
    ) -> "Provenance":
        """With the hashes of files; a recording that was none, or several of one file, are told once.

        Args:
            recordings: where they were read from.
            model: the file of the model handed in.
            command: that was typed.
        """
        files = tuple(SourceFile.of(path) for path in dict.fromkeys(map(str, recordings)))
        return cls(files, None if model is None else SourceFile.of(model), command)

    @property
    def facts(self) -> list[tuple[str, str]]:
        """What, and what about it."""
        model = "handed in from Python" if self.command is None else "none: fitted to the recordings first"
        return [
            ("Program", f"mmt_drake {self.version}"),
            ("Date", self.date),
            ("Command", self.command or "from Python"),
            ("Model", str(self.model or model)),
            *(
                (f"Recording{'' if number == 0 else f' {number + 1}'}", str(f))
                for number, f in enumerate(self.recordings)
            ),
        ]

    @property
    def files(self) -> list[SourceFile]:
        """All that was read."""
        return [*self.recordings, *([] if self.model is None else [self.model])]
