"""`bench faults`: the table, its JSON, its exit status."""

import json
from collections.abc import Iterator

import pytest

import mmt_drake.diagrams.proof.faults.table
from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.faults.fuzz.harness import Answer, Fuzz
from mmt_drake.diagrams.proof.faults.table import WHERE, Row

ROWS = [Row("cut cable", "network", 3, 2.5, 4.0, 0.066, 0.07, 0.0), Row("pushed gently", "franka", 3)]
ENDED = Row("run killed", "process", 3, unreadable=0.9, ended=True)
WRONG = Row("disk full", "recording", 3, 3.9, 4.0, unreadable=1.0, wrong=("1: nothing was reported", "2: 9 N"))


def answer(monkeypatch: pytest.MonkeyPatch, rows: list[Row]) -> list[tuple[int, tuple[str, ...]]]:
    asked = []

    def table(moments: int, where: tuple[str, ...]) -> Iterator[Row]:
        asked.append((moments, where))
        yield from rows

    monkeypatch.setattr(mmt_drake.diagrams.proof.faults.table, "fault_table", table)
    return asked


def test_nothing_wrong_is_exit_status_0_and_50_moments_at_every_place(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = answer(monkeypatch, ROWS)
    assert main(["bench", "faults"]) == 0
    assert asked == [(50, WHERE)]
    head, cut, pushed, end = capsys.readouterr().out.splitlines()
    assert cut.split() == ["cut", "cable", "network", "3", "2.50/4", "66/70", "0.00", "0"]
    assert pushed.split() == ["pushed", "gently", "franka", "3", "–", "goes", "on", "–", "0"]
    assert head.split()[:2] == ["fault", "where"] and end == "2 kinds of fault, 6 times: nothing not as it must be"


def test_anything_wrong_is_told_line_by_line_and_is_exit_status_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answer(monkeypatch, [*ROWS, WRONG])
    assert main(["bench", "faults", "--moments", "3"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[-3:-1] == ["    1: nothing was reported", "    2: 9 N"] and lines[-1].endswith("2 not as it must be")


def test_json_has_the_rows_and_figures_with_targets(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answer(monkeypatch, [*ROWS, WRONG, ENDED])
    assert main(["bench", "faults", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [(figure["value"], figure["target"], figure["met"]) for figure in told["figures"]] == [
        (4.0, 20, False),
        (2.0, 0, False),
    ]
    assert [row["ended"] for row in told["faults"]] == [False, False, False, True]
    assert told["faults"][0]["zero_after_s"] == 0.066 and told["faults"][1]["greatest_force_n"] is None
    assert told["faults"][2]["wrong"] == ["1: nothing was reported", "2: 9 N"]


@pytest.mark.parametrize(("wrong", "status"), [("", 0), ("left behind: out.csv", 1)])
def test_strange_inputs_are_counted_by_target_and_what_is_wrong_is_told(
    wrong: str, status: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answers = [Answer(0, "convert", 2, 0.1, 0.3, ""), Answer(1, "link", 0, 30.0, 0.4, wrong)]
    monkeypatch.setattr(Fuzz, "answers", lambda self: iter(answers))
    assert main(["bench", "faults", "--fuzz", "1"]) == status
    *told, _, convert, link, end = capsys.readouterr().out.splitlines()
    assert told == [f"1 link: {wrong}"] * status
    assert convert.split() == ["convert", "1", "1", "0.10", "0"] and link.split()[:3] == ["link", "1", "0"]
    assert end == f"2 inputs, 30.0 s and 0.40 GB at most: {status or 'nothing'} not as it must be"


def test_the_supervisors_kinds_are_really_tried(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "faults", "--moments", "2", "--where", "supervisor", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["figures"][0]["value"] >= 20 and all(row["moments"] == 2 for row in told["faults"])


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["faults", "--moments", "0"], "--moments: found 0, expected 1 or more"),
        (["faults", "--where", "moon"], "--where: found moon, expected supervisor or omega"),
        (["pacing", "--moments", "3"], "--moments: found bench pacing, expected bench faults"),
        (["faults", "--fuzz", "0"], "--fuzz: found 0.0, expected more than 0 minutes"),
        (["faults", "--fuzz", "1", "--moments", "3"], "--moments: found --fuzz beside it, expected one of both"),
    ],
)
def test_options_that_make_no_sense_are_bad_input(
    arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", *arguments]) == 2
    assert told in capsys.readouterr().err
