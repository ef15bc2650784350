"""A device in the hand: the velocity of its positions is what the rendered force needs, the vendor's is late."""

import importlib.util
from pathlib import Path

import pytest
from process_apart import output_of

# In a process of its own, which loads a library of its own.
PROGRAM = """
import sys
from pathlib import Path
from mmt_drake.diagrams.proof.experiments.device import cases, run_on_device
from mmt_drake.diagrams.proof.studies.study import Asked
from mmt_drake.hw.omega import operator

folder = Path(sys.argv[1])
for longest in (operator._LONGEST_READING, -1.0):  # of the latter none is short enough
    operator._LONGEST_READING = longest
    run = run_on_device("foreign", cases(Asked(folder, seconds=16.0))["foreign"], folder / "device.mcap")
    assert run.operator.startswith("emulated omega")
    print(run.metrics.stages["error_rest_true"].tangential["all"])
"""


@pytest.mark.skipif(importlib.util.find_spec("forcedimension_core") is None, reason="no extra `omega`")
def test_velocity_from_positions_halves_the_error_of_the_device_s_own(checkout: Path, tmp_path: Path) -> None:
    in_time, late = map(float, output_of(PROGRAM, checkout, str(tmp_path)).split())
    assert in_time < 0.03 and late > 2.0 * in_time, (in_time, late)
