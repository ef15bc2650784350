"""Each kind of fault at random moments of a session; what is watched is what the motors do."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.faults.emulated import emulated_omega
from mmt_drake.diagrams.faults.omega.kinds import KINDS
from mmt_drake.diagrams.faults.omega.rig import LIMITS, PERIOD, OmegaRig
from mmt_drake.diagrams.faults.row import Row
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety import STOP_WITHIN

_LONGER = 20  # ticks that are watched once the force must be zero


def try_omega(moments: int, folder: Path) -> Iterator[Row]:
    """The haptic device, its driver and whoever holds it."""
    device = emulated_omega(folder)
    for kind in KINDS:
        yield try_fault(kind, device, moments)


def try_fault(name: str, omega: EmulatedOmega, moments: int = 50, seed: int = 0) -> Row:
    """Bring about one kind of fault at random moments, with a person who arms again after each.

    Args:
        name: of one of `KINDS`.
        omega: an emulated device.
        moments: how many.
        seed: of the moments.
    """
    kind, rng = KINDS[name], np.random.default_rng([seed, list(KINDS).index(name)])
    allowed = kind.seen_after + STOP_WITHIN
    watched = round(allowed / PERIOD) + _LONGER
    omega.reset()
    rig = OmegaRig(omega)
    felt, greatest, slowest, wrong = 0, 0.0, 0.0, []
    moments = 1 if kind.once else moments
    for moment in range(moments):
        if not rig.arm():
            wrong.append(f"{moment}: cannot be armed: {rig.told()}")
            break
        rig.go(int(rng.integers(0, 40)))
        felt += bool(omega.vector("applied").any())
        start = omega.get("simulated")
        omega.set(greatest_force=0.0, last_force_at=start)
        kind.start(rig)
        rig.go(watched)
        greatest = max(greatest, omega.get("greatest_force"))
        on_for = omega.get("last_force_at") - start
        slowest = max(slowest, on_for)
        if greatest > LIMITS.force * (1 + 1e-9) or omega.get("not_finite"):
            wrong.append(f"{moment}: a force of {greatest:.3g} N, or none that is a number, was sent")
        stopped = on_for <= allowed + 1e-9 and rig.status[0] == 0.0 and rig.status[1] in kind.reasons
        if stopped != bool(kind.reasons):
            wrong.append(f"{moment}: {rig.told()}, a force for {1e3 * on_for:.1f} ms")
        kind.stop(rig)
        if kind.reasons and rig.go(10).any():
            wrong.append(f"{moment}: it went on by itself")
    rig.close()
    if felt < moments // 2:
        wrong.append(f"at {felt} of {moments} moments was there a force: too few to show anything")
    stays = not kind.reasons
    return Row(
        kind=name,
        where="omega",
        moments=moments,
        greatest_force=greatest,
        force_limit=LIMITS.force,
        zero_after=np.nan if stays else slowest,
        allowed=np.nan if stays else allowed,
        wrong=tuple(wrong),
    )
