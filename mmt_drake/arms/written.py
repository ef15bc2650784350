"""A diagnosis of an arm on disk: document, model, robot file and report."""

from __future__ import annotations

import json
from pathlib import Path

from mmt_drake.analysis.plotting import write_whole
from mmt_drake.arms.arm_file import ArmModel, load_arm_model, save_arm_model
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.deliver import write_urdf
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.report import write_arm_report
from mmt_drake.arms.result import ArmDiagnosis, as_json
from mmt_drake.diagnosis.tell.provenance import Provenance
from mmt_drake.recording.atomic import writing

DOCUMENT, MODEL_FILE, ROBOT, REPORT = "diagnosis.json", "augmented_model.yaml", "robot.urdf", "report.html"


def write_arm_diagnosis(
    diagnosis: ArmDiagnosis, model: ArmModel, log: JointLog, folder: str | Path, provenance: Provenance
) -> list[Path]:
    """Write all of it into a folder, which is made if need be.

    Args:
        diagnosis: what was found.
        model: that was handed in.
        log: the first of the recordings, for the figures.
        folder: where to write.
        provenance: of the report.

    Returns:
        The files, the document first; it is written last.

    Raises:
        BadInput: a file cannot be written.
    """
    folder = Path(folder)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    found = save_arm_model(diagnosis.model, folder / MODEL_FILE)
    arm = ArmPlant.of(model)
    files = [found]
    moved = diagnosis.model.links or any(ARM_EFFECTS[e.name].place == "link" for e in diagnosis.model.effects)
    if moved and model.robot.suffix == ".urdf":
        files.append(write_urdf(diagnosis.model, folder / ROBOT))
    before, after = predicted(arm, model, log), predicted(arm, load_arm_model(found), log)
    files.append(write_arm_report(diagnosis, before, after, folder / REPORT, provenance))
    document = json.dumps(as_json(diagnosis, MODEL_FILE), indent=1)
    write_whole(folder / DOCUMENT, document.encode())
    return [folder / DOCUMENT, *files]
