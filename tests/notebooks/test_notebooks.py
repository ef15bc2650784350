"""The script that writes the committed notebooks, the notebook of set-up 1, and what the others are to be."""

import runpy
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from nbclient.exceptions import CellExecutionError

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.py"))


def test_the_notebook_of_setup_1_runs_without_a_word_on_stderr(run_notebook: Callable[[str], SimpleNamespace]) -> None:
    left = run_notebook("setup1")
    assert left.stderr == "" and left.stdout


def test_inside_setup_1_the_object_has_its_transfer_function_and_a_twin_that_has_it_too(
    run_notebook: Callable[[str], SimpleNamespace],
) -> None:
    left = run_notebook("setup1_inside")
    assert left.stderr == "" and left.stdout
    np.testing.assert_allclose(left.without_friction, left.exact, rtol=1e-6)
    s = 2j * np.pi * left.tested
    np.testing.assert_allclose(left.transfer_function(left.twin, s), left.exact, rtol=1e-9)
    assert left.twin.k2 == pytest.approx(0.0, abs=1e-12 * left.design.chosen.k2)


def test_set_up_4_carries_one_over_another_and_keeps_every_identity(
    run_notebook: Callable[[str], SimpleNamespace],
) -> None:
    left = run_notebook("setup4")
    assert left.stderr == "" and all(left.identities_kept.values())
    sponge = left.things["sponge"]
    assert left.carried.m == pytest.approx(sponge.object.parameters.m, rel=0.02)
    assert left.carried.centre == pytest.approx(sponge.centre, rel=0.1)
    assert left.carried.force < 0.05 and left.carried.seconds > 6.0
    assert left.run["places_1_y"][-1] > 0.1  # beside the brick


def test_every_notebook_has_tests_that_run_it() -> None:
    tests = "".join(path.read_text() for path in Path(__file__).parent.glob("test_*.py"))
    assert all(f'run_notebook("{path.stem}")' in tests for path in NOTEBOOKS)


def test_an_error_in_a_cell_is_an_error_of_the_script(tmp_path: Path) -> None:
    execute = runpy.run_path(str(ROOT / "scripts" / "execute_notebooks.py"))["execute"]
    broken = tmp_path / "broken.py"
    broken.write_text("# %%\nfine = 1\n\n# %%\nfine / 0\n")
    with pytest.raises(CellExecutionError, match="ZeroDivisionError"):
        execute(broken)


def test_committed_notebooks_are_small_enough_to_look_at_online() -> None:
    sizes = {path.stem: path.with_suffix(".ipynb").stat().st_size for path in NOTEBOOKS}
    assert not {name: size for name, size in sizes.items() if size > 1_500_000}
