"""Set-up 3 in simulation: what holds the probe, what it measures, and how the station is wired about it."""

import numpy as np
import pytest

from mmt_drake.diagrams.stations.arm import missing_arm
from mmt_drake.diagrams.stations.blocks import station_blocks
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.diagrams.stations.telerobots import CompliantTip, Panda
from mmt_drake.errors import BadInput, MissingDependency
from mmt_drake.recording import Recording

FEW_POINTS = "environment.cloud.points=4000"
LIGHT = [FEW_POINTS, "clouds=none"]


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Set-up 3 as shipped, but for fewer points."""
    return run(load_scenario("setup3", LIGHT), seconds=9.0)


def test_set_up_3_is_the_thesis_s_object_under_an_arm() -> None:
    scenario = load_scenario("setup3")
    assert scenario.environment.object.parameters.m == 0.459
    held, device = scenario.telerobot, scenario.telerobot_device
    assert isinstance(held, CompliantTip)
    assert held.impedance == device.impedance and held.compensation == device.compensation
    assert isinstance(load_scenario("setup3", ["telerobot=!Panda {probe_mass: 0.2}"]).telerobot, Panda)
    assert load_scenario("setup1").telerobot is None


def test_the_measured_force_is_the_plant_s_without_offset_weight_and_inertia_of_the_probe(recording: Recording) -> None:
    wrong = recording.vector("force") - recording.vector("true_force")
    told = recording.time > 1.5  # the offset is known
    touched = told & (recording["in_contact"] == 1)
    assert touched.sum() > 4000 and np.abs(recording.vector("true_force")[touched]).max() > 2.0
    assert np.abs(wrong[told].mean(axis=0)).max() < 0.02  # of offsets of 0.4 to 1.1 N, and 0.15 N of weight
    assert wrong[told].std(axis=0).max() < 0.04  # the sensor's 0.02, and what the velocity's noise makes of inertia


def test_the_force_felt_is_the_one_measured_although_the_arm_yields(recording: Recording) -> None:
    assert load_scenario("setup3").renderer.arm is not None
    contact = recording["in_contact"] == 1
    known = contact & (np.cumsum(contact) > 1000)  # after a second of it
    depth, reached = (-recording[name][known].mean() for name in ("master_position_z", "position_z"))
    assert depth > 1.4 * reached > 0.002  # so much too strong it would be with the probe at the hand
    felt, true = recording["rendered_force_z"][known], recording["true_force_z"][known]
    assert felt.mean() == pytest.approx(true.mean(), rel=0.01)
    assert np.linalg.norm(felt - true) < 0.05 * np.linalg.norm(true)


def test_a_row_belongs_to_one_instant_although_the_measurement_is_late(recording: Recording) -> None:
    """F_com = K (x_m - x_s) + D (v_m - v_s) of the row's own motions, to the tick: sensors without noise show it."""
    quiet = run(load_scenario("setup3", [*LIGHT, "telerobot.sensor.noise={}"]), seconds=2.0)
    gains = CompliantTip().impedance
    away, slower = (quiet.vector(f"master_{part}") - quiet.vector(part) for part in ("position", "velocity"))
    told = quiet.vector("command_force")[20:]
    assert np.abs(told).max() > 3.0
    np.testing.assert_allclose((gains.stiffness * away + gains.damping * slower)[20:], told, atol=1e-9)
    assert np.mean(recording["detected_contact"] != recording["in_contact"]) < 0.002


def test_the_tip_is_held_back_by_what_it_meets(recording: Recording) -> None:
    """Pressed at rest the arm's 1500 N/m and the object's 800 share the way."""
    still = np.flatnonzero(np.abs(recording["master_velocity_z"]) < 1e-3)
    still = still[recording["master_position_z"][still] < -0.003]
    assert len(still) > 50
    ratio = recording["position_z"][still] / recording["master_position_z"][still]
    assert np.median(ratio) == pytest.approx(1500.0 / 2300.0, abs=0.01)


def test_touch_is_felt_at_once_although_the_measurement_is_late(recording: Recording) -> None:
    rendered = recording.vector("rendered_force").any(axis=1)
    touched = np.flatnonzero(np.diff(recording["detected_contact"]) > 0)
    assert len(touched) >= 1 and rendered.any()
    assert np.count_nonzero(rendered != (recording["detected_contact"] == 1)) <= 2 * len(touched)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("environment.noise.force=0.1", r"environment\.noise: found .*, expected telerobot\.sensor\.noise"),
        ("telerobot.compensation.step=0.01", r"telerobot\.compensation\.step: found 0\.01, expected the scenario's"),
        ("telerobot_device.compensation.step=0.01", r"telerobot_device\.compensation\.step: found 0\.01"),
        ("telerobot.probe_mass=5", r"telerobot\.probe_mass: found 5"),
        ("telerobot=!Kuka {}", "telerobot: found !Kuka, expected one of !CompliantTip, !Panda"),
    ],
)
def test_what_does_not_fit_a_telerobot_is_refused(change: str, told: str) -> None:
    with pytest.raises(BadInput, match=told):
        load_scenario("setup3", [change])


def test_a_whole_arm_takes_the_place_of_its_tip_or_says_what_is_missing() -> None:
    scenario = load_scenario("setup3", [*LIGHT, "telerobot=!Panda {}"])
    if missing_arm() is not None:
        with pytest.raises(MissingDependency, match="example-robot-data not found; install"):
            build_station(scenario)
        return
    arm = run(scenario, seconds=2.0)
    # Along the strokes a Panda that holds its orientation there is (J M^-1 J')^-1 = 3.95 kg at its tip.
    tip = run(load_scenario("setup3", [*LIGHT, "telerobot.mass=3.95"]), seconds=2.0)
    np.testing.assert_allclose(arm.vector("position"), tip.vector("position"), atol=3e-3)


def test_blocks_of_set_up_1_are_not_those_of_set_up_3() -> None:
    with pytest.raises(BadInput, match=r"telerobot: found !CompliantTip, expected none"):
        station_blocks(load_scenario("setup3"))
