"""What long work shows of itself."""

import io
import sys

from mmt_drake.cli.progress import working


class Terminal(io.StringIO):
    """A screen that keeps what was written."""

    def isatty(self) -> bool:
        return True


def shown(monkeypatch, screen: io.StringIO) -> str:
    """What a screen shows of work that tells one thing."""
    monkeypatch.setattr(sys, "stderr", screen)
    with working("work") as show:
        show("first part")
        show.tell("half is [known]")
    return screen.getvalue()


def test_on_a_terminal_a_line_that_stays_says_after_how_long_it_was_known(monkeypatch):
    assert "after 0 s: half is [known]\n" in shown(monkeypatch, Terminal())


def test_a_pipe_shows_nothing(monkeypatch):
    assert shown(monkeypatch, io.StringIO()) == ""
