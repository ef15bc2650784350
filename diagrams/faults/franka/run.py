"""Each kind of fault at random moments of a motion; what is watched is what the emulated arm does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagrams.faults.franka.kinds import KINDS, FrankaFault
from mmt_drake.diagrams.faults.franka.rig import SETTINGS, FrankaRig
from mmt_drake.diagrams.faults.row import Row
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.faults import ArmFault, describe_fault
from mmt_drake.hw.franka.sdk import load_franky

Array = NDArray[np.float64]

_BUSY = 0.15  # [s] that a busy machine may take to see a fault, beyond the kind's own time


def try_franka(moments: int, folder: Path) -> Iterator[Row]:
    """The arm, its driver and its set-points; zero means at rest."""
    load_franky()
    with EmulatedFranka() as arm:
        for kind in KINDS:
            yield try_fault(kind, arm, moments)


def try_fault(name: str, franka: EmulatedFranka, moments: int = 50, seed: int = 0) -> Row:
    """Bring about one kind of fault at random moments, with a person who asks for control again after each.

    Args:
        name: of one of `KINDS`.
        franka: an emulated arm.
        moments: how many.
        seed: of the moments.
    """
    kind, rng = KINDS[name], np.random.default_rng([seed, list(KINDS).index(name)])
    goes_on = kind.told is ArmFault.NONE
    allowed = kind.seen_after + SETTINGS.stop_within + _BUSY
    slowest, wrong = 0.0, []
    rig = FrankaRig(franka)
    try:
        for moment in range(moments):
            if not _follows(rig):
                wrong.append(f"{moment}: it does not follow: {describe_fault(rig.fault)}")
                break
            wait = rng.uniform(0.0, 0.2)
            rig.go(wait, rig.circle)
            begun = franka.set(**kind.world or {})["ticks"]
            kind.act(rig, True)
            rest = _until_rest(rig, kind, wait, begun, 0.3 if goes_on else 2.0 * allowed)
            rig.until(lambda: rig.fault == kind.told, 0.2, _bad(kind, rig, wait))
            if goes_on:
                if rig.fault or not rig.following:
                    wrong.append(f"{moment}: it stopped: {describe_fault(rig.fault)}")
            else:
                slowest = max(slowest, rest)
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
    after = (np.nan, np.nan) if goes_on else (slowest, allowed)
    return Row(name, "franka", moments, zero_after=after[0], allowed=after[1], wrong=tuple(wrong))


def _follows(rig: FrankaRig) -> bool:
    """Whether an arm at rest gives control to a person who asks; from its start, or it would drift out of its box."""
    if rig.franka.get()["moving"]:
        return False  # and put back to its start in the midst of a motion, the emulated arm would never end it
    rig.franka.reset()
    rig.go(0.05)
    return rig.follow()


def _bad(kind: FrankaFault, rig: FrankaRig, later: float) -> Callable[[float], Array | None]:
    """Set-points as this kind makes them, of the circle that began so long ago [s]."""
    return lambda elapsed: kind.setpoint(rig.circle(later + elapsed))


def _until_rest(rig: FrankaRig, kind: FrankaFault, later: float, begun: int, within: float) -> float:
    """Stream set-points until no motion runs; time [s] from tick `begun` on, by the robot."""
    told: dict[str, Any] = {}

    def rests() -> bool:
        nonlocal told
        told = rig.franka.get()
        return not told["moving"]

    rig.until(rests, within, _bad(kind, rig, later))
    return 1e-3 * float(told["ticks"] - begun)
