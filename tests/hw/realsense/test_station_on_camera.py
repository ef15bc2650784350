"""A station sees its surface through a real camera: a recording of one, or librealsense's software device."""

import json
import time
from argparse import Namespace
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realsense_samples import plane_depth, record, told

from mmt_drake.cli.hardware import open_devices
from mmt_drake.cli.main import main
from mmt_drake.diagrams.stations import devices
from mmt_drake.diagrams.stations.devices import Camera
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.realsense.camera import DepthCameraSystem
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.faults import NO_FRAME, WELL
from mmt_drake.hw.realsense.stream import open_sensor
from mmt_drake.recording import Recording, load

DOWN = "{motion: strokes, parameters: {duration: 12}}"
SECONDS = 1.5


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine shows no frame for longer than any scenario may allow a camera."""
    make = partial(DepthCameraSystem, stale=60.0)
    monkeypatch.setattr(devices, "DepthCameraSystem", lambda worker, *, stale, clock: make(worker, clock=clock))


def chosen(tmp_path: Path, where: Extrinsics, **keys: Any) -> list[str]:
    """Changes of a scenario to a camera at this place, whose every pixel counts."""
    where.write(tmp_path / "camera.yaml")
    keys |= {"extrinsics": str(tmp_path / "camera.yaml"), "settings": {"voxel": None}}
    return [f"environment.cloud=!DepthCamera {json.dumps(keys)}", f"operator={DOWN}", "clouds=full"]


def run(scenario: Scenario, camera: Camera, path: Path) -> Recording:
    ends = time.monotonic() + 30.0
    while camera.worker.latest is None:
        assert camera.worker.failure is None and time.monotonic() < ends
        time.sleep(0.01)
    build_station(scenario, record=path, devices=Devices(camera=camera)).simulate(SECONDS)
    return load(path)


def test_a_recording_of_the_object_is_touched_where_the_object_is(
    software: Any, small_camera: Intrinsics, tilted: Extrinsics, tmp_path: Path
) -> None:
    images = [told(plane_depth(small_camera, tilted))] * 4
    film = record(software, tmp_path / "object.db3", images)
    scenario = load_scenario("setup1", chosen(tmp_path, tilted, recording=str(film)))
    with Camera(scenario.environment.cloud) as camera:
        seen = run(scenario, camera, tmp_path / "out.mcap")
    assert 0.2 < seen["in_contact"].mean() < 1.0
    assert np.mean(seen["detected_contact"] != seen["in_contact"]) < 0.02
    assert set(seen["camera_fault"]) == {NO_FRAME, WELL} and np.mean(seen["camera_fault"] == WELL) > 0.99
    assert seen["camera_lost"][-1] == 0.0


def test_contact_is_where_the_camera_sees_the_surface_and_not_where_the_plant_has_it(
    software: Any, small_camera: Intrinsics, tilted: Extrinsics, tmp_path: Path
) -> None:
    scenario = load_scenario("setup1", chosen(tmp_path, tilted))
    with Camera(scenario.environment.cloud, open_sensor(software.sensor, software.device)) as camera:
        software.show(told(plane_depth(small_camera, tilted, 0.004)))
        seen = run(scenario, camera, tmp_path / "out.mcap")
    first = np.argmax(seen["detected_contact"])
    assert first > 0
    assert seen["position_z"][first] == pytest.approx(0.004, abs=1e-3)
    assert not seen["in_contact"][: first + 1].any()


def test_the_command_runs_on_a_recording_beside_a_hand_and_tells_of_a_camera_that_is_not_there(
    software: Any,
    small_camera: Intrinsics,
    tilted: Extrinsics,
    omega: EmulatedOmega,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    film = record(software, tmp_path / "object.db3", [told(plane_depth(small_camera, tilted))] * 4)
    out = str(tmp_path / "out.mcap")
    given = ["run", "setup1", "--hardware", "--seconds", "1.2", "--record", out]
    given += ["--set", "operator_device.device=0", "--set"]
    assert main([*given, chosen(tmp_path, tilted, recording=str(film))[0]]) == 0
    assert np.mean(load(out)["camera_fault"] == WELL) > 0.5
    missing = chosen(tmp_path, tilted, recording=str(tmp_path / "none.db3"))[0]
    capsys.readouterr()
    assert main([*given, missing]) == 2
    assert (
        capsys.readouterr().err.splitlines()[-1].startswith(f"mmt-drake: {tmp_path / 'none.db3'}: found no such file")
    )


def test_of_two_sides_the_camera_is_the_telerobot_s_and_the_hand_the_operator_s(
    software: Any, small_camera: Intrinsics, tilted: Extrinsics, omega: EmulatedOmega, tmp_path: Path
) -> None:
    film = record(software, tmp_path / "object.db3", [told(plane_depth(small_camera, tilted))] * 4)
    changes = [*chosen(tmp_path, tilted, recording=str(film)), "operator_device.device=0"]
    scenario, opened = load_scenario("setup1", changes), {}
    for side in (None, "operator", "telerobot"):
        with ExitStack() as stack:
            devices = open_devices(stack, Namespace(hardware=True, side=side, link=[]), scenario)
            opened[side] = devices.hand is not None, devices.arm is not None, devices.camera is not None
            if devices.hand is not None:  # it lets go when the camera sees nothing any more, wherever that is
                assert devices.hand.watched["camera"] == 0.25
    assert opened == {None: (True, False, True), "operator": (True, False, False), "telerobot": (False, False, True)}


def test_a_camera_without_its_place_is_not_opened(software: Any, tmp_path: Path, tilted: Extrinsics) -> None:
    scenario = load_scenario("setup1", chosen(tmp_path, tilted))
    (tmp_path / "camera.yaml").unlink()
    stream = open_sensor(software.sensor, software.device)
    with pytest.raises(BadInput, match=r"camera\.yaml"):
        Camera(scenario.environment.cloud, stream)
    stream.close()  # closed already: does nothing
