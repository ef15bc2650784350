"""`run setup3 --hardware` as a lab runs it: hand, arm and depth camera, all emulated, the camera calibrated before."""

import json
import os
import threading
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest
from realsense_samples import plane_depth, record

from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.faults.patient_clock import PatientClock
from mmt_drake.diagrams.stations.devices import Hand
from mmt_drake.estimation.probe import Zero
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.realsense.__main__ import main as camera_tool
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.emulator import software_camera
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.faults import WELL
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.recording import Recording, load

BIAS = (0.4, -0.7, 1.1)  # [N] of the robot's estimate
FLOOR = 800.0  # [N/m] under what the camera sees
SECONDS = 4.0  # to be armed and press, on a machine that is late too
CAMERA = Intrinsics(320, 240, 300.0, 300.0, 159.5, 119.5)  # several pixels in each voxel
THICK = 0.08  # [m] of the object on the table


class Outcome(NamedTuple):
    """What a run told, and recorded."""

    told: dict[str, Any]
    recording: Recording


@pytest.fixture
def prepared(realsense: ModuleType, tilted: Extrinsics, tmp_path: Path, capsys: Any) -> list[str]:
    """The `--set`s of the camera: its place found on the bare table, the detector's offset on the object."""
    noise, place = DepthNoise.stereo(CAMERA.fx, subpixel=0.02), tmp_path / "camera.yaml"
    software = software_camera(CAMERA)
    films = {}
    for name, height in (("table", -THICK), ("object", 0.0)):
        depth = plane_depth(CAMERA, tilted, height).astype(np.float32)
        images = [noise.apply(depth, CAMERA, k) for k in range(12)]
        films[name] = str(record(software, tmp_path / f"{name}.db3", images))
    foot = [str(value) for value in tilted.position[:2]]
    given = ["--object-height", str(THICK), "--heading", "20", "--foot", *foot, "--out", str(place)]
    assert camera_tool(["calibrate", "--recording", films["table"], *given]) == 0
    given = ["--extrinsics", str(place), "--out", str(tmp_path / "top.ply"), "--frames", "2"]
    assert camera_tool(["cloud", "--recording", films["object"], *given]) == 0
    said = capsys.readouterr().out
    assert " mm apart" not in said, "dense enough for the detector"
    offset = said.split("surface_offset=")[1].split()[0]
    # A busy machine takes its time to begin a recording anew: frames would count as stopped.
    keys = {"extrinsics": str(place), "recording": films["object"], "stale": 1.0}
    return [f"environment.cloud=!DepthCamera {json.dumps(keys)}", f"detector.surface_offset={offset}"]


@pytest.fixture
def outcome(
    prepared: list[str],
    omega: EmulatedOmega,
    franka: EmulatedFranka,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Any,
) -> Outcome:
    """A person arms hand and arm, presses on the object and slides on it until the end."""
    omega.set(real_time=1.0, soft_start=0.5, target_z=-0.03, hand_stiffness=1500.0, hand_damping=30.0)
    omega.set(swing_y=0.015, swing_hz=0.7)
    x, y, z = franka.get()["position"]
    franka.set(bias=BIAS, wall_height=z - 0.02, wall_stiffness=FLOOR)
    changes = [
        *prepared,
        "operator_device.device=0",
        # What a busy machine would stop: pauses of the program.
        "operator_device.watchdog=null",
        "operator_device.limits.force=3.0",
        "step=0.002",
        f"telerobot_device.address={franka.address}",
        "telerobot_device.realtime=ignore",
        f"telerobot_device.table={[x, y, z - 0.02]}",
        "telerobot_device.gap=0.4",
        "telerobot_device.hold_after=0.1",
        "telerobot_device.compensation={}",  # the emulated arm holds no probe
    ]
    monkeypatch.setitem(Hand.__init__.__kwdefaults__, "supervisor_clock", PatientClock())
    line = ["run", "setup3", "--hardware", "--loosened-limits", "--json", "--seconds", str(SECONDS)]
    line += ["--record", str(tmp_path / "out.mcap")]
    reading, writing = os.pipe()
    ended = threading.Event()

    def arm() -> None:
        # Until the run has begun it may compile for minutes.
        while not franka.get()["moving"] and not ended.wait(0.2):
            os.write(writing, b"a\n")

    person = threading.Thread(target=arm)
    with os.fdopen(reading) as source, os.fdopen(writing, "wb"):
        monkeypatch.setattr("sys.stdin", source)
        person.start()
        try:
            status = main([*line, *(part for change in changes for part in ("--set", change))])
        finally:
            ended.set()
            person.join()
    said = capsys.readouterr()
    assert status == 0, said.err
    return Outcome(json.loads(said.out), load(tmp_path / "out.mcap"))


def test_contact_is_seen_by_the_camera_and_the_force_is_the_floor_s_without_the_robot_s_bias(outcome: Outcome) -> None:
    told, seen = outcome
    assert np.mean(seen["camera_fault"] == WELL) > 0.9, "a recording that is played over and over has no gaps"
    assert 0.0 < seen["camera_lost"][-1] < 0.2 and len(seen.clouds) > 0
    assert told["arm"]["followed_steps"] > 50 and told["arm"]["stops"] == {}
    depth = -seen["position_z"]
    wrong = (seen["detected_contact"] == 1) != (depth > 0.0)
    assert (depth > 0.003).sum() > 50 and np.abs(depth[wrong]).max(initial=0.0) < 0.002
    assert told["zero"]["renewed_s"] > 0.0
    zero = seen["probe_zero"]
    assert Zero.RENEWED in zero[depth < -0.003] and Zero.RENEWED not in zero[depth > 0.0]
    pressed = depth > 0.002
    np.testing.assert_allclose(seen["force_z"][pressed], FLOOR * depth[pressed], atol=0.6)
    assert np.abs(seen.vector("force")[pressed, :2]).max() < 0.05
    assert 0.5 < np.linalg.norm(seen.vector("applied_force"), axis=1).max() <= 3.0 * (1 + 1e-9)
