"""`run --hardware`: the devices of a scenario, a person's switches, and what came of them."""

from __future__ import annotations

import argparse
import os
import select
import signal
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from mmt_drake.ceilings import looser_options
from mmt_drake.cli import two_sides
from mmt_drake.cli.output import RunFigure, say
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.devices import Hand, RemoteArm
    from mmt_drake.diagrams.stations.scenario import Scenario
    from mmt_drake.diagrams.stations.site import Devices
    from mmt_drake.hw.safety.operator_switch import OperatorSwitch

_LOOK = 0.05  # [s] at the latest the end of the run is seen
_PATIENCE = 1.0  # [s] with a terminal that takes no lines


def loosened_limits(arguments: argparse.Namespace, scenario: Scenario) -> list[str]:
    """Tell on standard error which limits are looser than shipped; gives the lines.

    Raises:
        BadInput: there are any, a run on devices, and no word that they may be.
    """
    from mmt_drake.diagrams.stations.scenario import loosened
    from mmt_drake.diagrams.stations.two_sides import SLIDERS_MOVE_HARDWARE

    found = loosened(scenario)
    if arguments.side is not None:
        found += looser_options(two_sides.link_options(arguments), "link")
    lines = [option.line() for option in found]
    if arguments.hardware and lines and not arguments.loosened_limits:
        raise BadInput("--hardware", found="; ".join(lines), expected="no looser limit, or --loosened-limits beside it")
    if arguments.sliders_move_hardware:  # a word of its own
        lines.append(SLIDERS_MOVE_HARDWARE.line())
    for line in lines:
        say(f"limit: {line}", stderr=True)
    if lines and Path(arguments.record or "").suffix.lower() == ".csv":
        say(f"limit: {arguments.record} cannot say so: .mcap and .npz can", stderr=True)
    return lines


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
    from mmt_drake.diagrams.stations.devices import ARMING, Camera, Hand, RemoteArm
    from mmt_drake.diagrams.stations.site import Devices
    from mmt_drake.diagrams.stations.surfaces import DepthCamera

    if not arguments.hardware:
        return Devices()
    opened.enter_context(ended_as_by_ctrl_c())
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


@contextmanager
def ended_as_by_ctrl_c() -> Iterator[None]:
    """A terminal that closes, and a program that is asked to end, bring devices to rest as Ctrl-C does."""
    if threading.current_thread() is not threading.main_thread():  # which alone hears signals
        yield
        return
    with ExitStack() as undo:
        for number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is signal.SIG_DFL:
                undo.callback(signal.signal, number, signal.signal(number, signal.default_int_handler))
        yield


class Console:
    """A person's terminal: the switches of a device on standard input, what there is to tell on standard error.

    Each in a thread of its own: no tick waits for a terminal, and no emergency stop for one that takes no lines.
    """

    def __init__(self) -> None:
        self._lines: SimpleQueue[str | None] = SimpleQueue()
        self._printing = threading.Thread(target=self._print, name="console", daemon=True)

    def tell(self, line: str) -> None:
        """Have a line printed."""
        self._lines.put(line)

    def __enter__(self) -> Self:
        self._printing.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._lines.put(None)
        self._printing.join(_PATIENCE)

    def _print(self) -> None:
        with suppress(OSError):  # nobody is there to read it
            while (line := self._lines.get()) is not None:
                say(line, stderr=True)

    @contextmanager
    def switching(self, device: Hand | RemoteArm) -> Iterator[None]:
        """Obey meanwhile: `a` arms, `r` releases a stop, any other line, and the end of input, is an emergency stop.

        What has been typed before is obeyed at once: an `a` does nothing then, since the run has not begun.
        """
        self.tell(f"{device.name}: a and Enter arms it, Enter alone is the emergency stop, r and Enter releases that")
        keys, done = _Keys(device.switch), threading.Event()
        keys.obey(0.0)

        def obey() -> None:
            try:
                while not done.is_set() and keys.obey(_LOOK):
                    pass
            finally:
                if not done.is_set():  # the end of input, or whatever it is: nobody is there to stop it any more
                    device.switch.stop()

        thread = threading.Thread(target=obey, name="switches", daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join(_PATIENCE)


class _Keys:
    """The lines that a person types, as presses of switches."""

    def __init__(self, switch: OperatorSwitch) -> None:
        self._switch, self._switches = switch, {b"a": switch.arm, b"r": switch.release}
        self._source, self._said = _standard_input(), b""

    def obey(self, seconds: float) -> bool:
        """Obey what is there, or comes within so long; false if nobody is."""
        if self._source is None:
            return False
        try:
            if not select.select([self._source], [], [], seconds)[0]:
                return True
            read = os.read(self._source, 4096)
        except OSError:  # a terminal that is gone
            return False
        *lines, self._said = (self._said + read).split(b"\n")
        for line in lines:
            self._switches.get(line.strip().lower(), self._switch.stop)()
        return bool(read)


def _standard_input() -> int | None:
    """Its descriptor, if there is any."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return None


def hand_figure(recording: Recording, hand: Hand) -> RunFigure:
    """Figures of a device in the run that was recorded: time armed, greatest force, why it was stopped.

    The force is the device's own: `force_scale` times what is recorded. `stops` has for each reason how often it
    stopped an armed device, `stale_ticks` counts those in which the device, or anything else that is watched, had
    nothing new in time.
    """
    from mmt_drake.hw.safety.reasons import is_stale, reason_words

    columns = recording.columns
    armed, reason = columns["safety_armed"] == 1.0, columns["safety_reason"]
    force = np.linalg.norm([columns[f"applied_force_{axis}"] for axis in "xyz"], axis=0)
    data = {
        "name": hand.name,
        "ticks": len(armed),
        "armed_ticks": int(np.count_nonzero(armed)),
        "greatest_force_n": hand.force_scale * float(force.max()),
        "stops": _stops(reason, armed, partial(reason_words, watched=tuple(hand.watched))),
        "stale_ticks": int(np.count_nonzero(is_stale(reason))),
    }
    return RunFigure(
        data,
        f"device {hand.name}: armed in {data['armed_ticks']} of {data['ticks']} steps, at most "
        f"{data['greatest_force_n']:.2f} N; stops: {_listed(data)}; stale inputs in {data['stale_ticks']} steps",
    )


def arm_figure(recording: Recording, arm: RemoteArm) -> RunFigure:
    """Figures of an arm in the run that was recorded: how long it followed, and why it was stopped."""
    from mmt_drake.hw.franka.faults import describe_fault

    columns = recording.columns
    fault = columns["telerobot_fault"]
    data = {
        "address": arm.address,
        "steps": len(fault),
        "followed_steps": int(np.count_nonzero((fault == 0.0) & (columns["telerobot_waits"] == 0.0))),
        "stops": _stops(fault, fault == 0.0, describe_fault),
    }
    followed = f"followed in {data['followed_steps']} of {data['steps']} steps"
    return RunFigure(data, f"arm at {arm.address}: {followed}; stops: {_listed(data)}")


def _stops(code: Array, active: Flags, words: Callable[[int], str]) -> dict[str, int]:
    """In words, the codes (n,) that ended a stretch in which it was active (n,), and how often each did."""
    ended = Counter(code[1:][active[:-1] & ~active[1:]].astype(int).tolist())
    return {words(number): count for number, count in ended.items()}


def _listed(data: Mapping[str, Any]) -> str:
    return ", ".join(f"{count} x {reason}" for reason, count in data["stops"].items()) or "none"
