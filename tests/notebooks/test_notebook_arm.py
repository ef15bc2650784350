"""The notebook on arms: ten cells at most, the friction of the example, and a plant that comes to rest."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import jupytext
import numpy as np
import pytest


def test_the_notebook_on_arms_finds_the_example_s_friction(
    run_notebook: Callable[[str], SimpleNamespace], checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = run_notebook("arm")
    assert left.stderr == "" and left.found.verdict == "missing_physics"
    told = {
        (effect.where, symbol): number.value
        for effect in left.found.effects
        for symbol, number in effect.numbers.items()
    }
    concealed = {
        ("base", "Fc"): 2.4,
        ("shoulder", "Fc"): 3.1,
        ("elbow", "Fc"): 1.2,
        ("base", "b"): 0.9,
        ("shoulder", "b"): 1.6,
    }
    assert told == {key: pytest.approx(value, rel=0.03) for key, value in concealed.items()}
    monkeypatch.chdir(checkout / "notebooks")  # its robot's file is named from there
    (_, free), (_, rubbing) = left.swing(left.believed), left.swing(left.found.model)
    assert np.ptp(free[-50:]) > 5.0 * np.ptp(rubbing[-50:])


def test_the_notebook_on_arms_has_ten_cells_at_most(checkout: Path) -> None:
    assert len(jupytext.read(checkout / "notebooks" / "arm.py").cells) <= 10
