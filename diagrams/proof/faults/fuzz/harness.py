"""Files and packets that are not what they should be, thousands of them: none ends a program by anything but one line.

Inputs are numbered; each is a function of the seed and its number. They are tried in a process of its own, so that one
that hangs, takes all memory or ends the process is seen, and the next one is tried.
"""

import faulthandler
import multiprocessing
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from mmt_drake.errors import MmtError
from mmt_drake.with_parent import end_with_parent

Program = Callable[[Sequence[str]], int]
"""`mmt-drake`: from its arguments to its exit status."""
Target = Callable[[random.Random, Path], int | list[str]]
"""Makes an input named `in...` in the present folder, of the valid files in another one. Gives the arguments of a
program that is to read it and may write what is named `out...`; or tries it and gives an exit status itself. Any error
but `MmtError` is a failure."""

_READY = 600.0  # until there is a process that may have to compile [s]
_ASLEEP = 6.0  # times what an input may take: so long it may sleep
_AT_REST = 1.0  # one that keeps more is followed by another one [GB]


@dataclass(frozen=True)
class Answer:
    """What came of one input.

    Attributes:
        number: of the input.
        target: what it was given to.
        status: the exit status; None where the process ended.
        seconds: that it took.
        memory: the most that the process had meanwhile [GB].
        wrong: what was not as it must be; empty: nothing.
    """

    number: int
    target: str
    status: int | None
    seconds: float
    memory: float
    wrong: str


@dataclass(frozen=True)
class Fuzz:
    """What is tried, and what an input may take.

    Attributes:
        targets: name -> what is tried, and its share.
        write_seeds: writes the valid files into a folder.
        program: that reads them.
        seed: of all inputs.
        slowest: time of the processor for one [s]; six times as long for what sleeps. What a busy machine keeps
            waiting does not sleep.
        memory: that the process may have with it [GB].
    """

    targets: Mapping[str, tuple[Target, int]]
    write_seeds: Callable[[Path], None]
    program: Program
    seed: int = 0
    slowest: int = 20
    memory: float = 2.0

    def answers(self) -> Iterator[Answer]:
        """Of one input after the other, without end."""
        with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
            folder, number = Path(name), 0
            (folder / "seeds").mkdir()
            while True:
                ours, theirs = multiprocessing.Pipe()
                spawn = multiprocessing.get_context("spawn")
                process = spawn.Process(target=self._serve, args=(theirs, folder), daemon=True)
                process.start()
                theirs.close()
                try:
                    if not ours.poll(_READY) or ours.recv() != "ready":
                        raise RuntimeError("no process began")
                    answer = None
                    while answer is None or (answer.status is not None and answer.memory < _AT_REST):
                        answer = self._attempt(number, process, ours, folder)
                        number += 1
                        yield answer
                finally:
                    process.kill()
                    process.join()
                    ours.close()

    def _attempt(
        self, number: int, process: multiprocessing.process.BaseProcess, ours: Connection, folder: Path
    ) -> Answer:
        ours.send(number)
        name = self._drawn(number)[0]
        start, patience = time.monotonic(), _ASLEEP * self.slowest
        asleep, awake = 0, _awake(process.pid)
        try:
            while asleep < patience:
                if ours.poll(1.0):
                    answer: Answer = ours.recv()
                    return answer
                before, awake = awake, _awake(process.pid)
                asleep += awake - before < 0.5
            wrong = f"asleep for {patience:g} s"
        except (EOFError, ConnectionResetError):
            process.join()
            ended = process.exitcode or 0
            said = " | ".join((folder / "stderr").read_text(errors="replace").split("\n")[:12])
            wrong = f"the process ended: {signal.Signals(-ended).name if ended < 0 else ended} {said[:600]}"
            if ended == -signal.SIGXCPU:
                wrong = f"more than {self.slowest} s"
        return Answer(number, name, None, time.monotonic() - start, 0.0, wrong)

    def _drawn(self, number: int) -> tuple[str, random.Random]:
        draw, names = random.Random(f"{self.seed}/{number}"), list(self.targets)
        return draw.choices(names, [self.targets[name][1] for name in names])[0], draw

    def _serve(self, connection: Connection, folder: Path) -> None:
        """Try the inputs whose numbers come."""
        end_with_parent()
        if not any((folder / "seeds").iterdir()):
            self.write_seeds(folder / "seeds")
        for descriptor, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(folder / name, os.O_RDWR | os.O_CREAT | os.O_APPEND), descriptor)
        faulthandler.enable()
        connection.send("ready")
        at = folder / "input"
        while True:
            number = connection.recv()
            name, draw = self._drawn(number)
            os.ftruncate(1, 0)
            os.ftruncate(2, 0)
            shutil.rmtree(at, ignore_errors=True)
            (at / "tmp").mkdir(parents=True)
            os.chdir(at)
            tempfile.tempdir = str(at / "tmp")
            self._limit(self.slowest)
            start, status, wrong = time.monotonic(), 1, ""
            try:
                tried = self.targets[name][0](draw, folder / "seeds")
                status = self.program(tried) if isinstance(tried, list) else tried
            except MmtError as error:
                status = 2
                print(f"mmt-drake: {error}", file=sys.stderr)
            except BaseException:
                wrong = " | ".join(traceback.format_exc().strip().split("\n")[-5:])
            seconds, memory = time.monotonic() - start, _gigabytes("VmHWM")
            wrong = (
                wrong
                or f"{memory:.2f} GB" * (memory > self.memory)
                or _wrong(status, (folder / "stderr").read_text(errors="replace"), at)
            )
            connection.send(Answer(number, name, status, seconds, memory, wrong))

    def _limit(self, allowed: int) -> None:
        """From now on end this process by signal if an input takes too long, and refuse it what no machine would give.

        A length in a damaged file may have memory set aside that is never touched, so what is held is `VmHWM`.
        """
        used = resource.getrusage(resource.RUSAGE_SELF)
        seconds = int(used.ru_utime + used.ru_stime) + 1 + allowed
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, resource.RLIM_INFINITY))
        most = int(1e9 * (_gigabytes("VmSize") + 4.0 * self.memory))
        resource.setrlimit(resource.RLIMIT_AS, (most, resource.RLIM_INFINITY))
        Path("/proc/self/clear_refs").write_text("5")  # VmHWM begins anew


