"""Changes of a scenario do what their names say."""

import math

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.changes import (
    forgetting,
    input_held,
    input_late,
    input_placed,
    sliding,
    stiffening,
    taken_up,
    together,
    unchanged,
)
from mmt_drake.diagrams.stations.scenario import Scenario
from mmt_drake.model.structure import Friction
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import Recording
from mmt_drake.rendering.updates import Blended
from mmt_drake.replay import replayed


def test_no_change_is_none():
    assert unchanged(Scenario()) == Scenario() == together()(Scenario())


def test_changes_together_all_hold():
    changed = together(input_placed, taken_up(2.0), input_late(0.01))(Scenario())
    assert (changed.renderer.probe, changed.renderer.updates) == ("placed", Blended(2.0))
    assert changed.to_renderer == ChannelConfig(delay=0.01)


def test_a_sample_as_old_as_the_memory_counts_1_over_e():
    scenario = Scenario(step=2e-3)
    changed = forgetting(3.0)(scenario)
    assert changed.rls.forgetting ** (3.0 / scenario.step) == pytest.approx(math.exp(-1.0))


def test_a_held_input_comes_as_often_as_it_is_held():
    assert input_held(0.02)(Scenario()).to_renderer == ChannelConfig(rate_limit=50.0)


def test_an_object_that_stiffens_holds_the_same_deflection_with_a_force_that_grows():
    scenario = together(sliding(Friction.coulomb(100.0)), stiffening(0.5))(Scenario())  # a body that stays where it is
    time = 1e-3 * np.arange(2001)
    moving = time < 0.1
    columns = {name: np.zeros_like(time) for name in ("position_x", "position_y", "velocity_x", "velocity_y")}
    columns |= {"position_z": np.full_like(time, -0.01), "velocity_z": np.zeros_like(time)}
    columns["position_x"] = np.where(moving, 0.05 * time, 0.005)
    columns["velocity_x"] = np.where(moving, 0.05, 0.0)
    model = scenario.environment.object
    force = replayed(model, Recording(time, columns))["force_x"][~moving][1:]
    assert force == pytest.approx(-model.parameters.k2 * (1.0 + 0.5 * time[~moving][1:]) * 0.005)
