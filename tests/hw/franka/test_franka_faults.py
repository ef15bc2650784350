"""Faults of arm, link and set-points at random moments of a motion: rest in time, and a person to go on."""

import pytest

from mmt_drake.diagrams.proof.faults.franka import KINDS, FrankaFault, try_fault
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.faults import ArmFault


@pytest.mark.parametrize("name", KINDS)
def test_the_arm_is_at_rest_in_time_and_stays_there(name: str, franka: EmulatedFranka) -> None:
    outcome = try_fault(name, franka, moments=1)  # 50 of each: `mmt-drake bench faults`
    assert not outcome.wrong, "\n".join(outcome.wrong)


def test_a_driver_that_does_not_stop_would_be_seen(franka: EmulatedFranka, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(KINDS, "nothing", FrankaFault(ArmFault.REFLEX))
    outcome = try_fault("nothing", franka, moments=1)
    assert len(outcome.wrong) >= 2
