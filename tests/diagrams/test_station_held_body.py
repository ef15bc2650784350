"""Where friction holds the body crosses the network beside theta, stamped by the operator's own clock."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.proof.experiments.objects import run_object
from mmt_drake.diagrams.stations.parts import stamps
from mmt_drake.diagrams.stations.renderers import DirectForce
from mmt_drake.diagrams.stations.returned import returned
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.diagrams.stations.station import build_parts
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.network.config import ChannelConfig
from mmt_drake.rendering.updates import RateLimited

HOLDING = FlexibleBoxModel(
    BoxParameters(m=2.4, k1=45.0, k2=418.0, b1=53.0, b2=35.0, Fc=1.7), NormalContact(k=418.0, b=35.0), in_plane="vector"
)


def test_only_an_estimator_that_knows_the_body_tells_it_and_only_to_a_renderer_that_has_one() -> None:
    told = load_scenario("setup1-free-running")
    assert (returned(told)["held_body"], returned(told)["model_status"]) == (7, 1)
    assert not {"held_body", "model_status"} & set(returned(load_scenario("setup1")))
    assert "held_body" not in returned(replace(told, renderer=DirectForce(), switching="telerobot"))
    away = ChannelConfig(delay=0.1)
    for scenario, stamped in ((told, True), (replace(load_scenario("setup1"), to_telerobot=away), False)):
        assert ("stamps_to_telerobot" in build_parts(Site(scenario))) == stamped


@pytest.mark.parametrize(
    "config", [ChannelConfig(delay=0.2), ChannelConfig(delay=0.12, jitter=0.04, loss=0.1, playout=0.2, seed=3)]
)
def test_a_stamp_is_the_time_at_which_what_is_received_was_sent(config: ChannelConfig) -> None:
    sent = stamps(config, 1e-3)
    simulator = Simulator(sent)
    for k in (300, 700, 1234):
        simulator.AdvanceTo((k + 0.5) * 1e-3)
        received = sent.GetOutputPort("received").Eval(simulator.get_context())[0]
        assert received == pytest.approx((k + 1) * 1e-3 - 0.2, abs=1.5e-3)


def test_an_object_that_friction_holds_is_rendered_within_a_percent_across_the_network() -> None:
    base = load_scenario("setup1-free-running")
    way, ticks = ChannelConfig(delay=0.1), 100
    scenario = replace(
        base,
        environment=replace(base.environment, object=HOLDING),
        estimator=OutputErrorOptions(in_plane="vector"),
        renderer=replace(base.renderer, updates=RateLimited(20.0)),
        to_telerobot=way,
        to_operator=way,
    )
    found = run(scenario, seconds=6.0)
    late = np.flatnonzero(found["in_contact"][ticks:] * (found.time[ticks:] > 4.5))
    assert len(late) > 800
    plant, rendered = found.vector("true_force")[late + ticks, :2], found.vector("rendered_force")[late, :2]
    assert np.linalg.norm(rendered - plant) < 0.01 * np.linalg.norm(plant)
    assert np.all(np.diff(found["held_body_stamp_y"]) >= 0.0)
    age = found.time - found["held_body_stamp_y"]
    assert age[late + ticks].min() > 0.1  # the motion was under way for so long, before the fit


def test_a_drawn_object_that_friction_holds_is_rendered_within_a_tenth_of_a_percent() -> None:
    case = run_object(20, estimator="output_error", seed=0, isotropic=True)
    assert case.error < 0.001
