"""What a run says of the trust in its model."""

import numpy as np

from mmt_drake.analysis.model_trust import model_trust
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.recording import Recording

TIME = np.arange(0.0, 2.0, 1e-3)


def run(status: ModelStatus, touching: float) -> Recording:
    columns = {"model_status": np.full(len(TIME), float(status)), "in_contact": np.full(len(TIME), touching)}
    return Recording(TIME, columns, "a run")


def test_a_model_is_told_to_explain_the_force_only_where_something_was_touched() -> None:
    told = {touching: model_trust(run(ModelStatus(0), touching)) for touching in (0.0, 1.0)}
    assert told[1.0] is not None and told[1.0].line() == "model: explains the force"
    assert told[0.0] is not None and told[0.0].line() == "model: not tested, there was no contact"


def test_a_misfit_is_told_with_its_time_and_begin() -> None:
    trust = model_trust(run(ModelStatus.MISFIT, 1.0))
    assert trust is not None and trust.misfit_at == 0.0
    assert "DOES NOT EXPLAIN the force in 2.00 of 2.00 s of contact, first at 0.00 s" in trust.line()
