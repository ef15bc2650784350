"""The program, run inside the test's process, and what it is to diagnose."""

from pathlib import Path

import pytest
from cli_samples import Outcome, Program
from trial_samples import BOX_MODEL, COULOMB, recorded

from mmt_drake.cli.main import main
from mmt_drake.recording import save


@pytest.fixture
def program(capfd: pytest.CaptureFixture[str]) -> Program:
    """`mmt-drake` with some arguments."""

    def run(*arguments: object) -> Outcome:
        capfd.readouterr()
        status = main([str(argument) for argument in arguments])
        return Outcome(status, *capfd.readouterr())

    return run


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with concealed Coulomb friction, and the model that knows of none."""
    folder = tmp_path_factory.mktemp("diagnose")
    save(recorded(COULOMB, seed=3, seconds=15.0), folder / "contact.csv")
    (folder / "model.yaml").write_text(BOX_MODEL.replace("k2: 450.0, b1: 20.0", "k2: 430.0, b1: 21.0"))
    return folder
