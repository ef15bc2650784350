"""The estimators there are, by the options that choose them."""

from __future__ import annotations

from typing import Any, Final

from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.learning import Learns
from mmt_drake.estimation.output_error.options import LearningOptions, OutputErrorOptions
from mmt_drake.estimation.recursive.instrumental import InstrumentalLearner
from mmt_drake.estimation.recursive.kalman import KalmanLearner
from mmt_drake.estimation.recursive.options import InstrumentalOptions, KalmanOptions

EstimatorOptions = RlsOptions | OutputErrorOptions | KalmanOptions | InstrumentalOptions
NAMES: Final[dict[type, str]] = {
    RlsOptions: "rls",
    OutputErrorOptions: "output_error",
    KalmanOptions: "kalman",
    InstrumentalOptions: "instrumental_variable",
}
"""What an estimator is called, in results and on the command line; see `mmt_drake.cli.experiment`."""
_LEARNERS: Final[dict[type, Any]] = {
    OutputErrorOptions: Learner,
    KalmanOptions: KalmanLearner,
    InstrumentalOptions: InstrumentalLearner,
}


def learner_of(options: LearningOptions) -> Learns[Any]:
    """What an estimator with these options learns with."""
    learner: Learns[Any] = _LEARNERS[type(options)](options)
    return learner
