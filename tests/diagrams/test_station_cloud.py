"""A station sees its surface through a simulated depth camera, errors included."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from mmt_drake.cloud import contact_offset
from mmt_drake.diagrams.stations.blocks import station_blocks
from mmt_drake.diagrams.stations.devices import RemoteArm
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Devices, Site
from mmt_drake.diagrams.stations.station import build_parts
from mmt_drake.diagrams.stations.table import PARTS
from mmt_drake.errors import BadInput
from mmt_drake.estimation.probe import Zero
from mmt_drake.hw.link.options import TELEROBOT
from mmt_drake.recording import Recording

NEAR = "view: {width: 160, focal: 244, height: 0.25}, rate: 20, latency: 0.03"
QUICK = ["estimator=!RlsOptions {}", "clouds=none"]
DOWN = "operator={motion: strokes, parameters: {duration: 12}}"


def seen(*changes: str, name: str = "setup1", seconds: float = 1.5) -> Recording:
    return run(load_scenario(name, [DOWN, *changes]), seconds=seconds)


def test_contact_is_detected_through_the_noise_of_a_simulated_camera() -> None:
    camera = f"environment.cloud=!SimulatedDepthCamera {{{NEAR}, smooth: {{alpha: 0.2}}}}"
    found = seen(camera)
    assert 0.2 < found["in_contact"].mean() < 1.0
    assert np.mean(found["detected_contact"] != found["in_contact"]) < 0.03
    before = found.time < 0.03
    assert (found["camera_fault"][before] == 1.0).all()
    assert (found["camera_fault"][found.time > 0.032] == 0.0).all()
    assert 0.0 < found["camera_lost"][-1] < 0.3
    other = seen(camera, "seed=1", seconds=0.05)
    assert other["camera_lost"][-1] != found["camera_lost"][len(other) - 1]  # other holes


def test_the_detector_is_given_the_offset_measured_on_the_untouched_object() -> None:
    offsets = {}
    for noise in (0.0, 2.0):
        scenario = load_scenario("setup1", [f"environment.cloud=!SimulatedDepthCamera {{{NEAR}, noise: {noise}}}"])
        surface = Site(scenario).surface
        assert surface.camera is not None and len(surface.shown) == 0
        offsets[noise] = surface.offset
        if noise == 0.0:
            assert surface.noise < 1e-4
            assert surface.offset == pytest.approx(contact_offset(scenario.detector.r2, surface.spacing), abs=3e-4)
    assert offsets[2.0] > offsets[0.0] + 2e-4


def test_a_camera_beside_a_telerobot_is_recorded_of_the_measurement_s_instant() -> None:
    found = seen(f"environment.cloud=!SimulatedDepthCamera {{{NEAR}}}", name="setup3")
    assert 0.2 < found["in_contact"].mean() < 1.0
    assert np.mean(found["detected_contact"] != found["in_contact"]) < 0.05
    late = np.argmax(found["camera_fault"] == 0.0) - 30  # ticks of the camera's latency
    assert (found["camera_fault"][: late + 30] == 1.0).all()
    assert 0 < late < 30  # as the measurement


@pytest.mark.parametrize("voxel", [0.006, 0.003])
def test_a_press_through_a_coarse_cloud_does_not_become_the_zero_of_the_force(voxel: float) -> None:
    """With points 6 mm apart the proxy comes through the surface: contact is lost, the zero of the force is not."""
    camera = f"environment.cloud=!SimulatedDepthCamera {{{NEAR}, settings: {{voxel: {voxel}}}}}"
    hand = "operator={motion: strokes, parameters: {duration: 12, depth: 0.015}}"
    found = seen(camera, hand, *QUICK, name="setup3", seconds=1.2)
    pressed = found["position_z"] < -0.004
    assert found["position_z"].min() < -0.009 and found.vector("true_force")[pressed, 2].min() > 2.0
    lost = pressed & (found["detected_contact"] == 0)
    assert (lost.sum() > 100) == (voxel == 0.006)
    zero = found["probe_zero"]
    assert (np.count_nonzero(zero == Zero.LOST) > 100) == (voxel == 0.006) and Zero.RENEWED not in zero[pressed]
    wrong = found.vector("force") - found.vector("true_force")
    assert np.abs(wrong[pressed].mean(axis=0)).max() < 0.05


def test_nothing_simulated_looks_at_a_real_object() -> None:
    scenario = load_scenario("setup3", [f"environment.cloud=!SimulatedDepthCamera {{{NEAR}}}"])
    arm = cast(RemoteArm, SimpleNamespace(system=None))
    with pytest.raises(BadInput, match="found !SimulatedDepthCamera beside an arm, expected !DepthCamera"):
        _ = Site(scenario, devices=Devices(arm=arm)).surface


def test_the_camera_is_the_telerobot_s_and_no_block_of_a_diagnosis() -> None:
    scenario = load_scenario("setup1", [f"environment.cloud=!SimulatedDepthCamera {{{NEAR}}}"])
    assert "camera" in build_parts(Site(scenario))
    assert next(part.side for part in PARTS if part.name == "camera") == TELEROBOT
    with pytest.raises(BadInput, match=r"environment\.cloud: found !SimulatedDepthCamera, expected !SurfaceCloud"):
        station_blocks(scenario)
