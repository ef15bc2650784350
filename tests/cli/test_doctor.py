"""`doctor` tells what is there from what is missing, on a machine made of files."""

import dataclasses
import importlib.metadata
import json
from collections.abc import Iterable
from pathlib import Path

import pytest

from mmt_drake.cli import doctor as subject
from mmt_drake.cli import main as cli
from mmt_drake.cli.machine import Check, Machine, devices, graphics, real_time


def write(root: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text + "\n")


def named(checks: Iterable[Check], name: str) -> Check:
    (found,) = [check for check in checks if check.name == name]
    return found


def machine(root: Path, **environ: str) -> Machine:
    return Machine(root, {"HOME": str(root / "home"), **environ})


def test_a_whole_report_is_json_and_every_gap_says_what_to_do() -> None:
    checks = subject.doctor()
    document = json.loads(json.dumps([dataclasses.asdict(check) for check in checks]))
    assert {entry["status"] for entry in document} <= {"ok", "gap", "optional"}
    assert all(bool(entry["advice"]) == (entry["status"] != "ok") for entry in document)
    assert list(dict.fromkeys(entry["group"] for entry in document)) == [
        "packages",
        "hardware SDKs",
        "devices",
        "network",
        "real time",
        "graphics",
        "storage",
    ]


def test_the_command_prints_json_alone_and_its_exit_status_is_0(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["doctor", "--json"]) == 0
    assert {entry["group"] for entry in json.loads(capsys.readouterr().out)} >= {"packages", "real time"}
    assert cli.main(["doctor"]) == 0
    assert "lateness of a 1 ms sleep" in capsys.readouterr().out


def test_every_direct_dependency_is_listed_with_the_version_installed() -> None:
    checks = list(subject.packages())
    for name in ("drake", "numpy", "numba", "open3d", "rosbags", "mcap"):
        assert named(checks, name).found.startswith(importlib.metadata.version(name))
    assert "pytest" not in {check.name for check in checks}, "tools of developers are none of a user's business"


def test_another_version_than_the_pinned_one_is_a_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subject, "_pins", lambda: {"numpy": "0.0.1"})
    check = named(subject.packages(), "numpy")
    assert check.status == "gap"
    assert check.found == f"{importlib.metadata.version('numpy')}; tested with 0.0.1"


def test_the_vendor_library_is_found_where_fdsdk_points(tmp_path: Path) -> None:
    assert named(subject.hardware_sdks(machine(tmp_path)), "Force Dimension SDK").status == "optional"
    write(tmp_path, {"sdk/lib/release/lin/libdrd.so.3.17.1": ""})
    check = named(subject.hardware_sdks(machine(tmp_path, FDSDK=str(tmp_path / "sdk"))), "Force Dimension SDK")
    assert check.status == "ok"
    assert check.found.endswith("libdrd.so.3.17.1")


def test_devices_on_usb_are_known_by_vendor_and_product(tmp_path: Path) -> None:
    write(
        tmp_path,
        {
            "sys/bus/usb/devices/1-1/idVendor": "1451",
            "sys/bus/usb/devices/1-1/product": "omega.7",
            "sys/bus/usb/devices/1-1/busnum": "1",
            "sys/bus/usb/devices/1-1/devnum": "4",
            "dev/bus/usb/001/004": "",
            "sys/bus/usb/devices/2-1/idVendor": "8086",
            "sys/bus/usb/devices/2-1/product": "Bluetooth",
        },
    )
    checks = list(devices(machine(tmp_path)))
    haptic = named(checks, "Force Dimension device")
    assert (haptic.status, haptic.found) == ("ok", f"omega.7 at {tmp_path}/dev/bus/usb/001/004")
    assert named(checks, "RealSense camera").status == "optional", "not everything of that vendor is a camera"


def test_a_device_without_permission_is_a_gap(tmp_path: Path) -> None:
    write(tmp_path, {"sys/bus/usb/devices/1-1/idVendor": "1451"})  # and no node in dev/ that could be opened
    check = named(devices(machine(tmp_path)), "Force Dimension device")
    assert check.status == "gap"
    assert "udev" in check.advice


