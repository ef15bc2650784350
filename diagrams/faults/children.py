"""Programs of the processes that a trial kills."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.hw.link import TELEROBOT, Link, LinkOptions
from mmt_drake.hw.link.options import LinkSignal, Role
from mmt_drake.hw.link.udp import Address, UdpSocket
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.realtime import Pace
from mmt_drake.with_parent import end_with_parent

KEY = bytes(range(32))
_CONTACT = {"stable": 1.0, "in_contact": 1.0}  # what a telerobot says that touches the object of `FlexibleBoxModel`

_PERIOD = 1e-3


class Told(Protocol):
    """A number that another process reads."""

    value: float


def serve(
    listen: Address,
    peer: Address,
    signals: Mapping[Role, LinkSignal],
    agreed: str,
    returned: Mapping[str, int],
    timeout: float,
) -> None:
    """A telerobot's end of a link, while the trial lives: it touches an object that is known."""
    end_with_parent()
    link = Link(TELEROBOT, signals, KEY, UdpSocket(listen, peer), LinkOptions(timeout=timeout), scenario=agreed)
    known = {"theta": FlexibleBoxModel().theta(), **{name: np.array([value]) for name, value in _CONTACT.items()}}
    vector = np.concatenate([known.get(name, np.zeros(size)) for name, size in returned.items()])
    shown, start, tick = np.zeros(signals["operator"].size), time.monotonic(), 0
    while True:
        link.exchange(tick * _PERIOD, vector, shown)
        tick += 1
        time.sleep(max(0.0, start + tick * _PERIOD - time.monotonic()))


def record_run(record: Path, reached: Told) -> None:
    """Set-up 1 in real time, recorded, which tells how far it is."""
    end_with_parent()

    class Telling(Pace):
        def done(self, behind: float) -> None:
            super().done(behind)
            reached.value = len(self.late_s) * _PERIOD

    pace = Telling()
    build_station(load_scenario("setup1"), record=record, worker=True, pace=pace).simulate(60.0, pace=pace)
