"""Set-up 1, wired: repeatable, delayed to the tick, and right where the estimate is."""

import dataclasses

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from diagrams.scenario import load_scenario
from diagrams.station import build_station, load_operator
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.recording import load
from mmt_drake.simulate import simulate
from mmt_drake.systems.flexible_box import SensorNoise

EVERYTHING = "setup1-everything"


def record(path, name, *changes, seconds=None):
    station = build_station(load_scenario(name, changes), record=path)
    station.simulate(seconds)
    return load(path)


def outputs(diagram, context):
    ports = [diagram.get_output_port(i) for i in range(diagram.num_output_ports())]
    return np.concatenate([port.Eval(context) for port in ports])


def test_same_scenario_and_seed_give_bit_identical_recordings(tmp_path):
    for name in ("a.mcap", "b.mcap"):
        record(tmp_path / name, EVERYTHING, seconds=6)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_another_seed_gives_another_recording(tmp_path):
    forces = [record(tmp_path / f"{s}.mcap", EVERYTHING, f"seed={s}", seconds=3)["force_z"] for s in (1, 2)]
    assert np.abs(forces[0] - forces[1]).max() > 0.01


@pytest.mark.parametrize("name", ["setup1-delay", EVERYTHING])
def test_a_context_cloned_half_way_goes_on_with_the_same_numbers(name):
    diagram = build_station(load_scenario(name)).diagram
    simulator = Simulator(diagram)
    simulator.AdvanceTo(3.0)
    copy = Simulator(diagram, simulator.get_context().Clone())
    simulator.AdvanceTo(5.0)
    copy.AdvanceTo(5.0)
    first, second = (outputs(diagram, s.get_context()) for s in (simulator, copy))
    np.testing.assert_array_equal(first, second)
    assert np.abs(first).max() > 0


def test_one_diagram_run_twice_gives_the_same_numbers():
    diagram = build_station(load_scenario(EVERYTHING)).diagram
    results = []
    for _ in range(2):
        simulator = Simulator(diagram)
        simulator.AdvanceTo(4.0)
        results.append(outputs(diagram, simulator.get_context()))
    np.testing.assert_array_equal(*results)


def test_the_recorded_force_is_what_simulate_says_of_the_recorded_motion(tmp_path):
    recording = record(tmp_path / "out.mcap", "setup1", seconds=25)
    again = simulate(load_scenario("setup1").environment.object, recording)
    error = again.vector("force") - recording.vector("force")
    # A recording's times are whole nanoseconds, the run's are sums of rounded steps.
    assert np.sqrt(np.mean(error**2)) < 1e-6 * np.sqrt(np.mean(recording.vector("force") ** 2))
    assert recording["in_contact"].min() == 0 and recording["in_contact"].max() == 1


def test_delay_reaches_the_telerobot_and_comes_back_to_the_tick(tmp_path):
    recording = record(tmp_path / "out.mcap", "setup1-delay", "to_telerobot.delay=0.25", seconds=15)
    np.testing.assert_array_equal(recording.vector("position")[250:], recording.vector("master_position")[:-250])
    # The flag is one tick old when it leaves the detector, and 400 ms when it arrives.
    detected = recording["detected_contact"]
    rendered = np.any(recording.vector("rendered_force") != 0, axis=1)
    stable = np.flatnonzero(recording["theta_stable"])[0] + 400
    np.testing.assert_array_equal(rendered[stable + 1 :], detected[stable - 399 : -400] != 0)


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


def test_the_estimate_of_setup_1_is_near_the_truth(tmp_path):
    recording = record(tmp_path / "out.mcap", "setup1", seconds=20)
    truth = dict(zip(("m", "k2", "b1", "b2"), (1.0, 500.0, 60.0, 60.0), strict=True))
    for name, value in truth.items():
        assert recording[f"theta_{name}"][-1] == pytest.approx(value, rel=0.25), name
    assert recording["theta_normal_k"][-1] == pytest.approx(500, rel=0.05)


def test_the_detector_agrees_with_geometry_but_for_a_few_ticks(tmp_path):
    recording = record(tmp_path / "out.mcap", "setup1", seconds=25)
    assert np.mean(recording["detected_contact"] != recording["in_contact"]) < 0.002


def test_the_proxy_spring_renders_what_the_cloud_says(tmp_path):
    recording = record(tmp_path / "out.mcap", "setup1", "renderer=!ProxySpring {k: 400}", seconds=8)
    inside = recording["master_position_z"] < -1e-3
    ratio = recording["rendered_force_z"][inside] / (-400 * recording["master_position_z"][inside])
    assert np.median(ratio) == pytest.approx(1.0, abs=0.1)


def test_sensor_noise_changes_the_measurement_but_not_the_plant(tmp_path):
    scenario = load_scenario("setup1")
    noisy = dataclasses.replace(
        scenario, environment=dataclasses.replace(scenario.environment, noise=SensorNoise(0.02, 1e-5, 5e-4))
    )
    build_station(noisy, record=tmp_path / "noisy.mcap").simulate(3)
    build_station(scenario, record=tmp_path / "clean.mcap").simulate(3)
    first, second = load(tmp_path / "noisy.mcap"), load(tmp_path / "clean.mcap")
    np.testing.assert_array_equal(first.vector("true_force"), second.vector("true_force"))
    error = first.vector("force") - first.vector("true_force")
    assert error.std() == pytest.approx(0.02, rel=0.05)


def test_a_free_object_model_needs_no_friction_block():
    assert FlexibleBoxModel().theta()[5] == 0.0


def test_the_shipped_hand_is_found_and_an_unknown_one_is_refused():
    assert load_operator("builtin:hand_reaching").time[-1] > 30
    with pytest.raises(BadInput, match="builtin:hand_reaching"):
        load_operator("builtin:nobody")


def test_an_interactive_hand_needs_a_viewer():
    with pytest.raises(BadInput, match="--meshcat"):
        build_station(load_scenario("setup1", ["operator=!Interactive {}"]))
