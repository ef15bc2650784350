"""Faults of device, driver and diagram at random moments, in a closed loop of the emulated handle and a stiff wall."""

import pytest

from mmt_drake.diagrams.proof.faults.omega import KINDS, OmegaFault, try_fault
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety.limits import STOP_WITHIN


@pytest.mark.parametrize("name", KINDS)
def test_motors_stay_within_limits_and_are_off_in_time(name: str, omega: EmulatedOmega) -> None:
    outcome = try_fault(name, omega, moments=50)
    assert not outcome.wrong, "\n".join(outcome.wrong)


def test_there_are_twenty_kinds_and_most_can_be_told_at_once() -> None:
    assert len(KINDS) >= 20
    assert sum(kind.seen_after <= 0.010 for kind in KINDS.values()) >= 18
    assert STOP_WITHIN == 0.020


def test_a_driver_that_does_not_stop_would_be_seen(omega: EmulatedOmega, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault that nobody reports: the force stays on, and the trial says so."""
    monkeypatch.setitem(KINDS, "nothing", OmegaFault(lambda rig: None, lambda rig: None, (2,)))
    outcome = try_fault("nothing", omega, moments=3)
    assert len(outcome.wrong) >= 3
