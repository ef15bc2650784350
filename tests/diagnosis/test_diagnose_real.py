"""What is said of recordings of real machines, of whose physics much has no name."""

from pathlib import Path

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagrams.proof.trial.real.data_sets import CASES
from mmt_drake.model_files import parse_model


def test_dry_friction_of_a_servo_s_gears_is_named_beside_what_has_no_name(recordings: Path) -> None:
    (case,) = (case for case in CASES if case.name == "bam_servo")
    found = diagnose(case.load_fitted(recordings), parse_model(dict(case.model), case.name)).diagnosis
    assert found.verdict == "partly_explained"
    assert [(effect.family, effect.certain) for effect in found.effects] == [("dry_friction", "family")]
    assert found.fit is not None and found.fit.heldout_nrmse.augmented < 0.4 * found.fit.heldout_nrmse.refit
