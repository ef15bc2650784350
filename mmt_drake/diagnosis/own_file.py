"""A look at a file of one's own: what its columns may be, in which unit and sign, and a model of the size that fits."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Final

import numpy as np
import yaml

from mmt_drake.diagnosis.checks.preflight import preflight
from mmt_drake.diagnosis.fit.rough import rough_model
from mmt_drake.errors import BadInput
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model_files import Model, model_data, save_model
from mmt_drake.recording import Recording, load_all
from mmt_drake.recording.atomic import replacing
from mmt_drake.recording.column_map import AS_NAMED, ColumnMap
from mmt_drake.recording.csv_file import headers_of
from mmt_drake.recording.files import ending_of
from mmt_drake.recording.foreign_table import entry, guessed
from mmt_drake.recording.npz_file import names_of

_NO_UNIT: Final = {"time": ("s", "ms", "us", "ns"), "position": ("m", "mm", "um")}
"""Units that are tried where the file tells none, until the numbers are plausible."""
_MAY_DRIVE = (
    "Is the force not felt but does it drive the body, as a motor does? Call it `input`, and the position `output`."
)
_MEANINGS: Final[Mapping[str, str]] = {
    "flexible_box": """\
A body of mass m [kg] on a table, which the probe pushes through a contact spring.
k1 [N/m], b1 [N s/m]: spring and damper from the body to the table; Fc [N]: dry friction there.
k2 [N/m], b2 [N s/m]: contact spring and damper between probe and body.
normal: k [N/m], b [N s/m]: the contact along the axis that points up.""",
    "kelvin_voigt": """\
A spring and a damper between the probe and the world: F = F0 - k (x - x0) - b v.
k [N/m], b [N s/m]; x0 [m]: where the spring rests; F0 [N]: force there.""",
    "driven_body": """\
A body that an input drives: m x'' = gain input + offset - b x' - k x - Fc sgn x'.
m [kg], b [N s/m], k [N/m], Fc and offset [N], gain: force per unit of the input; only ratios of these show.""",
}


@dataclass(frozen=True)
class OwnFile:
    """What a look at a file gives.

    Attributes:
        source: the file.
        columns: what its columns may be; empty where they have the names of a recording's.
        headers: of all of them.
        remarks: what was assumed, or could not be told, a line each.
        recording: as it reads so; None where it does not.
        model: of the size that this suggests; None where there is no recording, or nothing to tell it from.
    """

    source: Path
    columns: ColumnMap
    headers: tuple[str, ...]
    remarks: tuple[str, ...] = ()
    recording: Recording | None = None
    model: Model | None = None

    def write_map(self, path: Path) -> None:
        """Write the mapping, for `--map`; what is left to be filled in as comments.

        Raises:
            BadInput: it cannot be written.
        """
        lines = [
            f"# What the columns of {self.source.name} are, for --map {path.name}. NAME: COLUMN:UNIT, a - before the"
        ]
        lines += ["# column for the other sign; force is the one on the probe. Look through it:"]
        lines += [f"# {remark}" for remark in self.remarks]
        known = self.columns.entries
        lines += [yaml.safe_dump({name: known[name]}, allow_unicode=True).strip() for name in known]
        if self.recording is None:
            names = ("time", "position", "force") if "input" not in known else ("time", "input", "output")
            missing = [name for name in names if name not in known and f"{name}_x" not in known]
            lines += [f"# {name}: COLUMN:UNIT" for name in missing]
            lines += ["# Of three axes: position_x, _y, _z and force_x, _y, _z."] if "position" in missing else []
        read = {value.lstrip("-") for value in known.values()}
        unread = [h for h in self.headers if not any(value == h or value.startswith(f"{h}:") for value in read)]
        lines += [f"# not read: {', '.join(unread)}"] if unread else []
        with replacing(path) as temporary:
            temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def write_model(self, path: Path) -> None:
        """Write the model file, with what its numbers mean.

        Raises:
            BadInput: it cannot be written, or there is no model.
        """
        if self.model is None:
            raise BadInput(self.source, found="no model", expected="a recording that suggests one")
        data = model_data(self.model)
        numbers = {symbol: float(f"{value:.3g}") for symbol, value in data["parameters"].items()}
        head = f"Numbers of the size that {self.source.name} suggests, no more; `mmt-drake fit` finds the right ones.\n"
        save_model(path, data | {"parameters": numbers}, head + _MEANINGS[self.model.NAME])


def look(path: str | Path) -> OwnFile:
    """Look at a file.

    Its columns are known by their names or guessed by them and their units; units by the header, or else by what is
    plausible; the sign of forces by what an object that takes work would answer.

    Raises:
        BadInput: no such file, or one that no mapping can make a recording of.
    """
    path = Path(path)
    headers = _headers(path)
    try:
        return _with_model(OwnFile(path, AS_NAMED, headers), load_all(path)[0])
    except BadInput:
        if not headers:
            raise
    named = guessed(headers)
    entries = {name: entry(name, header) for name, header in named.items()}
    silent = [name for name in entries if ":" not in entries[name]]
    open_units = [name for name in silent if _kind(name) in _NO_UNIT]
    kinds = list(dict.fromkeys(_kind(name) for name in open_units))
    refusal: BadInput | None = None
    for units in product(*(_NO_UNIT[kind] for kind in kinds)):
        tried = dict(zip(kinds, units, strict=True))
        columns = ColumnMap(
            {name: f"{e}:{tried[_kind(name)]}" if name in open_units else e for name, e in entries.items()}
        )
        try:
            recording = load_all(path, columns=columns)[0]
        except BadInput as error:
            refusal = refusal or error
            continue
        said = f"The file tells no unit of {', '.join(silent)}: SI, or what is plausible, is assumed."
        return _with_sign(OwnFile(path, columns, headers, (said,) if silent else ()), recording)
    why = str(refusal) if named else "no column is known by its name or unit"
    return OwnFile(path, ColumnMap(entries), headers, (f"It does not read as a recording so: {why}",))


def _kind(name: str) -> str:
    return name.partition("_")[0]


def _headers(path: Path) -> tuple[str, ...]:
    """Of a file that may be anybody's; of other forms none."""
    ending = ending_of(path)
    return headers_of(path) if ending == ".csv" else names_of(path) if ending == ".npz" else ()


