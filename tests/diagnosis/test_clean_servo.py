"""A servo that nothing holds and that lacks nothing: over short windows chance is as large as what is looked for."""

import numpy as np

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagrams.proof.experiments.first_models import KINDS, drawn_recording
from mmt_drake.model.driven_model import DrivenBodyModel


def test_a_right_model_of_a_body_that_drifts_lacks_nothing():
    recording, true = drawn_recording(np.random.default_rng((0, 16, KINDS.index("servo"))), "servo")
    outcome = diagnose([recording], DrivenBodyModel(**true))
    assert outcome.prepared.window_s is not None
    assert (outcome.diagnosis.verdict, outcome.diagnosis.effects) == ("no_mismatch", ())
