"""Set-up 1, wired: repeatable, delayed to the tick, and right where the estimate is."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from mmt_drake.cloud import plane
from mmt_drake.cloud.files import write_cloud
from mmt_drake.diagrams.proof.experiments.changes import NOISE, sensing
from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.layout import Status
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import THETA
from mmt_drake.recording import Recording, load
from mmt_drake.simulation import simulate

EVERYTHING = "setup1-everything"


def record(name, *changes, seconds=None, path=None):
    return run(load_scenario(name, changes), seconds=seconds, record=path)


@pytest.fixture(scope="module")
def waiting():
    """Set-up 1 whose estimator waits after each touch, so that no sample from before it is learned from."""
    return record("setup1", "estimator.settle=0.5", seconds=25)


def outputs(diagram, context):
    ports = [diagram.get_output_port(i) for i in range(diagram.num_output_ports())]
    return np.concatenate([port.Eval(context) for port in ports])


def test_same_scenario_and_seed_give_bit_identical_recordings_and_another_seed_another(tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        record(EVERYTHING, f"seed={seed}", seconds=3, path=tmp_path / f"{name}.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    forces = [load(tmp_path / f"{name}.mcap")["force_z"] for name in "bc"]
    assert np.abs(forces[0] - forces[1]).max() > 0.01


def test_a_plant_has_the_effects_of_its_scenario():
    at = "environment.object.effects"
    stiffer = "[{name: nonlinear_stiffness, parameters: {k3: 1.0e6}}]"
    biased = "[{name: force_bias, parameters: {bias: 0.3}}]"
    plain, stiff, off = (record("setup1", f"{at}={effects}", seconds=2.5) for effects in ("[]", stiffer, biased))
    model = load_scenario("setup1", [f"{at}={stiffer}"]).environment.object
    again = simulate(model, stiff)
    for axis in "xy":
        force = f"force_{axis}"
        np.testing.assert_allclose(again[force], stiff[force], atol=1e-9)
        np.testing.assert_allclose(off[force], plain[force] + 0.3, atol=1e-12)  # what the sensor reads
        np.testing.assert_array_equal(off[f"true_{force}"], plain[f"true_{force}"])  # and what there is
    assert np.abs(stiff.vector("force") - plain.vector("force")).max() > 0.1


@pytest.mark.parametrize("name", ["setup1-delay", EVERYTHING])
def test_a_context_cloned_half_way_goes_on_with_the_same_numbers(name):
    diagram = build_station(load_scenario(name)).diagram
    simulator = Simulator(diagram)
    simulator.AdvanceTo(2.0)
    copy = Simulator(diagram, simulator.get_context().Clone())
    simulator.AdvanceTo(3.0)
    copy.AdvanceTo(3.0)
    first, second = (outputs(diagram, s.get_context()) for s in (simulator, copy))
    np.testing.assert_array_equal(first, second)
    assert np.abs(first).max() > 0


def test_the_recorded_force_is_what_simulate_says_of_the_recorded_motion(waiting):
    recording = waiting
    again = simulate(load_scenario("setup1").environment.object, recording)
    error = again.vector("force") - recording.vector("force")
    # A recording's times are whole nanoseconds, the run's are sums of rounded steps.
    assert np.sqrt(np.mean(error**2)) < 1e-6 * np.sqrt(np.mean(recording.vector("force") ** 2))
    assert recording["in_contact"].min() == 0 and recording["in_contact"].max() == 1


def test_delay_reaches_the_telerobot_and_comes_back_to_the_tick():
    recording = record("setup1-delay", "to_telerobot.delay=0.25", seconds=15)
    np.testing.assert_array_equal(recording.vector("position")[250:], recording.vector("master_position")[:-250])
    # The flag arrives 400 ms after it left the detector, from the first model that can be rendered on.
    detected = recording["detected_contact"]
    rendered = np.any(recording.vector("rendered_force") != 0, axis=1)
    first = np.flatnonzero(rendered)[0]
    assert 400 < first < 5000
    np.testing.assert_array_equal(rendered[first:], detected[first - 400 : -400] != 0)


def test_with_the_plants_parameters_rendered_equals_true_force():
    # The estimate taken out of the loop: renderer and plant are one model.
    scenario = load_scenario("setup1", ["environment.object.friction=null", "environment.object.parameters.Fc=0.3"])
    station = build_station(scenario)
    simulator = Simulator(station.diagram)
    simulator.AdvanceTo(0.3)
    context = simulator.get_mutable_context()
    renderer = station.diagram.GetSubsystemByName("renderer")
    port = renderer.GetInputPort("theta")
    port.FixValue(renderer.GetMyMutableContextFromRoot(context), scenario.environment.object.theta())
    renderer.GetInputPort("stable").FixValue(renderer.GetMyMutableContextFromRoot(context), [1.0])
    errors = []
    for t in np.arange(0.301, 4.0, 0.01):
        simulator.AdvanceTo(t)
        measurement = station.diagram.GetOutputPort("measurement").Eval(context)
        rendered = station.diagram.GetOutputPort("rendered_force").Eval(context)
        if np.any(rendered) and np.any(measurement[6:]):
            errors.append(np.abs(rendered - measurement[6:]).max())
    # Where the detector sees the touch in another tick than geometry, the renderer's spring starts that much off.
    assert len(errors) > 300 and max(errors) < 0.3


def test_the_estimate_of_setup_1_is_near_the_truth(waiting):
    recording = waiting
    truth = dict(zip(("m", "k2", "b1", "b2"), (1.0, 500.0, 60.0, 60.0), strict=True))
    for name, value in truth.items():
        assert recording[f"theta_{name}"][-1] == pytest.approx(value, rel=0.08), name
    assert recording["theta_normal_k"][-1] == pytest.approx(500, rel=0.005)


def test_the_detector_agrees_with_geometry_but_for_a_few_ticks(waiting):
    assert np.mean(waiting["detected_contact"] != waiting["in_contact"]) < 0.002


def test_the_proxy_spring_renders_what_the_cloud_says():
    recording = record("setup1", "renderer=!ProxySpring {k: 400}", seconds=8)
    depth = -recording["master_position_z"]
    pressed = depth > 1e-3
    error = recording["rendered_force_z"][pressed] - 400 * depth[pressed]
    # The foot of the proxy lies on the sampled plane; a fast stroke leaves it a few tenths of a millimetre behind.
    assert np.abs(np.median(error)) < 0.01 and np.quantile(np.abs(error), 0.95) < 400 * 0.3e-3
    assert np.all(recording["rendered_force_z"][depth < -1e-3] == 0)


def test_the_object_lies_under_a_hand_that_was_recorded_elsewhere():
    t = np.arange(6000) * 1e-3
    position = np.column_stack([0.4 + 0.02 * np.sin(7 * t), 0.02 * np.sin(9 * t) - 0.3, -0.004 * np.sin(3 * t)])
    velocity = np.column_stack([0.14 * np.cos(7 * t), 0.18 * np.cos(9 * t), -0.012 * np.cos(3 * t)])
    names = [f"{name}_{axis}" for name in ("position", "velocity") for axis in "xyz"]
    hand = Recording(t, dict(zip(names, np.hstack([position, velocity]).T, strict=True)))
    recording = run("setup1", operator=hand)
    assert np.mean(recording["detected_contact"] != recording["in_contact"]) < 0.005
    assert 0.3 < recording["in_contact"].mean() < 0.7


def test_a_surface_from_a_file_is_the_surface_that_is_touched(tmp_path):
    write_cloud(plane(30_000), tmp_path / "top.ply")
    from_file = record("setup1", f"environment.cloud={{file: {tmp_path / 'top.ply'}}}", seconds=3)
    drawn = record("setup1", seconds=3)
    np.testing.assert_array_equal(from_file["detected_contact"], drawn["detected_contact"])
    thin = build_station(
        load_scenario("setup1", [f"environment.cloud={{file: {tmp_path / 'top.ply'}, voxel: 0.01}}"])
    ).diagram.GetSubsystemByName("environment")
    cloud = thin.GetOutputPort("point_cloud").Eval(thin.CreateDefaultContext())
    assert 800 < len(cloud) < 1100


@pytest.mark.parametrize("way", ["{delay: 0.1}", "{delay: 0.06, jitter: 0.02, playout: 0.1}"])
def test_a_cloud_is_beside_the_operator_a_delay_after_it_was_seen_and_no_frame_earlier(way):
    diagram = build_station(load_scenario("setup1", ["switching=operator", f"to_operator={way}"])).diagram
    detector = diagram.GetSubsystemByName("operator_detector")
    simulator = Simulator(diagram)
    context = detector.GetMyContextFromRoot(simulator.get_context())
    simulator.AdvanceTo(0.099)
    assert len(detector.GetInputPort("point_cloud").Eval(context)) == 0
    simulator.AdvanceTo(0.1)
    assert len(detector.GetInputPort("point_cloud").Eval(context)) == 30_000


def test_sensor_noise_changes_the_measurement_but_not_the_plant():
    scenario = load_scenario("setup1")
    noisy = sensing(NOISE)(scenario)
    first, second = (run(each, seconds=3) for each in (noisy, scenario))
    np.testing.assert_array_equal(first.vector("true_force"), second.vector("true_force"))
    error = first.vector("force") - first.vector("true_force")
    assert error.std() == pytest.approx(0.02, rel=0.05)


def test_the_shipped_hand_is_found_and_an_unknown_one_is_refused():
    assert load_operator("builtin:hand_reaching").time[-1] > 30
    with pytest.raises(BadInput, match="builtin:hand_reaching"):
        load_operator("builtin:nobody")


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("operator.motion=waving", "setup1: operator: found 'waving', expected one of strokes"),
        ("renderer=!ProxySpring {k: -1}", "setup1: renderer.k: found -1.0"),
        ("estimator.cutoff_hz=400", "setup1: estimator.cutoff_hz: found 400.0"),
        ("operator=!Recorded {file: nobody.csv}", "nobody.csv: found no such file"),
    ],
)
def test_what_only_building_shows_is_told_with_its_place(change, line):
    with pytest.raises(BadInput) as error:
        build_station(load_scenario("setup1", [change, "step=0.002"]))
    assert str(error.value).startswith(line)


def test_a_scripted_hand_says_how_long_it_lasts():
    changes = ["duration=null", "operator.parameters={duration: 20}"]
    assert build_station(load_scenario("setup1", changes)).duration == 20


def test_an_interactive_hand_needs_a_viewer():
    with pytest.raises(BadInput, match="--meshcat"):
        build_station(load_scenario("setup1", ["operator=!Interactive {}"]))


def test_the_free_running_set_up_follows_the_plant_within_three_seconds():
    found = record("setup1-free-running", seconds=3)
    late = (found["in_contact"] > 0.5) & (found.time > 2.0)
    assert np.count_nonzero(late) > 500
    plant, rendered = (found.vector(name)[late] for name in ("true_force", "rendered_force"))
    assert np.linalg.norm(rendered - plant) < 0.03 * np.linalg.norm(plant)
    assert np.linalg.norm(found.vector("force")[late] - plant) > 0.001 * np.linalg.norm(plant)  # there is noise


def test_how_sure_the_estimator_is_and_what_ails_its_input_is_recorded_where_it_tells():
    limit = "estimator=!OutputErrorOptions {force_limit: 6.0}"
    found = record("setup1", limit, seconds=1.5)
    first = [found[f"theta_deviation_{name}"][0] for name in THETA]
    np.testing.assert_array_equal(first, Learner(OutputErrorOptions()).beginning().deviation)
    assert found["theta_deviation_normal_k"][-1] < 0.05 * found["theta_normal_k"][-1]
    beyond = np.flatnonzero(np.abs(found.vector("force")).max(axis=1) >= 6.0)
    told = found["estimator_status"]
    assert beyond.size
    assert (told[beyond[beyond < len(told) - 2] + 1] == Status.SATURATED).all()
    assert {Status.FREE, Status.LEARNING} & set(told[: beyond[0]])
    without = record("setup1", seconds=0.1)
    assert "theta_m" in without
    assert not {"theta_deviation_m", "estimator_status"} & set(without.columns)
