"""A diagnosis on disk: document, augmented model, held to the error that was promised of it, report and figures."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from mmt_drake.analysis.plotting import save, write_whole
from mmt_drake.diagnosis.fit.errors import HeldOutPart
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.tell import figures
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.pictured import pictures_of
from mmt_drake.diagnosis.tell.provenance import Provenance
from mmt_drake.diagnosis.tell.report import write_report
from mmt_drake.diagnosis.tell.result import Diagnosis
from mmt_drake.errors import MmtError
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model_files import Model, load_model, model_data, save_model
from mmt_drake.recording.atomic import replacing, writing

DOCUMENT, MODEL_FILE, REPORT = "diagnosis.json", "augmented_model.yaml", "report.html"

_SAME = 1e-9  # of a held-out error that is computed again


def write_outcome(outcome: Outcome, folder: str | Path, provenance: Provenance | None = None) -> list[Path]:
    """Write everything a diagnosis has to say into a folder, which is made if need be.

    Args:
        outcome: of `diagnose`.
        folder: where to write.
        provenance: of the report; without it the recordings are told with their hashes, and that no command was typed.

    Returns:
        The files, the document first; it is written last, so that what it speaks of is there.

    Raises:
        BadInput: a file cannot be written.
        MmtError: the model read back from its file has another held-out error than the diagnosis says.
    """
    folder = Path(folder)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    files = [deliver(outcome, folder)]
    if outcome.prescription is not None:
        files.append(outcome.prescription.write(folder))
    evidence = pictures_of(outcome)
    files.append(write_report(outcome.diagnosis, evidence, folder / REPORT, provenance))
    for piece in evidence:
        if piece.models:
            name = "_".join(part for part in ("forces", Path(piece.recording).stem, piece.axis) if part)
            files.append(save(figures.overview(piece), folder / f"{name}.svg"))
    document = write_diagnosis(outcome.diagnosis, folder / DOCUMENT)
    return [document, *(file for file in files if file is not None)]


def write_diagnosis(diagnosis: Diagnosis, path: str | Path) -> Path:
    """Write `diagnosis.json` in one move; the folder is made if need be.

    Raises:
        BadInput: a number is not finite, or the file cannot be written.
    """
    path = Path(path)
    text = json.dumps(diagnosis.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
    write_whole(path, f"{text}\n".encode())
    return path


def augmented_model(fitted: Fitted) -> dict[str, Any]:
    """The model file of a fit: what `mmt_drake.model_files.parse_model` reads.

    Structural parameters have the values found, those that were left out stay 0, and what was missing is listed under
    `effects` with every parameter, those included that have a default.

    Args:
        fitted: the fit; effects that were handed in are listed first.

    Raises:
        BadInput: a nominal model with additions that no file holds, or numbers that no model can have.
    """
    hypothesis, x = fitted.hypothesis, fitted.x
    handed = hypothesis.handed(x)
    nominal, listed = handed.bare, handed.effects
    found = {"", *(name for name, _ in listed)}
    curves = (c if c.effect in found else replace(c, at=(), value=()) for c in nominal.over)  # not found: a wish still
    nominal = replace(nominal, over=tuple(curves))
    model = hypothesis.model(x)
    couples = isinstance(model, FlexibleBoxModel) and model.couples
    if isinstance(nominal, FlexibleBoxModel) and nominal.in_plane is None and couples:
        nominal = replace(nominal, in_plane="vector")  # as it was fitted
    assert isinstance(nominal, Model)  # every structure has a model file
    return model_data(nominal, listed)


def deliver(outcome: Outcome, folder: str | Path) -> Path | None:
    """Write `augmented_model.yaml`, whole or not at all, and only if it keeps what the diagnosis promised for it.

    Args:
        outcome: of a diagnosis.
        folder: where to write; it exists.

    Returns:
        The file; None where nothing was fitted, so that there is no model to deliver.

    Raises:
        BadInput: the file cannot be written.
        MmtError: read back from the file, the model has another held-out error than the diagnosis says.
    """
    fit = outcome.diagnosis.fit
    if outcome.best is None or fit is None or fit.heldout_nrmse.augmented is None:
        return None
    data = augmented_model(outcome.best)
    target = Path(folder) / MODEL_FILE
    with replacing(target) as temporary:
        save_model(temporary, data)
        model = load_model(temporary)
        for check, one in zip(outcome.prepared.preflights, (fit, *outcome.diagnosis.further_fits), strict=True):
            found = HeldOutPart(check.recording, one.heldout_s, check.smoothed, one.axes).nrmse(model)
            promised = one.heldout_nrmse.augmented
            if promised is None or abs(found - promised) > _SAME * max(1.0, promised):
                error = f"a held-out error of {found!r} on {check.recording.source}, not of {promised!r}"
                raise MmtError(f"{target}: the model read back has {error}")
    return target
