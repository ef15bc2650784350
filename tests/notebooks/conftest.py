"""Notebooks as the scripts that they are paired with: what they leave is there for tests to look at."""

import contextlib
import io
import runpy
import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import pytest

from mmt_drake.cloud.segment import load_open3d


@pytest.fixture(scope="session")
def run_notebook(checkout: Path) -> Callable[[str], SimpleNamespace]:
    """Runs a notebook from top to bottom, where a warning is an error; gives its variables.

    Open3D is there before: it imports Dash, which pytest parses itself, and what is collected in the midst of that must
    not raise (CPython 3.11 counts its recursions wrong then).
    """
    load_open3d()

    def run(name: str) -> SimpleNamespace:
        with warnings.catch_warnings(), mpl.rc_context(), contextlib.chdir(checkout / "notebooks"):
            warnings.simplefilter("error")
            with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(io.StringIO()) as shown:
                left = runpy.run_path(f"{name}.py")
        return SimpleNamespace(**left, stderr=said.getvalue(), stdout=shown.getvalue())

    return run