_KEPT = (".csv.mcap", ".npz.mcap")
"""A run's recording that no other format may hold; its refusal names it."""


def _wrong(status: int, said: str, at: Path) -> str:
    """What is not as it must be after a command, or nothing."""
    found = (str(path.relative_to(at)) for path in at.rglob("*"))
    left = [name for name in found if not name.startswith("in" if status else ("in", "out")) and name != "tmp"]
    left = [name for name in left if not (name.endswith(_KEPT) and f"{name}: " in said)]
    if status not in (0, 2):
        return f"exit status {status}: {said[-300:]!r}"
    if status == 2 and not (said.startswith("mmt-drake: ") and said.removesuffix("\n").isprintable()):
        return f"said {said[:600]!r}"
    if "Traceback" in said or "not enough memory" in said:
        return f"said {said[-500:]!r}"
    return f"left behind: {', '.join(left[:5])}" if left else ""


def _awake(process: int | None) -> float:
    """Since its threads began, how long those of a process have worked or waited for a processor [s]."""
    awake = 0
    for thread in Path(f"/proc/{process}/task").glob("*/schedstat"):
        with suppress(OSError):  # it has just ended
            awake += sum(map(int, thread.read_text().split()[:2]))
    return awake * 1e-9


def _gigabytes(name: str) -> float:
    """A line of the system's account of this process [GB]."""
    lines = Path("/proc/self/status").read_text().split("\n")
    return next(float(line.split()[1]) * 1024e-9 for line in lines if line.startswith(f"{name}:"))
