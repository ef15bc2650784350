"""What the trials of single parts found: the supervisor's kernel, and both drivers against their emulated devices."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from mmt_drake.diagrams.faults.emulated import emulated_omega
from mmt_drake.diagrams.faults.row import Row
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.sdk import load_franky
from mmt_drake.hw.franka.trial import kinds as franka_kinds
from mmt_drake.hw.franka.trial import run as franka
from mmt_drake.hw.omega.trial import kinds as omega_kinds
from mmt_drake.hw.omega.trial import rig as omega_rig
from mmt_drake.hw.omega.trial import run as omega
from mmt_drake.hw.safety.trial import kinds as supervisor_kinds
from mmt_drake.hw.safety.trial import run as supervisor
from mmt_drake.hw.safety.trial.session import LIMITS


def try_supervisor(moments: int, folder: Path) -> Iterator[Row]:
    """Numbers on the supervisor's inputs."""
    session = supervisor.ordinary_session()
    for kind in supervisor_kinds.KINDS:
        found = supervisor.try_fault(kind, session, moments)
        greatest, limit = found.greatest_force, LIMITS.force
        yield Row(
            kind, "supervisor", found.moments, greatest, limit, found.zero_after, found.allowed, wrong=found.wrong
        )


def try_omega(moments: int, folder: Path) -> Iterator[Row]:
    """The haptic device, its driver and whoever holds it."""
    device = emulated_omega(folder)
    for kind in omega_kinds.KINDS:
        found = omega.try_fault(kind, device, moments)
        greatest, limit = found.greatest_force, omega_rig.LIMITS.force
        yield Row(kind, "omega", found.moments, greatest, limit, found.zero_after, found.allowed, wrong=found.wrong)


def try_franka(moments: int, folder: Path) -> Iterator[Row]:
    """The arm, its driver and its set-points; zero means at rest."""
    load_franky()
    with EmulatedFranka() as arm:
        for kind in franka_kinds.KINDS:
            found = franka.try_fault(kind, arm, moments)
            rest, allowed = found.rest_after, found.allowed
            yield Row(kind, "franka", found.moments, zero_after=rest, allowed=allowed, wrong=found.wrong)
