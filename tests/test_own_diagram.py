"""The diagrams of docs/own_diagram.md run as pasted, and render and correct what the page says."""

import re
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[1] / "docs" / "own_diagram.md"


def test_our_systems_in_a_diagram_made_by_hand_render_the_force_that_is_felt_there_and_correct_a_cloud(
    capsys: pytest.CaptureFixture[str],
) -> None:
    block, surface, *_ = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    run: dict[str, object] = {}
    exec(compile(block, str(PAGE), "exec"), run)
    told = re.search(r"# ([\d.]+) and ([\d.]+)\n", block)
    assert told is not None and "rendered force off" in capsys.readouterr().out
    np.testing.assert_allclose(np.asarray(run["error"]), [float(told[1]), float(told[2])], atol=1e-4)
    exec(compile(surface, str(PAGE), "exec"), run)
    raised = np.asarray(run["raised"])
    assert "the cloud was moved up by" in capsys.readouterr().out and raised[0] == pytest.approx(0.001, abs=5e-5)
