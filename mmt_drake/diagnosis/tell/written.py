"""A diagnosis on disk: `diagnosis.json`, `augmented_model.yaml`, `report.html` and its figures."""

import json
from pathlib import Path

from mmt_drake.analysis.plotting import save, write_whole
from mmt_drake.diagnosis.tell import figures
from mmt_drake.diagnosis.tell.deliver import deliver
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.pictured import pictures_of
from mmt_drake.diagnosis.tell.report import write_report
from mmt_drake.diagnosis.tell.result import Diagnosis
from mmt_drake.recording.atomic import writing

DOCUMENT = "diagnosis.json"
REPORT = "report.html"


def write_outcome(outcome: Outcome, folder: str | Path) -> list[Path]:
    """Write everything a diagnosis has to say into a folder, which is made if need be.

    Args:
        outcome: of `diagnose`.
        folder: where to write.

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
    files.append(write_report(outcome.diagnosis, evidence, folder / REPORT))
    for piece in evidence:
        if piece.models:
            name = "_".join(part for part in ("forces", Path(piece.recording).stem, piece.axis) if part)
            files.append(save(figures.overview(piece), folder / f"{name}.png"))
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
