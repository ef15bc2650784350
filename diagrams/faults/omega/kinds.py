"""Kinds of fault that the emulated device, its clock and its surroundings can have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mmt_drake.diagrams.faults.omega.rig import LIMITS, OmegaRig
from mmt_drake.hw.safety import Reason

Action = Callable[[OmegaRig], object]


@dataclass(frozen=True)
class OmegaFault:
    """One kind of fault.

    Attributes:
        start, stop: what brings it and what takes it away.
        reasons: that the supervisor may give; empty where it goes on.
        seen_after: how long it takes until it can be told [s].
        once: nothing goes on after it.
    """

    start: Action
    stop: Action
    reasons: tuple[int, ...]
    seen_after: float = 0.0
    once: bool = False


def _set(**members: float) -> Action:
    return lambda rig: rig.omega.set(**members)


def _fail(calls: float, error: float) -> OmegaFault:
    return OmegaFault(_set(failing=calls, error=error), _set(failing=0.0), (Reason.DEVICE_FAULT,))


def _member(reasons: tuple[int, ...], seen_after: float = 0.0, **members: float) -> OmegaFault:
    return OmegaFault(_set(**members), _set(**dict.fromkeys(members, 0.0)), reasons, seen_after)


def _force(x: float) -> Action:
    def change(rig: OmegaRig) -> None:
        rig.wall.added = np.array([x, 0.0, 0.0])

    return change


def _clock(offset: float) -> Action:
    def change(rig: OmegaRig) -> None:
        rig.clock.offset += offset

    return change


def _nothing(rig: OmegaRig) -> None:
    pass


def _stall(seconds: float) -> Action:
    return lambda rig: rig.omega.advance(seconds)


def _let_go(rig: OmegaRig) -> None:
    rig.omega.set(hand_stiffness=0.0, hand_damping=0.0, hand_mass=0.0)
    rig.wall.added = np.array([0.0, 0.0, 5.0])


def _hold_again(rig: OmegaRig) -> None:
    rig.omega.set(hand_stiffness=250.0, hand_damping=4.0, hand_mass=0.15, x=0.0, y=0.0, z=-0.01, vx=0.0, vy=0.0, vz=0.0)
    rig.wall.added = np.zeros(3)


FAULT = (Reason.DEVICE_FAULT,)
LOST = OmegaFault(_set(connected=0.0), _set(connected=1.0), FAULT)
#: A slow call also makes the device's own watchdog hungry; either may be told first.
SLOW = (Reason.OVERRUN, Reason.DEVICE_FAULT)

KINDS: dict[str, OmegaFault] = {
    "unplugged": LOST,
    "one call fails": _fail(1.0, 1.0),
    "thirty calls fail": _fail(30.0, 2.0),
    "every call times out": _fail(1e9, 7.0),
    "an error number that nobody knows": _fail(2.0, 77.0),
    "position NaN": _member(FAULT, nan_position=1.0),
    "velocity NaN": _member(FAULT, nan_velocity=1.0),
    "position stuck": _member((Reason.STUCK,), LIMITS.stuck, stuck=1.0),
    "position off by 5 cm": _member((Reason.JUMP,), jump=0.05),
    "calls take 15 ms": _member(SLOW, slow=0.015),
    "force button": _member(FAULT, force_button=1.0),
    "no power": OmegaFault(_set(powered=0.0), _set(powered=1.0), FAULT),
    "diagram stalls for 40 ms": OmegaFault(_stall(0.040), _nothing, SLOW),
    "force NaN": OmegaFault(_force(np.nan), _force(0.0), (Reason.COMMAND_NOT_FINITE,)),
    "force of 1 MN": OmegaFault(_force(1e6), _force(0.0), ()),
    "handle let go": OmegaFault(_let_go, _hold_again, (Reason.SPEED, Reason.WORKSPACE, Reason.DEVICE_FAULT), 0.150),
    "clock set back": OmegaFault(_clock(-100.0), _nothing, (Reason.CLOCK,)),
    "clock set forward": OmegaFault(_clock(100.0), _nothing, (Reason.OVERRUN,)),
    "peer lost": OmegaFault(lambda rig: rig.set_age(10.0), lambda rig: rig.set_age(0.001), (Reason.STALE,)),
    "emergency stop": OmegaFault(
        lambda rig: rig.switch.stop(), lambda rig: rig.switch.release(), (Reason.EMERGENCY_STOP,)
    ),
    "device closed": OmegaFault(lambda rig: rig.close(), _nothing, FAULT, once=True),
}
