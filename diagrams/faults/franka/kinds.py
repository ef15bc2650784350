"""Kinds of fault that the emulated arm, its link and its set-points can have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagrams.faults.franka.rig import SETTINGS, FrankaRig
from mmt_drake.hw.franka.faults import ArmFault

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FrankaFault:
    """One kind of fault.

    Attributes:
        told: as which fault; `ArmFault.NONE` where the arm goes on.
        world: members of the emulated arm that bring it about,
        after: and that take it away.
        setpoint: what becomes of a set-point (6); None sends none.
        act: what else happens, or its undoing (False).
        seen_after: how long it may take until it is seen [s].
    """

    told: ArmFault
    world: dict[str, Any] | None = None
    after: dict[str, Any] | None = None
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


_NO_PUSH = {"push": (0.0, 0.0, 0.0)}

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
    "set-point jumps": FrankaFault(
        ArmFault.JUMP, setpoint=lambda setpoint: setpoint + np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    ),
    "set-point leaves the workspace": FrankaFault(ArmFault.WORKSPACE, setpoint=_changed(0, 0.5)),
    "set-point too fast": FrankaFault(ArmFault.FAST_SETPOINT, setpoint=_changed(3, -0.6)),
    "three of four states lost": FrankaFault(ArmFault.NONE, {"drop": 4}, {"drop": 1}),
    "pushed gently": FrankaFault(ArmFault.NONE, {"push": (0.0, 8.0, 8.0)}, _NO_PUSH),
}
