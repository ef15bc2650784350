"""The diagram of docs/own_diagram.md runs as pasted, and renders the force that the page says."""

import re
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[1] / "docs" / "own_diagram.md"


def test_our_systems_in_a_diagram_made_by_hand_render_the_force_that_is_felt_there(
    capsys: pytest.CaptureFixture[str],
) -> None:
    block = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)[0]
    run: dict[str, object] = {}
    exec(compile(block, str(PAGE), "exec"), run)
    told = re.search(r"# ([\d.]+) and ([\d.]+)\n", block)
    assert told is not None and "rendered force off" in capsys.readouterr().out
    np.testing.assert_allclose(run["error"], [float(told[1]), float(told[2])], atol=1e-4)
