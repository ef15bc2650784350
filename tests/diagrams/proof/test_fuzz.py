"""Strange files and packets end in success or in one line; an answer that is neither would be seen."""

import ctypes
import itertools
import os
import random
import sys
import time
from pathlib import Path

import pytest

from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.faults.fuzz import harness
from mmt_drake.diagrams.proof.faults.fuzz.harness import Answer, Fuzz
from mmt_drake.diagrams.proof.faults.fuzz.mutations import mutated
from mmt_drake.errors import BadInput

SECONDS = 15.0


def test_what_is_read_is_taken_or_refused_in_one_line() -> None:
    from mmt_drake.diagrams.proof.faults.fuzz.targets import (
        fuzz,  # Drake and all, which the other processes here do without
    )

    answers, start = list[Answer](), None
    for answer in fuzz(main, seed=1).answers():
        start = start or time.monotonic()
        answers.append(answer)
        if time.monotonic() - start > SECONDS:
            break
    wrong = [f"{o.number} {o.target}: {o.wrong}" for o in answers if o.wrong]
    assert not wrong, "\n".join(wrong)
    assert len(answers) > 20 and {o.status for o in answers} == {0, 2}


def nothing(seeds: Path) -> None:
    """No valid files are needed."""


def refused(draw: random.Random, seeds: Path) -> int:
    raise BadInput("a.csv", found="x", expected="y")


def traceback(draw: random.Random, seeds: Path) -> int:
    raise KeyError("x")


def two_lines(draw: random.Random, seeds: Path) -> int:
    print("one", file=sys.stderr)
    return refused(draw, seeds)


def half_written(draw: random.Random, seeds: Path) -> int:
    Path("out.csv.part").write_text("x")
    return refused(draw, seeds)


def temporary(draw: random.Random, seeds: Path) -> int:
    Path("tmp", "x").write_text("x")
    return 0


def escape(draw: random.Random, seeds: Path) -> int:
    print("mmt-drake: \x1b[31m", file=sys.stderr)
    return 2


def hang(draw: random.Random, seeds: Path) -> int:
    while True:
        pass


def sleep(draw: random.Random, seeds: Path) -> int:
    time.sleep(1000.0)
    return 0


def crash(draw: random.Random, seeds: Path) -> int:
    return ctypes.string_at(0)[0]


def gone(draw: random.Random, seeds: Path) -> int:
    os._exit(0)


def memory(draw: random.Random, seeds: Path) -> int:
    return len(bytearray(int(9e9))) * 0


def much(draw: random.Random, seeds: Path) -> int:
    return len(b"1" * int(0.6e9)) * 0


def too_much(draw: random.Random, seeds: Path) -> int:
    try:
        return memory(draw, seeds)
    except MemoryError:
        raise BadInput("a.csv", found="not enough memory", expected="y") from None


ANSWERS = {
    refused: "",
    traceback: "KeyError",
    two_lines: "said",
    half_written: "left behind: out.csv.part",
    temporary: "left behind: tmp/x",
    escape: "said",
    hang: "more than 1 s",
    sleep: "asleep for 1 s",
    crash: "SIGSEGV",
    gone: "ended",
    memory: "MemoryError",
    much: "GB",
    too_much: "not enough memory",
}


@pytest.mark.parametrize(
    ("kept", "said", "wrong"),
    [
        ("out.npz.mcap", "mmt-drake: out.npz.mcap: row 9, column 'rendered_force_z': found nan, expected x\n", ""),
        ("out.npz.mcap", "mmt-drake: in.yaml: found x, expected y\n", "left behind: out.npz.mcap"),
        ("out.part.mcap", "mmt-drake: out.part.mcap: found x, expected y\n", "left behind: out.part.mcap"),
    ],
)
def test_a_recording_may_stay_where_its_refusal_names_it(tmp_path: Path, kept: str, said: str, wrong: str) -> None:
    (tmp_path / kept).touch()
    assert harness._wrong(2, said, tmp_path) == wrong


def test_a_wrong_answer_is_seen_and_the_next_input_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(harness, "_ASLEEP", 1.0)
    targets = {target.__name__: (target, 1) for target in ANSWERS}
    answers = Fuzz(dict(targets), nothing, main, seed=63627, slowest=1, memory=0.5).answers()
    for answer in itertools.islice(answers, len(targets)):  # with this seed each of them once
        said = ANSWERS[targets.pop(answer.target)[0]]
        assert said in answer.wrong and bool(answer.wrong) == bool(said), answer
    answers.close()


@pytest.mark.parametrize("ending", [".csv", ".yaml", ".npz", ".mcap", ""])
def test_an_input_is_a_function_of_the_seed(ending: str) -> None:
    data = b"time,position\n0.0,1.5\n0.1,2.5\n" * 20
    first, again = ([mutated(random.Random(k), data, ending, data) for k in range(50)] for _ in range(2))
    assert first == again and len({*first, data}) > 25
