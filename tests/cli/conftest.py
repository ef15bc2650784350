"""The program, run inside the test's process, and what it is to diagnose."""

from pathlib import Path

import pytest
from cli_samples import Outcome, Program
from diagnose_samples import BASE, MODEL

from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.session import ContactSession
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
    session = ContactSession(seed=3, noise=0.015, duration=15.0)
    save(session.record(BASE, (Concealed("coulomb_friction", {"Fc": 0.4}),)), folder / "contact.csv")
    (folder / "model.yaml").write_text(MODEL.replace("k2: 450.0, b1: 20.0", "k2: 430.0, b1: 21.0"))
    return folder