def _with_sign(found: OwnFile, recording: Recording) -> OwnFile:
    """With the sign of forces (of a driven body's input) that the recording asks for, and the model."""
    if not _reversed(recording):
        return _with_model(found, recording)
    turned = {n: f"-{e}" if _kind(n) in ("force", "input") else e for n, e in found.columns.entries.items()}
    other = load_all(found.source, columns=ColumnMap(turned))[0]
    if _reversed(other):
        return _with_model(_saying(found, "The sign of forces looks wrong either way."), recording)
    said = "As recorded, forces have the sign of those on the object: turned round, to those on the probe."
    if recording.kind == "driven_body":
        said = "As recorded, the output goes against the input: the input is turned round."
    return _with_model(_saying(replace(found, columns=ColumnMap(turned)), said), other)


def _saying(found: OwnFile, remark: str) -> OwnFile:
    return replace(found, remarks=(*found.remarks, remark))


def _reversed(recording: Recording) -> bool:
    try:
        found = preflight(recording, rough_model(recording)).findings
    except BadInput:  # too short, or still: nothing to tell it by
        return False
    return any(finding.code == "swapped_sign" for finding in found)


def _with_model(found: OwnFile, recording: Recording) -> OwnFile:
    found = replace(found, recording=recording)
    try:
        model = rough_model(recording)
    except BadInput as error:
        return _saying(found, f"No model: {error}")
    length = recording.time[-1] - recording.time[0]
    rate = 1.0 / float(np.median(np.diff(recording.time)))
    kind = recording.kind.replace("_", " ")
    said = f"So it reads as a {kind} recording of {length:.1f} s at {rate:.4g} Hz, of a {model.NAME}."
    found = _saying(replace(found, model=model), said)
    return _saying(found, _MAY_DRIVE) if isinstance(model, KelvinVoigt) else found
