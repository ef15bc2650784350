"""`diagnose --blocks`: of a recorded station the block that differs from what is believed is named, and no other."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from cli_samples import Program

from mmt_drake.recording import load, save

MODEL = """\
structure: flexible_box
parameters: {m: 1.0, k1: 0.0, k2: 500.0, b1: 60.0, b2: 60.0, Fc: 0.05}
normal: {k: 500.0, b: 60.0}
friction: per_axis
"""
OBJECT = ("--set", "environment.object.friction=null", "--set", "environment.object.parameters.Fc=0.05")
DELAY = ("--set", "to_telerobot.delay=0.02")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A station's recording, with a network that is 20 ms late, and the model of its object."""
    from mmt_drake.cli.main import main

    folder = tmp_path_factory.mktemp("blocks")
    target = str(folder / "out.mcap")
    assert main(["run", "setup1", "--seconds", "1.5", "--record", target, *OBJECT, *DELAY, "--json"]) == 0
    (folder / "model.yaml").write_text(MODEL)
    (folder / "softer.yaml").write_text(MODEL.replace("k2: 500.0", "k2: 450.0"))
    (folder / "tissue.yaml").write_text("structure: kelvin_voigt\nparameters: {k: 300.0, b: 20.0}\n")
    return folder


@pytest.mark.parametrize(
    ("model", "changes", "block"),
    [("model.yaml", DELAY, None), ("model.yaml", (), "to_telerobot"), ("softer.yaml", DELAY, "environment")],
)
def test_the_block_that_differs_is_named_and_no_other(
    folder: Path, program: Program, tmp_path: Path, model: str, changes: tuple[str, ...], block: str | None
):
    station = ("--blocks", "setup1", *changes)
    told = program("diagnose", folder / "out.mcap", "--model", folder / model, "--out", tmp_path, *station)
    assert told.status == 0, told.err
    replays = json.loads((tmp_path / "diagnosis.json").read_text())["replays"]
    blocks = ["to_telerobot", "environment", "detector", "estimator", "renderer"]
    assert list(dict.fromkeys(replay["block"] for replay in replays)) == blocks
    assert {replay["block"] for replay in replays if replay["differs"]} == ({block} if block else set())
    if block == "to_telerobot":
        assert next(r for r in replays if r["block"] == block)["delay_s"] == pytest.approx(0.02, abs=2e-4)
    named = f"Off by more than rounding and noise: {block.replace('_', ' ')}." if block else "at its inputs. Right"
    page = (tmp_path / "report.html").read_text()
    assert named in " ".join(told.out.split()) and named in page
    assert "Block by block" in page


def test_a_recording_of_the_contact_alone_says_what_is_missing(folder: Path, program: Program, tmp_path: Path):
    station = load(folder / "out.mcap")
    kept = {name: values for name, values in station.columns.items() if name[:-2] in ("position", "velocity", "force")}
    save(replace(station, columns=kept), tmp_path / "contact.csv")
    given = ("--model", folder / "model.yaml", "--out", tmp_path / "out", "--blocks", "setup1")
    told = program("diagnose", tmp_path / "contact.csv", *given, "--json")
    assert told.status == 0, told.err
    of = {(replay["block"], replay["output"]): replay for replay in json.loads(told.out)["replays"]}
    sent = of["to_telerobot", "position"]
    assert sent["nrmse"] is None and "master_position" in sent["note"]
    assert of["environment", "force"]["nrmse"] < 1e-6


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("out.mcap", "--model", "model.yaml", *DELAY), "--set: found no --blocks"),
        (("out.mcap", "out.mcap", "--model", "model.yaml", "--blocks", "setup1"), "--blocks: found 2 recordings"),
        (("out.mcap", "--model", "tissue.yaml", "--blocks", "setup1"), "tissue.yaml: structure: found kelvin_voigt"),
        (("out.mcap", "--model", "model.yaml", "--blocks", "setup9"), "scenario: found setup9"),
        (("out.mcap", "--model", "model.yaml", "--blocks", "setup1", "--set", "step=0.002"), "found a step of 0.001 s"),
    ],
)
def test_bad_input_ends_with_one_line_and_writes_nothing(
    arguments: tuple[str, ...], told: str, folder: Path, program: Program, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(folder)
    outcome = program("diagnose", *arguments, "--out", "nowhere")
    assert outcome.status == 2 and told in outcome.err, outcome.err
    assert outcome.err.count("\n") == 1 and not (folder / "nowhere").exists()
