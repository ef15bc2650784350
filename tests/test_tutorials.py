"""Tutorials run as pasted: their files are written, their commands and Python run, in the order of the page."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FILE = re.compile(r"# (\w[\w.]*\.(?:py|yaml))\n")


def test_there_are_the_five_tutorials_and_each_has_something_to_run() -> None:
    names = {"first_run", "own_recording", "own_estimator", "own_effect", "two_machines"}
    assert {page.stem for page in TUTORIALS} == names
    for page in TUTORIALS:
        blocks = BLOCK.findall(page.read_text())
        assert any(kind == "sh" for kind, _ in blocks), page.name
        assert {kind for kind, _ in blocks} <= {"sh", "python", "yaml"}, page.name
        assert all(FILE.match(text) for kind, text in blocks if kind == "yaml"), page.name


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_runs_as_pasted(page: Path, tmp_path: Path) -> None:
    if page.stem == "two_machines":
        pytest.importorskip("cryptography", reason="the extra `link` is not installed")
    folder, programs = tmp_path / "here", tmp_path / "bin"
    folder.mkdir()
    programs.mkdir()
    (folder / "examples").symlink_to(ROOT / "examples")
    program = programs / "mmt-drake"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m mmt_drake "$@"\n')
    program.chmod(0o755)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    for kind, text in BLOCK.findall(page.read_text()):
        named = FILE.match(text)
        if named:
            (folder / named[1]).write_text(text)
            continue
        command = ["sh", "-eu", "-c", text] if kind == "sh" else [sys.executable, "-c", text]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"
        assert "Traceback" not in done.stderr
    said = {"own_recording": "coulomb_friction", "own_effect": "fifth_power_stiffness"}.get(page.stem)
    assert said is None or said in (folder / "report" / "diagnosis.json").read_text()
    assert page.stem != "two_machines" or (folder / "joined.mcap").stat().st_size > 100_000
