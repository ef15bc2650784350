"""The devices of a run are brought to rest together."""

from __future__ import annotations

from typing import cast

import pytest

from diagrams.cameras import Camera
from diagrams.devices import Devices, Hand, RemoteArm
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
