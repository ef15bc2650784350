"""`mmt-drake bench`: real measurements of the quick kind, printed as the contract has them."""

import io
import json
import sys
from functools import cache
from importlib import import_module

import numpy as np
import pytest

from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof import bench
from mmt_drake.diagrams.proof.bench import accuracy, repeatability
from mmt_drake.diagrams.proof.studies.measurement import Measurement


@cache
def measured() -> list[Measurement]:
    """Of the parts that take seconds, and one that misses its target."""
    slow = Measurement("always too slow", 1.0, "x real time", 20.0, at_least=True)
    return [*accuracy.measurements(), *repeatability.measurements(), slow]


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """No other figures are measured."""
    monkeypatch.setattr(bench, "measurements", lambda group: iter(measured()))


@pytest.mark.parametrize(("part", "count"), bench.GROUPS["quick"].items())
def test_every_part_of_the_bench_measures_as_many_figures_as_are_announced(part: str, count: int) -> None:
    figures = [*import_module(f"mmt_drake.diagrams.proof.bench.{part}").measurements()]
    assert len(figures) == count and all(np.isfinite(one.value) for one in figures)


@pytest.mark.usefixtures("quick")
def test_a_terminal_shows_how_many_figures_are_left(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = io.StringIO()
    monkeypatch.setattr(screen, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", screen)
    assert main(["bench"]) == 0
    assert screen.getvalue().startswith("0 of 39 figures measured\r1 of 39 figures measured\r")


@pytest.mark.usefixtures("quick")
def test_json_is_one_document_of_figures_with_targets(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["figures"]
    assert all({"name", "value", "unit", "target", "command"} <= set(figure) for figure in figures)
    assert {figure["command"] for figure in figures} == {"mmt-drake bench"}
    # All that does not depend on the machine's speed is reached.
    assert [figure["name"] for figure in figures if figure["met"] is False] == ["always too slow"]


@pytest.mark.usefixtures("quick")
def test_text_says_what_was_missed_and_missing_is_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench"]) == 0
    out = capsys.readouterr().out
    assert "MISSED" in out and out.strip().endswith("targets missed: always too slow")


@pytest.mark.usefixtures("quick")
def test_a_figure_says_which_group_to_ask_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "diagnosis", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["figures"]
    assert {figure["command"] for figure in figures} == {"mmt-drake bench diagnosis"}


def test_a_group_there_is_none_of_is_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "slow"]) == 2
    groups = "quick or diagnosis or pacing or haptics or learning or arms or faults"
    assert capsys.readouterr().err == f"mmt-drake: bench: GROUP: found slow, expected {groups}\n"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["haptics", "--minutes", "1"], "--minutes: found bench haptics, expected bench pacing or learning"),
        (["faults", "--minutes", "1"], "--minutes: found bench faults, expected bench pacing or learning"),
        (["pacing", "--minutes", "0"], "--minutes: found 0.0, expected more than 0"),
        (["pacing", "--minutes", "inf"], "--minutes: found inf, expected more than 0"),
    ],
)
def test_minutes_are_those_of_pacing_and_learning(
    arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", *arguments]) == 2
    assert capsys.readouterr().err == f"mmt-drake: {told}\n"


def test_minutes_reach_what_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    monkeypatch.setattr(bench, "measurements", lambda group, **options: asked.append((group, options)) or [])
    assert main(["bench", "pacing", "--minutes", "10"]) == 0
    assert asked == [("pacing", {"minutes": 10.0})]
