"""What a station leaves behind in its process. Drake keeps every system with ports that was built in Python."""

from __future__ import annotations

import gc
import os
import weakref
from pathlib import Path

import pytest
from pydrake.systems.framework import LeafSystem

from mmt_drake.diagrams.scenario import load_scenario
from mmt_drake.diagrams.station import build_station


@pytest.mark.xfail(reason="Drake: a system that Python derived is never freed")
def test_a_system_with_a_port_is_freed_with_its_last_reference() -> None:
    class OnePort(LeafSystem):
        def __init__(self) -> None:
            super().__init__()
            self.DeclareVectorInputPort("u", 1)

    system = weakref.ref(OnePort())
    gc.collect()
    assert system() is None


def resident() -> float:
    """Of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def test_a_station_more_costs_little_more_than_a_megabyte() -> None:
    scenario = load_scenario("setup1", ["duration=1"])
    for _ in range(3):
        build_station(scenario).simulate(0.01)
    gc.collect()
    before = resident()
    for _ in range(20):
        build_station(scenario).simulate(0.01)
    gc.collect()
    assert (resident() - before) / 20 < 1.5
