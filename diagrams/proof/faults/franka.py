"""Faults of an arm: a rig with an emulated one, the kinds, and what comes of each."""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.hw.franka.driver import FrankaDriver
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.faults import ArmFault, describe_fault
from mmt_drake.hw.franka.sdk import load_franky
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.numeric.arrays import Array

#: The machine may be busy: a gap is long, and the box holds all that the arm can reach.
SETTINGS = FrankaSettings(
    "127.0.0.1", realtime="ignore", table=(0.55, 0.0, 0.5), low=(-0.4,) * 3, high=(0.4,) * 3, gap=0.4, hold_after=0.1
)
_TICK = 2e-3


class FrankaRig:
    """The driver, to which set-points are streamed.

    Attributes:
        home: where the arm was when it last took control (3) [m].
        paused: the longest time between two set-points since [s]; more than some milliseconds are this machine's.

    Args:
        franka: the emulated arm.
        changed: settings other than `SETTINGS`.
    """

    def __init__(self, franka: EmulatedFranka, **changed: Any) -> None:
        self.franka, self.settings = franka, replace(SETTINGS, address=franka.address, **changed)
        self.driver = FrankaDriver(self.settings)
        self.home, self.paused = self.position, 0.0

    @property
    def position(self) -> Array:
        """(3) of the tip, as it was read last [m]."""
        return self.driver.latest.motion[:3].copy()

    @property
    def fault(self) -> int:
        """Of the driver, as a number."""
        return int(self.driver.latest.device[0])

    @property
    def following(self) -> bool:
        """Whether the arm follows the set-points."""
        return self.driver.latest.device[2] == 0.0

    def stay(self, elapsed: float) -> Array:
        """The set-point where the arm took control."""
        return self.off(0.0)

    def off(self, x: float, y: float = 0.0, vy: float = 0.0) -> Array:
        """A set-point beside where the arm took control."""
        return np.array([self.home[0] + x, self.home[1] + y, self.home[2], 0.0, vy, 0.0])

    def until(
        self, done: Callable[[], bool], within: float = 5.0, commanded: Callable[[float], Array | None] | None = None
    ) -> bool:
        """Stream set-points until something is so; whether it came to be."""
        began, commanded, before = time.monotonic(), commanded or self.stay, 0.0
        while (elapsed := time.monotonic() - began) < within:
            self.paused, before = max(self.paused, elapsed - before), elapsed
            setpoint = commanded(elapsed)
            if setpoint is not None:
                self.driver.send(setpoint)
            if done():
                return True
            time.sleep(_TICK)
        return False

    def circle(self, elapsed: float) -> Array:
        """A set-point that goes round, at 63 mm/s."""
        a, r, w = np.pi * elapsed, 0.02, np.pi
        around = r * np.array([np.sin(a), 1.0 - np.cos(a), 0.0, w * np.cos(a), w * np.sin(a), 0.0])
        return self.off(0.0) + around

    def go(self, seconds: float, commanded: Callable[[float], Array | None] | None = None) -> None:
        """Stream set-points for a while."""
        self.until(lambda: False, seconds, commanded)

    def follow(self) -> bool:
        """Ask for control and wait for the arm to follow; a second time if this machine paused meanwhile."""
        for _ in range(2):
            self.home, self.paused = self.position, 0.0
            self.driver.request_control()
            if self.until(lambda: self.following):
                return True
            if self.paused < 0.5 * self.settings.gap:
                break
        return False

    def seen(self, fault: ArmFault, commanded: Callable[[float], Array | None] | None = None) -> bool:
        """Stream set-points until the driver has a fault."""
        return self.until(lambda: self.fault == fault, 5.0, commanded)

    def ticks_to_rest(
        self, since: int, commanded: Callable[[float], Array | None] | None = None, within: float = 4.0
    ) -> int:
        """Of the robot's milliseconds, from tick `since` until no motion runs any more; set-points go on meanwhile."""
        state: dict[str, Any] = {}

        def rests() -> bool:
            state.update(self.franka.get())
            return not state["moving"]

        self.until(rests, within, commanded)
        return int(state["ticks"]) - since


@dataclass(frozen=True)
class FrankaFault:
    """One kind of fault.

    Attributes:
        fault: that the driver has; `ArmFault.NONE` where the arm goes on.
        world: members of the emulated arm that bring it about,
        after: and that take it away.
        setpoint: what becomes of a set-point (6); None sends none.
        act: what else happens, or its undoing (False).
        seen_after: how long it may take until it is seen [s].
    """

    fault: ArmFault
    world: Mapping[str, Any] = field(default_factory=dict)
    after: Mapping[str, Any] = field(default_factory=dict)
    setpoint: Callable[[Array], Array | None] = lambda setpoint: setpoint
    act: Callable[[FrankaRig, bool], object] = lambda rig, on: None
    seen_after: float = 0.0


def _changed(index: int, value: float) -> Callable[[Array], Array]:
    def change(setpoint: Array) -> Array:
        setpoint[index] = value
        return setpoint

    return change


def _end(rig: FrankaRig, on: bool) -> None:
    if on:
        rig.driver._arm.stop()


