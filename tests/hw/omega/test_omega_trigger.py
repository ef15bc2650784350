"""The trigger of an Omega.7: what it stands for, its spring, and that this is gone with every other force."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from mmt_drake.diagrams.proof.faults.omega import SETTINGS, OmegaRig
from mmt_drake.errors import BadInput
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.omega.settings import OmegaSettings, Trigger

TRIGGER = Trigger(open=0.02, closed=0.005, grip=12.0, stiffness=200.0, force=2.0)


@pytest.fixture
def rig(omega: EmulatedOmega) -> Iterator[OmegaRig]:
    rig = OmegaRig(omega, replace(SETTINGS, clutch_button=None, trigger=TRIGGER))
    yield rig
    rig.close()


def grip(rig: OmegaRig) -> float:
    context = rig.operator.GetMyContextFromRoot(rig.simulator.get_context())
    return float(rig.operator.GetOutputPort("grip").Eval(context)[0])


def test_fingers_close_it_against_its_spring_and_it_opens_again(rig: OmegaRig) -> None:
    assert rig.arm()
    assert grip(rig) == 0.0
    rig.omega.set(squeeze=1.0)
    rig.go(400)
    # 200 N/m from 20 mm on balance 1 N at 15 mm: a third of the way.
    assert rig.omega.get("gap") == pytest.approx(0.015, abs=1e-4)
    assert grip(rig) == pytest.approx(4.0, abs=0.1)
    rig.omega.set(squeeze=5.0)
    rig.go(400)
    assert grip(rig) == 12.0
    assert rig.omega.get("applied_grip") == rig.omega.get("greatest_grip") == 2.0
    rig.omega.set(squeeze=0.0)
    rig.go(400)
    assert grip(rig) < 0.2


@pytest.mark.parametrize("fault", [{"nan_position": 1.0}, {"nan_gap": 1.0}, {"connected": 0.0}, {"force_button": 1.0}])
def test_its_spring_is_gone_within_20_ms_of_a_fault_and_the_grip_stays(rig: OmegaRig, fault: dict[str, float]) -> None:
    assert rig.arm()
    rig.omega.set(squeeze=1.0)
    rig.go(400)
    held = grip(rig)
    assert rig.omega.get("applied_grip") > 0.5
    rig.omega.set(**fault)
    rig.go(20)
    assert rig.omega.get("applied_grip") == 0.0
    if "force_button" not in fault:
        assert grip(rig) == held


def test_there_is_no_spring_before_a_person_arms_it_and_none_after_the_end(rig: OmegaRig) -> None:
    rig.omega.set(squeeze=1.0)
    rig.go(100)
    assert rig.omega.get("greatest_grip") == 0.0
    assert rig.arm()
    rig.go(200)
    assert rig.omega.get("applied_grip") > 0.5
    rig.close()
    rig.omega.advance(0.01)
    assert rig.omega.get("applied_grip") == 0.0


def test_its_force_follows_the_gain_and_what_is_no_number_makes_none() -> None:
    assert TRIGGER.spring_at(0.015, 1.0) == pytest.approx(1.0)
    assert TRIGGER.spring_at(0.015, 0.5) == pytest.approx(0.5)
    assert TRIGGER.spring_at(0.0, 1.0) == 2.0
    for gap, gain in ((float("nan"), 1.0), (0.01, float("nan")), (0.01, -1.0), (0.01, 2.0), (0.03, 1.0)):
        assert TRIGGER.spring_at(gap, gain) == 0.0


def test_a_trigger_that_is_a_button_or_closed_where_it_is_open_is_refused() -> None:
    with pytest.raises(BadInput, match="clutch_button"):
        OmegaSettings(trigger=Trigger())
    with pytest.raises(BadInput, match="closed"):
        Trigger(open=0.01, closed=0.02)
    with pytest.raises(BadInput, match="force"):
        Trigger(force=9.0)
