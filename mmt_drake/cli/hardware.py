"""`run --hardware`: the devices of a scenario, a person's switches, and what came of them."""

from __future__ import annotations

import argparse
import os
import select
import sys
import threading
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.recording import load

if TYPE_CHECKING:
    from diagrams.devices import Hand
    from diagrams.scenario import Scenario

_LOOK = 0.05  # [s] at the latest the end of the run is seen, and a line printed
_PATIENCE = 1.0  # [s] with a terminal that takes no lines


def check(arguments: argparse.Namespace) -> None:
    """Refuse options that do not fit to devices, before anything is done.

    Raises:
        BadInput: a hand is replayed, or the side asked for has no device.
    """
    if arguments.hardware and arguments.operator is not None:
        raise BadInput("--operator", found="--hardware", expected="one of them: a person's hand follows no recording")
    if arguments.hardware and arguments.side == "telerobot":
        raise BadInput("--hardware", found="--side telerobot", expected="--side operator, who holds the device")


def open_hand(scenario: Scenario, watched: Mapping[str, float]) -> Hand:
    """The operator's device, open.

    Args:
        scenario: that says which.
        watched: name -> greatest age [s] of what must stay fresh.

    Raises:
        BadInput, MissingDependency, DeviceError: as `diagrams.devices.Hand`.
    """
    from diagrams.devices import Hand

    return Hand(scenario.operator_device, scenario.step, watched)


class Console:
    """A person's terminal: the switches of a device on standard input, what its supervisor says on standard error.

    Both in a thread of their own: no tick waits for a terminal.
    """

    def __init__(self) -> None:
        self._lines: SimpleQueue[str] = SimpleQueue()
        self._done = threading.Event()

    def tell(self, line: str) -> None:
        """Have a line printed."""
        self._lines.put(line)

    @contextmanager
    def switching(self, hand: Hand) -> Iterator[None]:
        """Obey meanwhile: `a` arms, `r` releases a stop, any other line is an emergency stop."""
        self.tell(f"{hand.name}: a and Enter arms it, Enter alone is the emergency stop, r and Enter releases that")
        thread = threading.Thread(target=self._run, args=(hand,), name="console", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._done.set()
            thread.join(_PATIENCE)

    def _run(self, hand: Hand) -> None:
        switches = {b"a": hand.switch.arm, b"r": hand.switch.release}
        source, said = _standard_input(), b""
        while not self._done.is_set():
            if source is None:
                self._done.wait(_LOOK)
            elif select.select([source], [], [], _LOOK)[0]:
                read = os.read(source, 4096)
                *lines, said = (said + read).split(b"\n")
                for line in lines:
                    switches.get(line.strip().lower(), hand.switch.stop)()
                source = source if read else None
            self._print()
        self._print()

    def _print(self) -> None:
        while not self._lines.empty():
            print(self._lines.get(), file=sys.stderr, flush=True)


def _standard_input() -> int | None:
    """Its descriptor, if there is any."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return None


def figures(file: Path, hand: Hand) -> dict[str, Any]:
    """What a device did in the run that was recorded in a file: time armed, greatest force, why it was stopped.

    `stops` has for each reason how often it stopped an armed device, `stale_ticks` counts those in which the device, or
    anything else that is watched, had nothing new in time.
    """
    from hw.safety.reasons import is_stale, reason_words

    columns = load(file, forces=False).columns
    armed, reason = columns["safety_armed"] == 1.0, columns["safety_reason"]
    force = np.linalg.norm([columns[f"applied_force_{axis}"] for axis in "xyz"], axis=0)
    stops = Counter(reason[1:][armed[:-1] & ~armed[1:]].astype(int).tolist())
    return {
        "name": hand.name,
        "ticks": len(armed),
        "armed_ticks": int(np.count_nonzero(armed)),
        "greatest_force_n": float(force.max()),
        "stops": {reason_words(code, tuple(hand.watched)): count for code, count in stops.items()},
        "stale_ticks": int(np.count_nonzero(is_stale(reason))),
    }


def line(told: Mapping[str, Any]) -> str:
    """The same for a terminal."""
    stops = ", ".join(f"{count} x {reason}" for reason, count in told["stops"].items()) or "none"
    return (
        f"device {told['name']}: armed in {told['armed_ticks']} of {told['ticks']} steps, at most "
        f"{told['greatest_force_n']:.2f} N; stops: {stops}; stale inputs in {told['stale_ticks']} steps"
    )