def test_a_cable_counts_and_wireless_does_not(tmp_path: Path) -> None:
    write(tmp_path, {"sys/class/net/wlan0/operstate": "up", "sys/class/net/wlan0/wireless/x": ""})
    write(tmp_path, {"sys/class/net/lo/operstate": "up", "sys/class/net/eth1/operstate": "down"})
    assert named(devices(machine(tmp_path)), "wired network").status == "optional"
    write(tmp_path, {"sys/class/net/eth0/operstate": "up"})
    assert named(devices(machine(tmp_path)), "wired network").found == "eth0"


@pytest.mark.parametrize(
    ("files", "name", "status"),
    [
        ({"proc/version": "Linux 6.1 SMP PREEMPT_DYNAMIC"}, "kernel", "optional"),
        ({"proc/version": "Linux 6.1 SMP PREEMPT_RT"}, "kernel", "ok"),
        ({"sys/kernel/realtime": "1"}, "kernel", "ok"),
        ({"sys/devices/system/cpu/cpu0/cpufreq/scaling_governor": "performance"}, "CPU governor", "ok"),
        ({"sys/devices/system/cpu/cpu1/cpufreq/scaling_governor": "powersave"}, "CPU governor", "optional"),
        ({"sys/devices/system/clocksource/clocksource0/current_clocksource": "hpet"}, "clock source", "gap"),
        ({"sys/devices/system/clocksource/clocksource0/current_clocksource": "tsc"}, "clock source", "ok"),
        ({}, "clock source", "optional"),
        ({"proc/self/timerslack_ns": "50000"}, "timer slack", "optional"),
        ({"proc/self/timerslack_ns": "1"}, "timer slack", "ok"),
        ({"sys/devices/system/cpu/cpu0/cpuidle/state3/latency": "170"}, "idle states", "optional"),
        ({"sys/devices/system/cpu/cpu0/cpuidle/state1/latency": "2"}, "idle states", "ok"),
        ({}, "idle states", "ok"),
        ({"sys/devices/system/cpu/isolated": "3"}, "processor set apart", "ok"),
        ({"sys/devices/system/cpu/isolated": ""}, "processor set apart", "optional"),
        ({"proc/loadavg": "0.01 0.1 0.2 1/200 4242"}, "load", "ok"),
        ({"proc/loadavg": "9999.0 5.0 5.0 9/200 4242"}, "load", "optional"),
    ],
)
def test_real_time_readiness_is_read_from_the_kernel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: dict[str, str], name: str, status: str
) -> None:
    monkeypatch.setattr("mmt_drake.cli.machine._sleep_lateness", lambda: [1.0, 2.0])
    write(tmp_path, files)
    assert named(real_time(machine(tmp_path)), name).status == status


def test_a_driver_that_kills_its_process_is_reported_not_fatal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mmt_drake.cli.machine._EGL_PROBE", "import os; os.kill(os.getpid(), 11)")
    (check,) = graphics()
    assert (check.status, check.found) == ("gap", "killed by signal 11")


def test_a_folder_of_recordings_that_is_not_there_is_a_gap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subject, "PACKAGE", tmp_path / "checkout" / "mmt_drake")

    def status(**environ: str) -> str:
        return named(subject.storage(machine(tmp_path, **environ)), "public recordings").status

    assert status() == "optional"
    (tmp_path / "shared" / "recordings").mkdir(parents=True)
    assert status() == "ok", "beside the checkout"
    assert status(MMT_RECORDINGS=str(tmp_path)) == "ok"
    assert status(MMT_RECORDINGS=str(tmp_path / "nowhere")) == "gap"


def test_the_printed_report_shows_each_check_and_its_advice(capsys: pytest.CaptureFixture[str]) -> None:
    checks = [Check("a group", "a thing", "gap", "[not] there", "do this"), Check("a group", "other", "ok", "1.0")]
    subject.print_checks(checks)
    text = capsys.readouterr().out
    assert all(piece in text for piece in ("a group", "a thing", "[not] there", "do this", "other", "1.0", "1 to mend"))
