"""Comparisons: a play-out buffer is as good as a constant delay, updates make no energy, peers are what they are."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mmt_drake.analysis.hand import settling
from mmt_drake.analysis.passivity import passivity, returnable
from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.comparisons import COMPARISONS, peers
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.renderers import DirectForce, ImpedanceReflection
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.motion.along_axis import holding_since
from mmt_drake.motion.yielding import HandImpedance
from mmt_drake.network.config import ChannelConfig
from mmt_drake.recording import load
from mmt_drake.rendering.passivity import PassivityControl
from mmt_drake.rendering.updates import AtOnce, EnergyPermitting


@pytest.fixture(scope="module")
def network(tmp_path_factory):
    """The cases, what they say, and their report."""
    comparison, asked = COMPARISONS["network"], Asked(tmp_path_factory.mktemp("network"), seconds=9.0)
    cases = comparison.run(asked)
    return SimpleNamespace(cases=cases, judgement=comparison.judge(cases), report=comparison.report(asked, cases))


def test_a_playout_buffer_is_as_good_as_the_constant_delay_it_states(network):
    figures = network.judgement.figures["playout_200ms"]
    assert abs(figures["more_error"]) < 0.01
    for jumps in ("rendered_jumps", "plant_jumps"):
        assert figures[jumps]["ratio"] < 0.05
    assert network.judgement.figures["newest_wins"]["more_error"] > 0.1


def test_the_document_is_plain_and_the_page_shows_every_case(network, tmp_path):
    document = json.loads(json.dumps(network.report.document))
    assert document["experiment"] == "network" and document["operator"] == "strokes"
    assert [case["name"] for case in document["cases"]] == list(network.cases)
    assert document["cases"][-1]["plant_jumps"]["ratio"] is not None
    told = {(each["case"], each["figure"]): each for each in document["figures_to_reach"]}
    assert {case for case, _ in told} == {"newest_wins", "playout_200ms"}
    costs = told["playout_200ms", "error less that at the constant delay"]
    assert (costs["thesis_says"], costs["to_reach"], costs["verdict"]) == ("not tried", 0.01, "reached")
    assert costs["value"] == document["cases"][-1]["more_error"]
    assert told["newest_wins", "largest jump of the rendered force"]["verdict"] == "missed"
    page = network.report.write(tmp_path).read_text()
    assert all(name in page for name in network.cases)


def headings(page):
    lines = page.splitlines()
    return [lines[0], *(line for line, below in pairwise(lines) if below.startswith("| ---"))]


def test_the_page_of_figures_in_docs_has_the_columns_that_the_study_gives(network):
    page = Path(__file__).parents[3] / "docs" / "figures" / "network.md"
    assert headings(page.read_text()) == headings(network.report.markdown("mmt-drake experiment network"))


@pytest.mark.parametrize("name", COMPARISONS)
def test_the_cases_of_a_comparison_share_motion_seed_and_noise_and_can_be_built(name):
    scenarios = COMPARISONS[name].cases(Asked(Path(), seed=7, seconds=5.0))
    assert len(scenarios) > 3
    assert all(scenario.seed == 7 and scenario.duration == 5.0 for scenario in scenarios.values())
    assert len({str(scenario.operator) for scenario in scenarios.values()}) <= len(scenarios) // 3
    noises = {scenario.environment.noise for scenario in scenarios.values()}
    assert noises == {load_scenario("setup1-free-running").environment.noise} == {NOISE}
    built = build_station(list(scenarios.values())[-1])
    built.simulate(0.01)


def ran(delay=0.2, seconds=19.0, **changes):
    """A run of set-up 1 over 200 ms each way that strokes for 6 s and then means to hold still."""
    motion = Scripted("stroke_and_hold", {"duration": 20.0, "stroking": 6.0})
    base = load_scenario("setup1", ["estimator.settle=0.5", "clouds=none"])
    way = ChannelConfig(delay=delay)
    return run(replace(base, operator=motion, duration=seconds, to_telerobot=way, to_operator=way, **changes))


def test_with_a_hand_that_yields_the_model_is_stable_where_direct_feedback_is_not():
    hand = HandImpedance()
    model = ran(hand=hand, switching="operator", renderer=ImpedanceReflection(updates=EnergyPermitting()))
    direct = ran(hand=hand, renderer=DirectForce())
    controlled = ran(hand=hand, renderer=DirectForce(passivity=PassivityControl()))
    since = holding_since(6.0)
    assert settling(model, since, 19.0).stable and settling(controlled, since, 19.0).stable
    assert settling(direct, since, 19.0).holding > 0.05
    assert passivity(model).operator.passive and returnable(model).holds
    assert passivity(direct).operator.violation > 1.0
    assert passivity(controlled).between.min() > -0.02  # the network makes next to no energy
    # Pressed into the object the hand yields: 5 mm deep were meant.
    hand_share = 200.0 / (200.0 + 500.0)
    assert model["master_position_z"][-1] == pytest.approx(-0.005 * hand_share, rel=0.02)


def test_over_a_round_trip_of_5_s_the_model_comes_to_rest_and_could_never_give_back_more_than_was_put_in():
    found = ran(
        delay=2.5,
        hand=HandImpedance(),
        switching="operator",
        estimator=OutputErrorOptions(),
        renderer=ImpedanceReflection(updates=EnergyPermitting()),
    )
    assert settling(found, holding_since(6.0), 19.0).stable
    assert passivity(found).operator.passive
    assert returnable(found).holds and returnable(found).put_in > 0.1
    assert np.abs(found["rendered_force_z"][-1]) > 0.5  # it does render


def test_direct_feedback_is_the_measured_force_a_way_late():
    recording = ran(seconds=6.0, renderer=DirectForce())
    np.testing.assert_array_equal(recording.vector("rendered_force")[200:], recording.vector("force")[:-200])


def test_a_late_flag_makes_energy_unless_energy_permits():
    free, kept = (
        ran(seconds=10.0, renderer=ImpedanceReflection(updates=way)) for way in (AtOnce(), EnergyPermitting())
    )
    assert not returnable(free).holds and returnable(free).least < -1e-3
    assert returnable(kept).least > -1e-6


def test_errors_are_told_against_the_force_without_noise_and_with_the_policy_of_updates(network):
    table = network.judgement.tables[0]
    for (name, case), row in zip(network.cases.items(), table.rows, strict=True):
        error = case.metrics.rendered_error_true.tangential["all"]
        assert list(row[:3]) == [name, "rate_limited", pytest.approx(100.0 * error)]
        assert error != case.metrics.rendered_error.tangential["all"]


def test_a_hand_of_its_own_is_not_said_to_hold_still(network):
    case = network.cases["constant_120ms"]
    run = load(case.recording)
    long = replace(run, time=10.0 * run.time)  # as if it went on for as long as the scripted motion
    assert peers._settling(replace(case, operator="stroke_and_hold"), long) is not None
    assert peers._settling(replace(case, operator="hand.csv"), long) is None


@pytest.mark.parametrize("name", ["estimators", "bands"])
def test_where_the_cases_differ_in_their_motion_no_other_takes_their_place(name, tmp_path):
    asked = Asked(tmp_path / "none", operator="builtin:hand_reaching", seconds=5.0)
    with pytest.raises(BadInput, match=f"experiment {name}: found --operator"):
        COMPARISONS[name].run(asked)
    assert not (tmp_path / "none").exists()
