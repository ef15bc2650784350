"""Kinds of fault, a moment or two each: what must fall falls, what goes on goes on; else it is seen."""

import importlib.util
import math
import socket
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.diagrams.proof.faults import camera, network, process, recording, viewer, worker
from mmt_drake.diagrams.proof.faults.injection import emulated_omega
from mmt_drake.diagrams.proof.faults.network import KINDS, LOST, LinkFault
from mmt_drake.diagrams.proof.faults.session import FORCE, Session
from mmt_drake.diagrams.proof.faults.wires import at_once
from mmt_drake.errors import BadInput, MissingDependency
from mmt_drake.estimation.output_error.beside import FitProcess
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.realsense.faults import STALE, WELL
from mmt_drake.systems.recorder import McapRecorder

MOMENTS = 2

if importlib.util.find_spec("cryptography") is None:
    pytest.skip("the extra `link` is not installed", allow_module_level=True)


@pytest.fixture
def omega(tmp_path_factory: pytest.TempPathFactory) -> EmulatedOmega:
    try:
        return emulated_omega(tmp_path_factory.mktemp("sdk"))
    except MissingDependency as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("name", ["forged", "lossy"])
def test_a_fault_of_the_network_is_felt_as_nothing_worse_than_silence(
    name: str, omega: EmulatedOmega, tmp_path: Path
) -> None:
    row = network.try_kind(name, KINDS[name], omega, MOMENTS, tmp_path / "a.mcap")
    assert not row.wrong, "\n".join(row.wrong)
    assert 0.0 < row.greatest_force <= FORCE * (1 + 1e-9)
    assert not KINDS[name].reasons or 0.0 < row.zero_after <= row.allowed


def test_a_peer_that_is_there_although_it_must_be_lost_would_be_seen(omega: EmulatedOmega, tmp_path: Path) -> None:
    row = network.try_kind("nothing", LinkFault(lambda draw: at_once, LOST), omega, 1, tmp_path / "a.mcap")
    assert len(row.wrong) >= 1


@pytest.mark.parametrize(
    ("name", "apart"),
    [
        ("no pixel with depth any more", False),
        ("unplugged and back", False),
        ("one frame late", False),
        ("no frames any more", True),
    ],
)
def test_without_a_surface_there_is_no_force_until_a_person_arms_again(
    name: str, apart: bool, omega: EmulatedOmega, tmp_path: Path
) -> None:
    pytest.importorskip("pyrealsense2", reason="the extra `realsense` is not installed")
    row = camera.try_kind(name, camera.KINDS[name], omega, 1, tmp_path / "a.mcap", apart=apart)
    assert not row.wrong, "\n".join(row.wrong)
    assert 0.0 < row.greatest_force <= FORCE * (1 + 1e-9) and row.unreadable < 1e-9
    assert camera.KINDS[name].fault == WELL or 0.0 < row.zero_after <= row.allowed


def test_a_surface_that_is_there_although_it_must_be_lost_would_be_seen(omega: EmulatedOmega, tmp_path: Path) -> None:
    pytest.importorskip("pyrealsense2", reason="the extra `realsense` is not installed")
    row = camera.try_kind("nothing", camera.CameraFault(lambda eye, worker: None, STALE), omega, 1, tmp_path / "a.mcap")
    assert len(row.wrong) >= 2


def test_on_a_full_disk_the_hand_goes_on_and_the_recording_is_whole_up_to_the_last_second(
    omega: EmulatedOmega, tmp_path: Path
) -> None:
    row = recording.try_full_disk(omega, MOMENTS, tmp_path / "a.mcap")
    assert not row.wrong, "\n".join(row.wrong)
    assert 0.0 < row.unreadable <= 1.0 + 2e-3


@pytest.mark.parametrize("kind", recording.HANGS)
def test_a_disk_that_hangs_holds_up_neither_the_hand_nor_the_end_of_the_run(
    kind: str, omega: EmulatedOmega, tmp_path: Path
) -> None:
    row = recording.try_hanging_disk(kind, omega, 1, tmp_path / "a.mcap")
    assert not row.wrong, "\n".join(row.wrong)
    assert (row.unreadable > 0.0) == math.isinf(recording.HANGS[kind])


def test_a_recorder_that_keeps_its_trouble_to_itself_would_be_seen(
    omega: EmulatedOmega, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def attempt(self: McapRecorder, task: Callable[[], object]) -> None:
        try:
            task()
        except BadInput as error:
            self.trouble = error

    monkeypatch.setattr(McapRecorder, "_attempt", attempt)
    row = recording.try_full_disk(omega, 1, tmp_path / "a.mcap")
    assert any("nothing was reported" in line for line in row.wrong)


def test_without_the_process_of_its_fits_the_hand_goes_on_and_it_is_told(omega: EmulatedOmega, tmp_path: Path) -> None:
    row = worker.try_dead_worker(omega, 1, tmp_path / "a.mcap")
    assert not row.wrong, "\n".join(row.wrong)


def test_fits_that_fail_are_told_and_tried_again(
    omega: EmulatedOmega, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first fit in contact fails; what follows is estimated all the same."""
    from mmt_drake.estimation.output_error.layout import Status
    from mmt_drake.recording import load

    asked, submit = [0], FitProcess.submit

    def spoiled(self: FitProcess, samples: np.ndarray, broken: bool) -> bool:
        asked[0] += 1
        return submit(self, samples[:, 1:] if asked[0] < 4 else samples, broken)

    monkeypatch.setattr(FitProcess, "submit", spoiled)
    with Session(omega, tmp_path / "a.mcap", worker=True) as session:
        session.go(900)
    status = load(tmp_path / "a.mcap")["estimator_status"]
    assert asked[0] > 4 and (status == Status.NO_FIT).any() and status[-1] != Status.NO_FIT


@pytest.mark.parametrize("kind", viewer.KINDS)
def test_a_browser_that_leaves_is_not_felt(kind: str, omega: EmulatedOmega, tmp_path: Path) -> None:
    left: list[socket.socket] = []

    def leave(browser: socket.socket) -> None:
        left.append(browser)
        viewer.KINDS[kind](browser)

    row = viewer.try_kind(kind, leave, omega, MOMENTS, tmp_path / "a.mcap")
    assert not row.wrong, "\n".join(row.wrong)
    assert len(left) == MOMENTS


def test_killed_processes_leave_no_force_and_a_recording_up_to_the_last_second(
    omega: EmulatedOmega, tmp_path: Path
) -> None:
    peer, run = process.rows(1, tmp_path)
    if any("cannot be armed" in line for line in peer.wrong):
        pytest.skip(f"the machine is too busy: {peer.wrong[0]}")
    assert not peer.wrong + run.wrong, "\n".join(peer.wrong + run.wrong)
    assert 0.0 < peer.zero_after <= peer.allowed and run.unreadable <= 1.25
