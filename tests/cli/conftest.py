"""The program, run inside the test's process."""

import pytest
from cli_samples import Outcome, Program

from mmt_drake.cli.main import main


@pytest.fixture
def program(capfd: pytest.CaptureFixture[str]) -> Program:
    """`mmt-drake` with some arguments."""

    def run(*arguments: object) -> Outcome:
        capfd.readouterr()
        status = main([str(argument) for argument in arguments])
        return Outcome(status, *capfd.readouterr())

    return run
