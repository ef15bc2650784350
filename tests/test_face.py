"""What `import mmt_drake` offers refuses arguments of another kind in one line that says what to do."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mmt_drake as mmt

EXAMPLES = Path(__file__).parents[1] / "examples"
FILE, MODEL_FILE = str(EXAMPLES / "contact.csv"), str(EXAMPLES / "contact.yaml")


@pytest.mark.parametrize(
    "call",
    [
        lambda recording, model: mmt.diagnose([FILE], model),
        lambda recording, model: mmt.diagnose(FILE, model),
        lambda recording, model: mmt.fit([FILE]),
        lambda recording, model: mmt.simulate(model, FILE),
        lambda recording, model: mmt.measure(FILE),
    ],
)
def test_the_name_of_a_file_is_no_recording(call: Callable[[Any, Any], object]) -> None:
    with pytest.raises(mmt.MmtError, match=r"recording: found str .*: mmt_drake\.load\(path\) reads one"):
        call(mmt.load(FILE), mmt.load_model(MODEL_FILE))


@pytest.mark.parametrize(
    "call",
    [
        lambda recording, model: mmt.diagnose([recording], model),
        lambda recording, model: mmt.simulate(model, recording),
    ],
)
def test_the_name_of_a_file_is_no_model(call: Callable[[Any, Any], object]) -> None:
    with pytest.raises(mmt.MmtError, match=r"model: found str .*: mmt_drake\.load_model\(path\) reads one"):
        call(mmt.load(FILE), MODEL_FILE)
