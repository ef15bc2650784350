"""Each kind of fault at random moments of a session; what is watched is what the motors do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.omega.trial.kinds import KINDS
from mmt_drake.hw.omega.trial.rig import LIMITS, PERIOD, Rig
from mmt_drake.hw.safety import STOP_WITHIN

_LONGER = 20  # ticks that are watched once the force must be zero


@dataclass(frozen=True)
class Outcome:
    """What came of one kind of fault.

    Attributes:
        kind: its name.
        moments: at how many moments it was brought about,
        felt: and at how many of them the motors were making a force.
        greatest_force: of the motors from each moment on, between ticks too [N].
        zero_after: the longest that a force was on after a moment [s]; NaN where it may stay on.
        allowed: how long it may be on [s]; NaN where it may stay.
        wrong: what was not as it must be, a line each.
    """

    kind: str
    moments: int
    felt: int
    greatest_force: float
    zero_after: float
    allowed: float
    wrong: tuple[str, ...]


def try_fault(name: str, omega: EmulatedOmega, moments: int = 50, seed: int = 0) -> Outcome:
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
    rig = Rig(omega)
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
    stays = not kind.reasons
    return Outcome(
        kind=name,
        moments=moments,
        felt=felt,
        greatest_force=greatest,
        zero_after=np.nan if stays else slowest,
        allowed=np.nan if stays else allowed,
        wrong=tuple(wrong),
    )
