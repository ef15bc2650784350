"""The recursive estimators as systems: the same numbers as over a recording."""

from __future__ import annotations

import numpy as np
import pytest
from estimated_contact import OUTPUTS, STEP, TICKS, contact
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.estimation.kinds import learner_of
from mmt_drake.estimation.output_error.offline import learned_along
from mmt_drake.estimation.recursive.options import InstrumentalOptions, KalmanOptions
from mmt_drake.systems.instrumental_estimator import InstrumentalEstimator
from mmt_drake.systems.kalman_estimator import KalmanEstimator

SYSTEMS = {
    KalmanEstimator: KalmanOptions(step=STEP),
    InstrumentalEstimator: InstrumentalOptions(step=STEP),
}


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_output_is_the_offline_estimate_of_the_samples_so_far_bit_for_bit(system: type[LeafSystem]) -> None:
    data, flag = contact()
    trace = learned_along(learner_of(SYSTEMS[system]), data, flag)
    builder = DiagramBuilder()
    estimator = builder.AddSystem(system(SYSTEMS[system]))
    times = (np.arange(TICKS) - 0.5) * STEP  # a sample holds around its tick, clear of rounding in time
    for name, values in (("measurement", data), ("in_contact", flag[:, None])):
        source = builder.AddSystem(TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, values.T)))
        builder.Connect(source.get_output_port(), estimator.GetInputPort(name))
    simulator = Simulator(builder.Build())
    own = estimator.GetMyContextFromRoot(simulator.get_context())
    for k in (200, 700, TICKS - 2):
        simulator.AdvanceTo((k + 0.5) * STEP)
        for name in OUTPUTS:
            expected = np.atleast_1d(getattr(trace, name)[k])
            np.testing.assert_array_equal(estimator.GetOutputPort(name).Eval(own), expected, err_msg=name)
