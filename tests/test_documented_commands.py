"""Every command that README and docs show is one, on files that are there; all that can be run here run as pasted."""

import importlib.util
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from mmt_drake.cli.main import COMMANDS, parser

ROOT = Path(__file__).resolve().parents[1]
DOCUMENTS = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "docs").glob("tutorials/*.md")))

NOT_RUN = {
    r" --hardware| --side | --peer ": "needs devices, or a second machine; tests/cli/test_run_*.py run it on emulators",
    r" --realtime| --meshcat": "takes as long as the wall clock, and shows a page",
    r"^(experiment|trial|bench|demo)\b": "takes minutes or more; tests/cli/test_{experiment,bench,demo}.py run it",
    r" --seconds (30|50|60|3600)\b": "takes half a minute or more",
    r"^view\b": "shows a page until nobody looks; tests/cli/test_view.py runs it",
    r"\bmy\.py:": "on the page's own file, with which tests/diagrams/test_own_parts.py runs it",
    r" (10mm1Hz0A|ContPalpRAL18T1)\.npz ": "on public recordings, which need not be there",
}
"""What is only checked to be a command, and why."""
BRIEFLY = {"diagnose": ["--time-budget", "20"]}
"""What is added to a command that would search for minutes."""

BROKEN = re.compile(r"(`mmt-drake [^`\n]*)\n([^`\n]*`)")
"""A command in a sentence that goes on in the next line."""
SHOWN = re.compile(r"^(?:\S+=(?:\"[^\"]*\"|\S+) )*(?:\.venv/bin/)?mmt-drake (.*)$")
INLINE = re.compile(r"`(?:[^`]*/)?mmt-drake ([^`]+)`")
FORM = re.compile(r"(?<![\w{.:-])[A-Z]+(?![\w}=.-])|\.\.\.")  # REC, DIR: what a reader puts there


def commands_of(document: Path) -> list[list[str]]:
    """The arguments of every command that a document shows, in its order; a name alone is no command."""
    found = []
    for line in BROKEN.sub(r"\1 \2", document.read_text().replace("\\\n", " ")).splitlines():
        shown = SHOWN.match(line.strip())
        texts = [re.sub(r"\s+# .*", "", shown[1])] if shown else INLINE.findall(line)
        for text in texts:
            arguments = shlex.split(text.removesuffix(" &"), comments=True)
            alone = len(arguments) == 1 and not shown
            if arguments and arguments[0] in COMMANDS and not alone and not FORM.search(text):
                found.append(arguments)
    return found


def reason(arguments: list[str]) -> str | None:
    """Why a command is not run here."""
    text = " ".join(arguments)
    return next((why for pattern, why in NOT_RUN.items() if re.search(pattern, text)), None)


ALONE = [document for document in DOCUMENTS if document.parent.name != "tutorials"]
"""Whose commands need no more than `examples/`; tests/test_tutorials.py runs the others, in their order."""
RUN = [document for document in ALONE if any(reason(command) is None for command in commands_of(document))]


def test_the_documents_show_commands() -> None:
    assert sum(len(commands_of(document)) for document in DOCUMENTS) > 40
    assert {"README.md", "files.md"} <= {document.name for document in RUN}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda document: document.name)
def test_what_a_document_shows_parses(document: Path) -> None:
    for arguments in commands_of(document):
        parser(arguments[0]).parse_args(arguments)


@pytest.mark.parametrize("document", RUN, ids=lambda document: document.name)
def test_the_commands_of_a_document_run_as_pasted(document: Path, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    for arguments in commands_of(document):
        if reason(arguments) is None:
            command = [sys.executable, "-m", "mmt_drake", *arguments, *BRIEFLY.get(arguments[0], ())]
            done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"mmt-drake {shlex.join(arguments)}: {done.stderr}"


def test_the_model_that_readme_shows_is_the_example_s() -> None:
    shown = re.findall(r"```yaml\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert yaml.safe_load(shown[0]) == yaml.safe_load((ROOT / "examples" / "contact.yaml").read_text())


def test_the_examples_are_what_their_script_writes() -> None:
    spec = importlib.util.spec_from_file_location("examples_script", ROOT / "scripts" / "examples.py")
    assert spec is not None and spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    written = script.files()
    assert sorted(written) == sorted(path.name for path in (ROOT / "examples").iterdir())
    for name, text in written.items():
        committed = (ROOT / "examples" / name).read_text()
        lines, there = text.splitlines(), committed.splitlines()
        assert lines[0] == there[0] and len(lines) == len(there), name
        if name.endswith(".csv"):
            np.testing.assert_allclose(numbers(lines[1:]), numbers(there[1:]), atol=2e-3)  # processors round otherwise
        else:
            assert text == committed


def numbers(lines: list[str]) -> np.ndarray:
    """Of a table."""
    separator = ";" if ";" in lines[0] else ","
    return np.array([[float(cell.replace(",", ".")) for cell in line.split(separator)] for line in lines])
