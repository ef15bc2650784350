"""Each kind of fault at random moments of a motion; what is watched is what the emulated arm does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.faults import Fault, describe_fault
from mmt_drake.hw.franka.trial.kinds import KINDS, Kind
from mmt_drake.hw.franka.trial.rig import SETTINGS, Rig

Array = NDArray[np.float64]

_BUSY = 0.15  # [s] that a busy machine may take to see a fault, beyond the kind's own time


@dataclass(frozen=True)
class Outcome:
    """What came of one kind of fault.

    Attributes:
        kind: its name.
        moments: at how many moments it was brought about.
        rest_after: longest time from a moment to rest, by the robot's clock [s]; NaN where the arm goes on.
        allowed: how long it may be [s]; NaN where the arm goes on.
        moved: greatest way of the tip from a moment to rest [m]; NaN where the arm goes on.
        wrong: what was not as it must be, a line each.
    """

    kind: str
    moments: int
    rest_after: float
    allowed: float
    moved: float
    wrong: tuple[str, ...]


def try_fault(name: str, franka: EmulatedFranka, moments: int = 50, seed: int = 0) -> Outcome:
    """Bring about one kind of fault at random moments, with a person who asks for control again after each.

    Args:
        name: of one of `KINDS`.
        franka: an emulated arm.
        moments: how many.
        seed: of the moments.
    """
    kind, rng = KINDS[name], np.random.default_rng([seed, list(KINDS).index(name)])
    goes_on = kind.told is Fault.NONE
    allowed = kind.seen_after + SETTINGS.stop_within + _BUSY
    slowest, furthest, wrong = 0.0, 0.0, []
    rig = Rig(franka)
    try:
        for moment in range(moments):
            if not _follows(rig):
                wrong.append(f"{moment}: it does not follow: {describe_fault(rig.fault)}")
                break
            wait = rng.uniform(0.0, 0.2)
            rig.go(wait, rig.circle)
            before = franka.set(**kind.world or {})
            kind.act(rig, True)
            rest, moved = _until_rest(rig, kind, wait, before, 0.3 if goes_on else 2.0 * allowed)
            rig.until(lambda: rig.fault == kind.told, 0.2, _bad(kind, rig, wait))
            if goes_on:
                if rig.fault or not rig.following:
                    wrong.append(f"{moment}: it stopped: {describe_fault(rig.fault)}")
            else:
                slowest, furthest = max(slowest, rest), max(furthest, moved)
                if not rest <= allowed:
                    wrong.append(f"{moment}: at rest after {rest:.3f} s")
                if rig.fault != kind.told:
                    wrong.append(f"{moment}: told: {describe_fault(rig.fault)}")
            franka.set(**kind.after or {})
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
    none = np.nan
    figures = (none, none, none) if goes_on else (slowest, allowed, furthest)
    return Outcome(name, moments, *figures, tuple(wrong))


def _follows(rig: Rig) -> bool:
    """Whether an arm at rest gives control to a person who asks; from its start, or it would drift out of its box."""
    if rig.franka.get()["moving"]:
        return False  # and put back to its start in the midst of a motion, the emulated arm would never end it
    rig.franka.reset()
    rig.go(0.05)
    return rig.follow()


def _bad(kind: Kind, rig: Rig, later: float) -> Callable[[float], Array | None]:
    """Set-points as this kind makes them, of the circle that began so long ago [s]."""
    return lambda elapsed: kind.setpoint(rig.circle(later + elapsed))


def _until_rest(rig: Rig, kind: Kind, later: float, before: dict[str, Any], within: float) -> tuple[float, float]:
    """Stream set-points until no motion runs; time [s] and way [m] from `before` on, by the robot."""
    told = before

    def rests() -> bool:
        nonlocal told
        told = rig.franka.get()
        return not told["moving"]

    rig.until(rests, within, _bad(kind, rig, later))
    moved = np.linalg.norm(np.subtract(told["position"], before["position"]))
    return 1e-3 * (told["ticks"] - before["ticks"]), float(moved)
