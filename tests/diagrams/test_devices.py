"""The devices of a run are brought to rest together, and with them all that is open."""

from typing import Any, cast

import pytest

from mmt_drake.diagrams.stations.devices import Camera, Hand, RemoteArm
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import Station
from mmt_drake.diagrams.stations.two_sides import Side
from mmt_drake.hw.errors import DeviceError


class Device:
    """Notes when it is closed, and may fail at it."""

    def __init__(self, name: str, closed: list[str], fails: bool = False) -> None:
        self.name, self.closed, self.fails = name, closed, fails

    def close(self, **_: object) -> None:
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


def test_a_station_or_side_whose_parts_fail_to_close_closes_all_the_others() -> None:
    closed: list[str] = []
    parts = {name: cast(Any, Device(name, closed, fails=True)) for name in ("link", "hand", "recorder")}
    told = {"scenario": cast(Any, None), "diagram": cast(Any, None), "duration": 0.0, "recorder": parts["recorder"]}
    for station in (
        Station(**told, devices=Devices(parts["hand"])),
        Side(**told, devices=Devices(parts["hand"]), link=parts["link"], wait=None),
    ):
        closed.clear()
        with pytest.raises(DeviceError, match="does not answer"), station:
            pass
        assert closed == [*(["link"] if isinstance(station, Side) else []), "hand", "recorder"]
