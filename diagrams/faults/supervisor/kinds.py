"""Kinds of fault that a supervisor can meet on its inputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mmt_drake.diagrams.faults.supervisor.session import LIMITS, PERIOD, Inputs, ordinary
from mmt_drake.hw.safety.reasons import Reason

Change = Callable[[Inputs, int, np.random.Generator], None]
"""Changes what the supervisor sees, so many ticks after the fault began."""


@dataclass(frozen=True)
class SupervisorFault:
    """One kind of fault.

    Attributes:
        change: what the supervisor sees of it.
        reason: that it must give; None where it must go on within its limits.
        seen_after: how long it takes until it can be told [s], beside one tick.
        lasts: ticks; None for ever.
    """

    change: Change
    reason: int | None
    seen_after: float = 0.0
    lasts: int | None = None


def _command(value: float, axis: int | None = None) -> Change:
    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        inputs.command[rng.integers(3) if axis is None else axis] = value

    return change


def _motion(first: int, last: int, value: float) -> Change:
    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        inputs.motion[rng.integers(first, last)] = value

    return change


def _frozen(*, clock: bool, moving: bool = True) -> Change:
    """The position stays what it was; its clock too, or not."""

    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        start = ordinary(round(inputs.t / PERIOD) - since - 1)
        inputs.motion[:3] = start.motion[:3]
        if not moving:
            inputs.motion[3:] = 0.0
        if clock:
            inputs.device[1] = start.device[1]

    return change


def _device(index: int, value: Callable[[float], float]) -> Change:
    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        inputs.device[index] = value(inputs.device[index])

    return change


def _stop(value: float) -> Change:
    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        inputs.switches[1] = value

    return change


def _age(index: int, age: Callable[[float], float]) -> Change:
    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        inputs.ages[index] = age(since * PERIOD)

    return change


def _shift(offset: Callable[[float], float]) -> Change:
    def change(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
        inputs.motion[0] += offset(since * PERIOD)

    return change


def _let_go(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    inputs.motion[3:] = [0.0, 1.4, 0.0]
    inputs.motion[1] += 1.4 * since * PERIOD


def _lost(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    """A driver that lost its device: its code, the last position, at rest, time goes on."""
    _frozen(clock=False, moving=False)(inputs, since, rng)
    inputs.device[0] = 2.0


def _random_force(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    inputs.command = 10.0 ** rng.uniform(-3, 12) * rng.standard_normal(3)


def _resonance(inputs: Inputs, since: int, rng: np.random.Generator) -> None:
    inputs.command = 30.0 * inputs.motion[3:]  # negative damping: it gives power wherever the hand goes


KINDS: dict[str, SupervisorFault] = {
    "command NaN": SupervisorFault(_command(np.nan), Reason.COMMAND_NOT_FINITE),
    "command infinite": SupervisorFault(_command(np.inf, 1), Reason.COMMAND_NOT_FINITE),
    "command NaN for one tick": SupervisorFault(_command(-np.inf), Reason.COMMAND_NOT_FINITE, lasts=1),
    "position NaN": SupervisorFault(_motion(0, 3, np.nan), Reason.MOTION_NOT_FINITE),
    "velocity NaN": SupervisorFault(_motion(3, 6, np.nan), Reason.MOTION_NOT_FINITE),
    "SDK error": SupervisorFault(_device(0, lambda _: 1.0), Reason.DEVICE_FAULT, lasts=1),
    "fault code NaN": SupervisorFault(_device(0, lambda _: np.nan), Reason.DEVICE_FAULT),
    "device lost": SupervisorFault(_lost, Reason.DEVICE_FAULT),
    "emergency stop": SupervisorFault(_stop(1.0), Reason.EMERGENCY_STOP),
    "emergency stop with a broken wire": SupervisorFault(_stop(np.nan), Reason.EMERGENCY_STOP),
    "clock NaN": SupervisorFault(_device(1, lambda _: np.nan), Reason.CLOCK, lasts=1),
    "clock set back": SupervisorFault(_device(1, lambda at: at - 3600.0), Reason.CLOCK),
    "clock set forward": SupervisorFault(_device(1, lambda at: at + 3600.0), Reason.OVERRUN),
    "overrun": SupervisorFault(_device(1, lambda at: at + 0.030), Reason.OVERRUN),
    "reading thread dead": SupervisorFault(_frozen(clock=True), Reason.SILENT_DEVICE, seen_after=LIMITS.gap),
    "value stuck": SupervisorFault(_frozen(clock=False), Reason.STUCK, seen_after=LIMITS.stuck),
    "value stuck, velocity zero": SupervisorFault(
        _frozen(clock=False, moving=False), Reason.STUCK, seen_after=LIMITS.stuck
    ),
    "position corrupted": SupervisorFault(_shift(lambda s: 0.05), Reason.JUMP, lasts=1),
    "handle let go": SupervisorFault(_let_go, Reason.SPEED),
    "out of the workspace": SupervisorFault(_shift(lambda s: 5.0 * s), Reason.WORKSPACE, seen_after=0.05),
    "peer killed": SupervisorFault(_age(0, lambda s: 0.005 + s), Reason.STALE, seen_after=0.095),
    "peer's age NaN": SupervisorFault(_age(0, lambda s: np.nan), Reason.STALE, lasts=1),
    "clock of the network set back": SupervisorFault(_age(0, lambda s: -60.0), Reason.STALE),
    "worker dead": SupervisorFault(_age(1, lambda s: 0.03 + s), Reason.STALE + 1, seen_after=0.47),
    "corrupted parameters": SupervisorFault(_random_force, None),
    "negative damping": SupervisorFault(_resonance, None),
}
