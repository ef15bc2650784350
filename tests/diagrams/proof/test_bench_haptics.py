"""The figures of the haptic path, measured in a process of their own, which loads a library of its own."""

import importlib.util
from pathlib import Path

import pytest
from process_apart import output_of

PROGRAM = """
from mmt_drake.diagrams.proof.bench import haptics
for item in haptics.measurements(seconds=1.0):
    print(item.name, item.value, sep="|")
"""


@pytest.mark.skipif(importlib.util.find_spec("forcedimension_core") is None, reason="no extra `omega`")
def test_a_reading_is_answered_in_its_own_tick_while_the_hand_is_armed(checkout: Path) -> None:
    lines = output_of(PROGRAM, checkout).splitlines()
    told = {name: float(value) for name, _, value in (line.partition("|") for line in lines)}
    for set_up in ("setup1", "setup4"):
        run = f"{set_up} on an emulated omega, 1000 ticks"
        assert told[f"{run}: armed"] > 70.0
        answer = f"{run}: reading to the force that answers it"
        assert 0.0 < told[f"{answer}, median"] < 0.5
        assert told[f"{answer}, median"] <= told[f"{answer}, 99th percentile"] <= told[f"{answer}, worst"]
        calls, tick = (
            "reading the device and setting its force",
            f"{run}, recorded: processor time of a tick, emulator included",
        )
        assert 0.0 < told[f"{calls}, median"] < told[f"{tick}, median"]
