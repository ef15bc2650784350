"""`join` makes one recording of two, scores it, and refuses in one line what does not belong together."""

import json
from pathlib import Path

import pytest
from cli_samples import Program
from sides_in_step import InStep

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.hw.link.options import ROLES
from mmt_drake.recording import load

pytest.importorskip("cryptography", reason="the extra `link` is not installed")


def record_both(folder: Path, seconds: float) -> None:
    """Both sides of set-up 1; the operator's clock is 70 s ahead."""
    scenario = load_scenario("setup1", ["step=0.002", "estimator=!OutputErrorOptions {}"])
    sides = InStep(scenario, folder, ahead=70 * 10**9)
    for _ in sides.ticks(0, round(seconds / scenario.step)):
        pass
    sides.close()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("joined")
    record_both(folder, 10.0)
    return folder


def test_the_joined_recording_is_scored_and_goes_on_as_any_other(program: Program, recorded: Path) -> None:
    out = recorded / "whole.mcap"
    files = [str(recorded / f"{role}.mcap") for role in ROLES]
    outcome = program("join", *files, "--out", str(out), "--json")
    assert outcome.status == 0, outcome.err
    told = json.loads(outcome.out)
    assert told["clock_offset_s"] == pytest.approx(-70.0, abs=told["clock_uncertainty_s"] + 1e-9)
    assert told["clock_uncertainty_s"] < 2e-3 and told["clock_drift"] is None
    assert told["errors"]["rendered_error"]["all"] < 0.05 and told["energy"] is not None
    joined = load(out)
    assert joined.kind == "contact" and joined.has_vector("rendered_force") and joined.has_vector("master_position")
    assert joined.made_by["scenario"] == "setup1" and joined.made_by["joined"] == ", ".join(files)
    outcome = program("join", *reversed(files), "--out", str(out))
    assert outcome.status == 0 and "behind the operator's, within" in outcome.out
    assert "rendered force: error" in outcome.out and "energy at the operator's port" in outcome.out


def test_what_cannot_be_joined_is_refused_in_one_line_and_nothing_is_left(program: Program, recorded: Path) -> None:
    operator, telerobot = (str(recorded / f"{role}.mcap") for role in ROLES)
    out = recorded / "refused.mcap"
    for arguments, told in (
        ((operator, operator), "the operator's side, as in"),
        ((operator, str(recorded / "none.mcap")), "none.mcap: found no such file"),
        ((operator, telerobot, "--out", telerobot), "which is to be joined"),
        ((operator, telerobot, "--out", str(recorded / "whole.bag")), "one that can be written"),
    ):
        outcome = program("join", *arguments, *(() if "--out" in arguments else ("--out", str(out))))
        assert outcome.status == 2 and outcome.out == "" and outcome.err.count("\n") == 1 and told in outcome.err
    assert not out.exists()


def test_one_process_s_recording_has_no_other_side(program: Program, recorded: Path) -> None:
    run = str(recorded / "one.mcap")
    assert program("run", "setup1", "--seconds", "0.2", "--record", run).status == 0
    outcome = program("join", run, str(recorded / "telerobot.mcap"))
    assert outcome.status == 2 and "found no column link_clock_own" in outcome.err


def test_the_recording_says_how_it_was_made(program: Program, tmp_path: Path) -> None:
    file, copy = tmp_path / "out.mcap", tmp_path / "copy.mcap"
    assert program("run", "setup1", "--seconds", "0.2", "--seed", "7", "--record", str(file)).status == 0
    assert program("convert", str(file), str(copy)).status == 0
    for made_by in (load(file).made_by, load(copy).made_by):
        assert made_by["scenario"] == "setup1" and made_by["seed"] == "7" and made_by["version"]
        assert made_by["command"] == f"mmt-drake run setup1 --seconds 0.2 --seed 7 --record {file}"
