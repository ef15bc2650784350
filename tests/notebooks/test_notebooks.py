"""Notebooks run from top to bottom in a fresh kernel, by the script that writes the committed ones."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path

import nbformat
import pytest
from nbclient.exceptions import CellExecutionError

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.py"))

execute: Callable[[Path], nbformat.NotebookNode] = runpy.run_path(str(ROOT / "scripts" / "execute_notebooks.py"))[
    "execute"
]


@pytest.mark.parametrize("source", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_a_notebook_runs_without_error_or_warning_and_shows_figures(source: Path) -> None:
    outputs = [output for cell in execute(source).cells if cell.cell_type == "code" for output in cell.outputs]
    assert not [output.text for output in outputs if output.get("name") == "stderr"]
    assert any("image/png" in output.get("data", {}) for output in outputs)


def test_the_setup1_notebook_is_among_them() -> None:
    assert ROOT / "notebooks" / "setup1.py" in NOTEBOOKS


def test_an_error_in_a_cell_is_an_error_of_the_script(tmp_path: Path) -> None:
    broken = tmp_path / "broken.py"
    broken.write_text("# %%\nfine = 1\n\n# %%\nfine / 0\n")
    with pytest.raises(CellExecutionError, match="ZeroDivisionError"):
        execute(broken)


def test_committed_notebooks_are_small_enough_to_look_at_online() -> None:
    sizes = {path.stem: path.with_suffix(".ipynb").stat().st_size for path in NOTEBOOKS}
    assert not {name: size for name, size in sizes.items() if size > 1_500_000}