def _floor(rig: FrankaRig, on: bool) -> None:
    """A stiff floor, 10 mm above the tip: it pushes the tip out, with 30 N at first."""
    height = float(rig.position[2] + rig.settings.table[2] + 0.01)
    rig.franka.set(wall_height=height if on else -1.0, wall_stiffness=3000.0 if on else 0.0)


KINDS: dict[str, FrankaFault] = {
    "collision reflex": FrankaFault(ArmFault.REFLEX, {"reflex": 6}),
    "velocity reflex": FrankaFault(ArmFault.REFLEX, {"reflex": 3}),
    "stopped by a person at the robot": FrankaFault(
        ArmFault.USER_STOPPED, {"user_stopped": True}, {"user_stopped": False}
    ),
    "velocities are not numbers": FrankaFault(ArmFault.BAD_READING, {"nan": True}, {"nan": False}),
    "meets something hard": FrankaFault(ArmFault.FORCE, act=_floor),
    "motion ends by itself": FrankaFault(ArmFault.ENDED, act=_end),
    "emergency stop": FrankaFault(ArmFault.EMERGENCY_STOP, act=lambda rig, on: rig.driver.emergency_stop(on)),
    "set-points stop": FrankaFault(ArmFault.SETPOINTS_LOST, setpoint=lambda _: None, seen_after=SETTINGS.stop_after),
    "position is not a number": FrankaFault(ArmFault.BAD_SETPOINT, setpoint=_changed(1, np.nan)),
    "velocity is not a number": FrankaFault(ArmFault.BAD_SETPOINT, setpoint=_changed(5, np.inf)),
    "set-point jumps": FrankaFault(ArmFault.JUMP, setpoint=lambda setpoint: setpoint + 0.1 * np.eye(6)[2]),
    "set-point leaves the workspace": FrankaFault(ArmFault.WORKSPACE, setpoint=_changed(0, 0.5)),
    "set-point too fast": FrankaFault(ArmFault.FAST_SETPOINT, setpoint=_changed(3, -0.6)),
    "three of four states lost": FrankaFault(ArmFault.NONE, {"drop": 4}, {"drop": 1}),
    "pushed gently": FrankaFault(ArmFault.NONE, {"push": (0.0, 8.0, 8.0)}, {"push": (0.0, 0.0, 0.0)}),
}


_BUSY = 0.15  # [s] that a busy machine may take to see a fault, beyond the kind's own time


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """The arm, its driver and its set-points; zero means at rest."""
    load_franky()
    with EmulatedFranka() as arm:
        for kind in KINDS:
            yield try_fault(kind, arm, moments)


def try_fault(name: str, franka: EmulatedFranka, moments: int = 50) -> Row:
    """Bring about one kind of fault at random moments, with a person who asks for control again after each.

    Args:
        name: of one of `KINDS`.
        franka: an emulated arm.
        moments: how many.
    """
    kind, rng = KINDS[name], np.random.default_rng([0, list(KINDS).index(name)])
    goes_on = kind.fault is ArmFault.NONE
    allowed = kind.seen_after + SETTINGS.stop_within + _BUSY
    slowest, wrong = 0.0, list[str]()
    rig = FrankaRig(franka)
    try:
        for moment in range(moments):
            if not _follows(rig):
                wrong.append(f"{moment}: it does not follow: {describe_fault(rig.fault)}")
                break
            wait = rng.uniform(0.0, 0.2)
            rig.go(wait, rig.circle)
            begun = franka.set(**kind.world)["ticks"]
            kind.act(rig, True)

            def commanded(elapsed: float, wait: float = wait) -> Array | None:
                """The set-points of the circle that began before the fault, as this kind makes them."""
                return kind.setpoint(rig.circle(wait + elapsed))

            rest = 1e-3 * rig.ticks_to_rest(begun, commanded, 0.3 if goes_on else 2.0 * allowed)
            rig.until(lambda: rig.fault == kind.fault, 0.2, commanded)
            if not goes_on:
                slowest = max(slowest, rest)
                if not rest <= allowed:
                    wrong.append(f"{moment}: at rest after {rest:.3f} s")
            if rig.fault != kind.fault or rig.following != goes_on:
                wrong.append(f"{moment}: reported: {describe_fault(rig.fault)}")
            franka.set(**kind.after)
            kind.act(rig, False)
            if goes_on:
                rig.driver.emergency_stop()
                rig.ticks_to_rest(0)
                rig.driver.emergency_stop(False)
            rig.go(0.1)
            if franka.get()["moving"]:
                wrong.append(f"{moment}: it went on by itself")
        else:
            if not _follows(rig):
                wrong.append(f"at the end: it does not follow: {describe_fault(rig.fault)}")
    finally:
        rig.driver.close()
    after = (np.nan, np.nan) if goes_on else (slowest, allowed)
    return Row(name, "franka", moments, zero_after=after[0], allowed=after[1], wrong=tuple(wrong))


def _follows(rig: FrankaRig) -> bool:
    """Whether an arm at rest gives control to a person who asks; from its start, or it would drift out of its box."""
    if rig.franka.get()["moving"]:
        return False  # and put back to its start in the midst of a motion, the emulated arm would never end it
    rig.franka.reset()
    rig.go(0.05)
    return rig.follow()
