"""How much is done at once."""

import os

import pytest

from mmt_drake.errors import BadInput
from mmt_drake.processors import processors


def test_as_many_as_the_environment_says_else_as_many_as_this_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MMT_JOBS", raising=False)
    assert processors() == len(os.sched_getaffinity(0))
    monkeypatch.setenv("MMT_JOBS", "3")
    assert processors() == 3


@pytest.mark.parametrize("asked", ["0", "-1", "two", "1.5", "²"])
def test_what_is_no_number_of_jobs_is_refused(asked: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MMT_JOBS", asked)
    with pytest.raises(BadInput, match="MMT_JOBS: found"):
        processors()
