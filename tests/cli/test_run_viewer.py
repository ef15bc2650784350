"""`run --meshcat`: the viewer is there while the run is, and a run that can do without one does."""

import json
import subprocess
import sys
import urllib.error
import urllib.request
from types import SimpleNamespace
from urllib.parse import urlsplit

import pytest
from cli_samples import Program


def test_a_hand_on_sliders_runs_in_real_time_and_its_page_ends_with_the_run() -> None:
    command = ["run", "setup1", "--operator", "sliders", "--meshcat", "--seconds", "1", "--json"]
    run = subprocess.Popen(
        [sys.executable, "-m", "mmt_drake", *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert run.stdout is not None and run.stderr is not None
    line = next(line for line in run.stderr if line.startswith("viewer: "))
    url = line.removeprefix("viewer: ").strip()
    assert url.startswith("http://127.0.0.1:")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"http://{urlsplit(url).netloc}/", timeout=10.0)
    with urllib.request.urlopen(url, timeout=10.0) as page:
        assert b"new EventSource(" in page.read()
    out, err = run.communicate()
    told = json.loads(out)
    assert err.splitlines()[-1] == "viewer: dropped what was not of its page: 1 x no token"
    assert run.returncode == 0
    assert told["operator"] == "sliders" and told["overruns"]["steps"] >= 1000
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(url, timeout=10.0)


def test_sliders_without_a_viewer_are_refused_in_one_line(program: Program) -> None:
    done = program("run", "setup1", "--operator", "sliders")
    assert done.status == 2 and done.err.count("\n") == 1
    assert "operator: found !Interactive, expected a viewer: run with --meshcat" in done.err


def nobody_listens(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mmt_drake.viewer.viewer.sys", SimpleNamespace(executable="/bin/false"))


def test_a_run_goes_on_without_a_viewer_if_none_can_be_had(program: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    nobody_listens(monkeypatch)
    done = program("run", "setup1", "--seconds", "0.2", "--meshcat", "--json")
    assert done.status == 0 and json.loads(done.out)["simulated_s"] == pytest.approx(0.2)
    assert done.err.startswith("viewer: none, the run goes on without; ")


def test_but_not_a_hand_whose_sliders_it_has(program: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    nobody_listens(monkeypatch)
    done = program("run", "setup1", "--operator", "sliders", "--meshcat")
    assert done.status == 2 and done.err.count("\n") == 1 and "expected a free port" in done.err
