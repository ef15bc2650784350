"""What long work shows of itself."""

import io
import sys
import time

import pytest
from terminal import Terminal

from mmt_drake.cli.progress import progress, working
from mmt_drake.diagnosis.search.watch import Stage

SHOWN = 0.3  # [s] after which all of it has been on the screen


def shown(monkeypatch, screen: io.StringIO) -> str:
    """What a screen shows of work that tells one thing."""
    monkeypatch.setattr(sys, "stderr", screen)
    with working("work", 60.0) as show:
        show(Stage("first part", "the latest", 3, 12, ("second", "third")))
        time.sleep(SHOWN)
        show.tell("half is [known]")
        show(Stage("second part"))
        time.sleep(SHOWN)
    return screen.getvalue()


def test_on_a_terminal_a_line_that_stays_says_after_how_long_it_was_known(monkeypatch):
    assert "after 0 s: half is [known]\n" in shown(monkeypatch, Terminal())


def test_a_stage_says_how_far_it_is_and_what_is_left(monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    screen = shown(monkeypatch, Terminal())
    assert "0 of 60 s" in screen and "first part, 3 of 12: the latest (then 2 more stages at most)" in screen
    assert "second part" in screen and "3 of 12: second" not in screen


def test_a_pipe_shows_nothing(monkeypatch):
    assert shown(monkeypatch, io.StringIO()) == ""


@pytest.mark.parametrize("shown_by", [lambda: progress("work", 3.0), lambda: working("work")])
def test_what_goes_into_a_file_does_not_go_to_the_bar(monkeypatch, shown_by):
    screen, file = Terminal(), io.StringIO()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(sys, "stdout", file)
    with shown_by():
        print("a result")
    assert file.getvalue() == "a result\n" and "a result" not in screen.getvalue()
