"""The renderer with a second model: the second one has its share of the first, and nothing to do without it."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.rendering.high_band import HighBand
from mmt_drake.rendering.status import RENDERING, WAITING
from mmt_drake.systems.fused_reflection import FusedRenderer


def rendered(stable):
    """Status and force of a hand that moves along y, which the second model has all the weight for."""
    builder = DiagramBuilder()
    renderer = builder.AddSystem(FusedRenderer())
    inputs = {
        "theta": FlexibleBoxModel().theta(),
        "stable": [stable],
        "in_contact": [1.0],
        "high_band": [2000.0, 0.0, 1.0],
        "motion": [0.0, 0.02, -0.004, 0.0, 0.0, 0.0],
    }
    for name, value in inputs.items():
        source = builder.AddSystem(ConstantVectorSource(np.asarray(value, dtype=float)))
        builder.Connect(source.get_output_port(), renderer.GetInputPort(name))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.01)
    context = renderer.GetMyContextFromRoot(simulator.get_context())
    return renderer.GetOutputPort("status").Eval(context)[0], renderer.GetOutputPort("force").Eval(context).copy()


def test_before_there_is_a_first_model_there_is_no_force_of_the_second():
    status, force = rendered(stable=0.0)
    assert status == WAITING
    np.testing.assert_array_equal(force, np.zeros(3))
    status, force = rendered(stable=1.0)
    assert status == RENDERING and abs(force[1]) > 1.0


def test_a_crossover_that_the_clock_cannot_carry_is_refused():
    with pytest.raises(BadInput, match=r"high_band\.crossover: found 600"):
        FusedRenderer(HighBand(crossover=600.0), period=1e-3)
