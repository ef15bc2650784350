"""`run --hardware`: the devices of a scenario, a person's switches, and what came of them."""

from __future__ import annotations

import argparse
import os
import select
import sys
import threading
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np

from mmt_drake.cli import two_sides
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording

if TYPE_CHECKING:
    from diagrams.devices import Devices, Hand, RemoteArm
    from diagrams.scenario import Scenario

_LOOK = 0.05  # [s] at the latest the end of the run is seen, and a line printed
_SWITCHES = "a and Enter arms it, Enter alone is the emergency stop, r and Enter releases that"
_PATIENCE = 1.0  # [s] with a terminal that takes no lines


def check(arguments: argparse.Namespace) -> None:
    """Refuse options that do not fit to devices, before anything is done.

    Raises:
        BadInput: a hand is replayed.
    """
    if arguments.hardware and arguments.operator is not None:
        raise BadInput("--operator", found="--hardware", expected="one of them: a person's hand follows no recording")


def open_devices(opened: ExitStack, arguments: argparse.Namespace, scenario: Scenario) -> Devices:
    """The scenario's devices of this side, open, if the run is to have any.

    The operator's is always there, an arm where the scenario has a telerobot, a camera where it names a real one.

    Args:
        opened: closes them, the hand first.
        arguments: whether there are any, which side, and what of its link is watched.
        scenario: that says which.

    Raises:
        BadInput, MissingDependency, DeviceError: as each of them; or this side has none.
    """
    from diagrams.camera_options import DepthCamera
    from diagrams.cameras import Camera
    from diagrams.devices import ARMING, Devices, Hand, RemoteArm

    if not arguments.hardware:
        return Devices()
    hand = arm = camera = None
    seen = scenario.environment.cloud
    if arguments.side != "operator":
        if isinstance(seen, DepthCamera):
            camera = opened.enter_context(Camera(seen))
        if scenario.telerobot is not None:
            arm = opened.enter_context(RemoteArm(scenario.telerobot_device, scenario.step))
    if arguments.side != "telerobot":
        watched, device = two_sides.watched(arguments), scenario.operator_device
        if isinstance(seen, DepthCamera):  # here or at the other side
            watched["camera"] = seen.stale
        if arm is None:
            hand = Hand(device, scenario.step, watched)
        else:
            hand = Hand(device, scenario.step, {**watched, "arm": arm.oldest}, press=ARMING)
        opened.enter_context(hand)
    elif arm is None and camera is None:
        expected = "--side operator, who holds the device, or a scenario with a telerobot or a camera"
        raise BadInput("--hardware", found="--side telerobot", expected=expected)
    return Devices(hand, arm, camera)


class Console:
    """A person's terminal: the switches of a device on standard input, what there is to tell on standard error.

    Each in a thread of its own: no tick waits for a terminal, and no stop for one that takes no lines.
    """

    def __init__(self) -> None:
        self._lines: SimpleQueue[str] = SimpleQueue()
        self._done = threading.Event()

    def tell(self, line: str) -> None:
        """Have a line printed."""
        self._lines.put(line)

    @contextmanager
    def switching(self, device: Hand | RemoteArm | None) -> Iterator[None]:
        """Print meanwhile what is told, and obey where there is a device.

        `a` arms, `r` releases a stop; any other line is an emergency stop, and so is the end of input.
        """
        tasks = [self._speak]
        if device is not None:
            self.tell(f"{device.name}: {_SWITCHES}")
            tasks.append(partial(self._listen, device))
        threads = [threading.Thread(target=task, name="console", daemon=True) for task in tasks]
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            self._done.set()
            for thread in threads:
                thread.join(_PATIENCE)

    def _listen(self, device: Hand | RemoteArm) -> None:
        switches = {b"a": device.switch.arm, b"r": device.switch.release}
        source, said = _standard_input(), b""
        if source is None:
            return
        try:
            while not self._done.is_set():
                if select.select([source], [], [], _LOOK)[0]:
                    read = os.read(source, 4096)
                    *lines, said = (said + read).split(b"\n")
                    for line in lines:
                        switches.get(line.strip().lower(), device.switch.stop)()
                    if not read:
                        return
        except OSError:  # the terminal is gone
            return
        finally:
            if not self._done.is_set():  # nobody is there to stop it any more
                device.switch.stop()

    def _speak(self) -> None:
        with suppress(OSError):  # nobody is there to read it
            while not (self._done.is_set() and self._lines.empty()):
                with suppress(Empty):
                    print(self._lines.get(timeout=_LOOK), file=sys.stderr, flush=True)


def _standard_input() -> int | None:
    """Its descriptor, if there is any."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return None


def figures(recording: Recording, hand: Hand) -> dict[str, Any]:
    """What a device did in the run that was recorded: time armed, greatest force, why it was stopped.

    `stops` has for each reason how often it stopped an armed device, `stale_ticks` counts those in which the device, or
    anything else that is watched, had nothing new in time.
    """
    from hw.safety.reasons import is_stale, reason_words

    columns = recording.columns
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


def arm_figures(recording: Recording, arm: RemoteArm) -> dict[str, Any]:
    """What an arm did in the run that was recorded: how long it followed, and why it was stopped."""
    from hw.franka import describe_fault

    columns = recording.columns
    fault = columns["telerobot_fault"]
    stops = Counter(fault[1:][(fault[:-1] == 0.0) & (fault[1:] != 0.0)].astype(int).tolist())
    return {
        "address": arm.address,
        "steps": len(fault),
        "followed_steps": int(np.count_nonzero((fault == 0.0) & (columns["telerobot_waits"] == 0.0))),
        "stops": {describe_fault(code): count for code, count in stops.items()},
    }


def arm_line(told: Mapping[str, Any]) -> str:
    """The same for a terminal."""
    stops = ", ".join(f"{count} x {reason}" for reason, count in told["stops"].items()) or "none"
    return f"arm at {told['address']}: followed in {told['followed_steps']} of {told['steps']} steps; stops: {stops}"


def line(told: Mapping[str, Any]) -> str:
    """The same for a terminal."""
    stops = ", ".join(f"{count} x {reason}" for reason, count in told["stops"].items()) or "none"
    return (
        f"device {told['name']}: armed in {told['armed_ticks']} of {told['ticks']} steps, at most "
        f"{told['greatest_force_n']:.2f} N; stops: {stops}; stale inputs in {told['stale_ticks']} steps"
    )
