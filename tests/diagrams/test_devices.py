"""The devices of a run are brought to rest together, and with them all that is open."""

from __future__ import annotations

from typing import Any, cast

import pytest

from diagrams.cameras import Camera
from diagrams.devices import Devices, Hand, RemoteArm
from diagrams.scenario import Scenario
from diagrams.two_sides import Side
from hw.errors import DeviceError


class Device:
    """Notes when it is closed, and may fail at it."""

    def __init__(self, name: str, closed: list[str], fails: bool = False) -> None:
        self.name, self.closed, self.fails = name, closed, fails

    def close(self) -> None:
        self.closed.append(self.name)
        if self.fails:
            raise DeviceError(f"{self.name} does not answer")


@pytest.mark.parametrize("failing", ["hand", "arm", None])
def test_the_hand_comes_first_and_one_that_fails_leaves_none_running(failing: str | None) -> None:
    closed: list[str] = []
    hand, arm, camera = (Device(name, closed, name == failing) for name in ("hand", "arm", "camera"))
    devices = Devices(cast(Hand, hand), cast(RemoteArm, arm), cast(Camera, camera))
    if failing is None:
        devices.close()
    else:
        with pytest.raises(DeviceError, match=f"{failing} does not answer"):
            devices.close()
    assert closed == ["hand", "arm", "camera"]


@pytest.mark.parametrize("failing", ["link", "hand"])
def test_what_fails_at_the_end_of_a_run_leaves_neither_a_device_nor_a_recording_open(failing: str) -> None:
    closed: list[str] = []
    hand, link, recorder = (Device(name, closed, name == failing) for name in ("hand", "link", "recorder"))
    devices = Devices(cast(Hand, hand))
    side = Side(Scenario(), cast(Any, None), 1.0, cast(Any, recorder), devices, cast(Any, link), None)
    with pytest.raises(DeviceError, match=f"{failing} does not answer"), side:
        pass
    assert closed == ["link", "hand", "recorder"]
