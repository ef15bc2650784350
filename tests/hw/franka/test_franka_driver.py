"""The driver against an emulated arm: it follows, feels, and comes to rest at every fault."""

import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mmt_drake.diagrams.proof.faults.franka import SETTINGS, FrankaRig
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.franka.arm import FrankaArm
from mmt_drake.hw.franka.driver import FrankaDriver
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.faults import ArmFault, describe_fault

#: Milliseconds of the robot from a fault to rest: the stop, and what a busy machine needs to see the fault.
REST = round(1e3 * SETTINGS.stop_within) + 150


def test_nothing_moves_before_a_person_asks_for_it(rig: FrankaRig) -> None:
    rig.go(0.3, lambda t: rig.off(0.05))
    assert rig.fault == ArmFault.NOT_IN_CONTROL and not rig.following
    assert not rig.franka.get()["moving"]
    np.testing.assert_allclose(rig.position, rig.home, atol=1e-4)


def test_a_turned_table_turns_everything(franka: EmulatedFranka) -> None:
    turned = replace(SETTINGS, address=franka.address, rotation=(0.0, 0.0, 90.0))
    base = np.array(franka.set(push=(3.0, 0.0, 0.0))["position"]) - SETTINGS.table
    with FrankaArm(turned) as arm:
        assert arm.read() is ArmFault.NONE
        np.testing.assert_allclose(arm.position, [base[1], -base[0], base[2]], atol=1e-5)
        np.testing.assert_allclose(arm.force, [0.0, -3.0, 0.0], atol=1e-5)


def test_the_robot_is_told_its_load(franka: EmulatedFranka) -> None:
    with FrankaArm(replace(SETTINGS, address=franka.address, load_mass=0.15, load_centre=(0.0, 0.0, 0.05))):
        np.testing.assert_allclose(franka.get()["load"], [0.15, 0.0, 0.0, 0.05])


def test_handing_over_and_taking_never_wait_even_when_the_robot_is_silent(rig: FrankaRig) -> None:
    assert rig.follow()
    rig.franka.set(silent=True)
    took = []
    for _i in range(300):
        began = time.perf_counter()
        rig.driver.send(rig.stay(0.0))
        rig.driver.latest  # noqa: B018
        took.append(time.perf_counter() - began)
        time.sleep(1e-3)
    assert np.median(took) < 50e-6 and np.percentile(took, 95) < 2e-3


def test_without_setpoints_it_holds_its_place_and_stops_in_the_stated_time(rig: FrankaRig) -> None:
    assert rig.follow()
    since = rig.franka.get()["ticks"]
    assert rig.until(lambda: not rig.following, 2.0, lambda t: None) and rig.fault == ArmFault.NONE
    held = rig.position
    assert rig.until(lambda: rig.fault == ArmFault.SETPOINTS_LOST, 2.0, lambda t: None)
    np.testing.assert_allclose(rig.position, held, atol=1e-3)
    assert rig.ticks_to_rest(since) <= 1e3 * rig.settings.stop_after + REST
    rig.go(0.3)
    assert rig.fault == ArmFault.SETPOINTS_LOST and not rig.following, "set-points alone do not start it again"
    assert rig.follow()


def test_a_tip_that_is_dragged_too_fast_stops_the_arm(franka: EmulatedFranka) -> None:
    rig = FrankaRig(franka, tip_speed=0.02)
    try:
        assert rig.follow()
        franka.set(push=(0.0, 20.0, 0.0))
        assert rig.seen(ArmFault.SPEED)
    finally:
        rig.driver.close()


def test_an_emergency_stop_stops_it_and_refuses_control_until_it_is_undone(rig: FrankaRig) -> None:
    assert rig.follow()
    since = rig.franka.get()["ticks"]
    rig.driver.emergency_stop()
    assert rig.seen(ArmFault.EMERGENCY_STOP) and rig.ticks_to_rest(since) <= REST
    rig.driver.request_control()
    rig.go(0.2)
    rig.driver.emergency_stop(False)
    rig.go(0.2)
    assert rig.fault == ArmFault.EMERGENCY_STOP and not rig.franka.get()["moving"], "who asked meanwhile was refused"
    assert rig.follow() and rig.fault == ArmFault.NONE


@pytest.mark.parametrize("world", [{"reflex": 3, "unrecoverable": True}, {"user_stopped": True}])
def test_a_recovery_that_the_robot_refuses_is_told_and_may_be_tried_again(
    rig: FrankaRig, world: dict[str, Any]
) -> None:
    rig.franka.set(**world)
    expected = ArmFault.REFLEX if "reflex" in world else ArmFault.USER_STOPPED
    assert rig.seen(expected)
    rig.driver.request_control()
    rig.go(0.3)
    assert rig.fault == expected and not rig.following
    rig.franka.set(user_stopped=False, unrecoverable=False)
    assert rig.follow(), describe_fault(rig.fault)


def test_a_silent_robot_is_told_within_the_gap_and_connected_anew_when_a_person_asks(
    rig: FrankaRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert rig.follow()
    prepare, tried = FrankaArm.prepare, []
    monkeypatch.setattr(FrankaArm, "prepare", lambda arm: tried.append(prepare(arm)) or tried[-1])
    rig.franka.set(silent=True)
    began = time.monotonic()
    assert rig.seen(ArmFault.CONNECTION)
    assert time.monotonic() - began < rig.settings.gap + 0.3
    rig.driver.request_control()  # it cannot be: it is tried for a second or two
    assert rig.until(lambda: bool(tried), 5.0) and tried == [ArmFault.CONNECTION]
    rig.franka.set(silent=False)
    rig.go(0.3)
    assert rig.fault == ArmFault.CONNECTION, "nobody asked since"
    assert rig.follow() and rig.fault == ArmFault.NONE


def test_who_asked_long_ago_is_not_obeyed_any_more(rig: FrankaRig, monkeypatch: pytest.MonkeyPatch) -> None:
    prepare = FrankaArm.prepare

    def slow(arm: FrankaArm) -> ArmFault:
        time.sleep(0.4)
        return prepare(arm)

    with monkeypatch.context() as patch:
        patch.setattr(FrankaArm, "prepare", slow)
        patch.setattr("mmt_drake.hw.franka.driver._ASKED_WITHIN", 0.3)
        rig.driver.request_control()
        rig.go(0.7)
    assert rig.fault == ArmFault.NOT_IN_CONTROL and not rig.franka.get()["moving"]
    assert rig.follow()


def test_a_robot_that_dies_is_told_and_closing_does_not_wait_for_it(mortal_franka: EmulatedFranka) -> None:
    rig = FrankaRig(mortal_franka)
    assert rig.follow()
    mortal_franka.close()
    assert rig.seen(ArmFault.CONNECTION)
    rig.driver.request_control()
    rig.go(0.2)
    assert rig.fault == ArmFault.CONNECTION
    began = time.monotonic()
    rig.driver.close()
    assert time.monotonic() - began < 5.0


def test_closing_does_not_wait_for_a_robot_that_never_ends_its_motion(mortal_franka: EmulatedFranka) -> None:
    rig = FrankaRig(mortal_franka)
    assert rig.follow()
    mortal_franka.reset()  # in the midst of a motion, which the robot then has forgotten
    rig.go(0.05)
    began = time.monotonic()
    closing = threading.Thread(target=rig.driver.close, daemon=True)
    closing.start()
    closing.join(10.0)
    assert not closing.is_alive() and time.monotonic() - began < 5.0


def test_the_control_loop_stops_above_the_force_limit_without_any_help_from_python(franka: EmulatedFranka) -> None:
    with FrankaArm(replace(SETTINGS, address=franka.address)) as arm:
        assert arm.prepare() is ArmFault.NONE and arm.start() is ArmFault.NONE
        time.sleep(0.3)
        assert arm.in_control
        since = franka.set(push=(0.0, 0.0, 30.0))["ticks"]
        while (told := franka.get())["moving"] and told["ticks"] - since < 3000:
            time.sleep(2e-3)
        assert told["ticks"] - since <= REST


def test_without_a_thread_the_control_loop_holds_the_place(franka: EmulatedFranka) -> None:
    with FrankaArm(replace(SETTINGS, address=franka.address)) as arm:
        assert arm.prepare() is ArmFault.NONE and arm.start() is ArmFault.NONE
        before = arm.position.copy()
        time.sleep(0.6)
        assert arm.read() is ArmFault.NONE and arm.in_control
        np.testing.assert_allclose(arm.position, before, atol=4e-3)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_thread_that_fails_brings_the_arm_to_rest(franka: EmulatedFranka) -> None:
    failing = [False]

    def clock() -> float:
        if failing[0]:
            raise OSError("no clock")
        return time.monotonic()

    driver = FrankaDriver(replace(SETTINGS, address=franka.address), clock=clock)
    driver.request_control()
    for _ in range(1000):
        if franka.get()["moving"]:
            break
        time.sleep(2e-3)
    assert franka.get()["moving"]
    failing[0] = True
    driver.close()
    assert driver.latest.device[0] == ArmFault.CONNECTION and not franka.get()["moving"]


def test_a_stop_that_is_refused_is_told_again(rig: FrankaRig, monkeypatch: pytest.MonkeyPatch) -> None:
    assert rig.follow()
    arm, refused = rig.driver._arm, list[bool]()
    stop_motion = arm._stop_motion

    def refusing() -> Any:
        if not refused:
            refused.append(True)
            raise RuntimeError("refused")
        return stop_motion()

    monkeypatch.setattr(arm, "_stop_motion", refusing)
    rig.driver.emergency_stop()
    assert rig.seen(ArmFault.EMERGENCY_STOP) and refused
    assert rig.until(lambda: not rig.franka.get()["moving"], 5.0)


def test_closed_it_is_at_rest_and_says_so(rig: FrankaRig) -> None:
    assert rig.follow()
    rig.driver.close()
    assert not rig.franka.get()["moving"] and rig.fault == ArmFault.CONNECTION
    rig.driver.close()


def test_a_program_that_ends_without_a_word_brings_the_arm_to_rest(franka: EmulatedFranka) -> None:
    program = (
        "import time\n"
        "from mmt_drake.hw.franka.driver import FrankaDriver\n"
        "from mmt_drake.hw.franka.settings import FrankaSettings\n"
        f"driver = FrankaDriver(FrankaSettings('{franka.address}', realtime='ignore', gap=0.4, stop_after=2.0))\n"
        "driver.request_control()\n"
        "while not driver._arm.in_control: time.sleep(0.01)\n"
        "print('in control')\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=30)
    assert done.stdout == "in control\n" and done.stderr == "" and done.returncode == 0
    told = franka.get()
    assert not told["moving"] and np.abs(told["dq"]).max() < 0.02


def test_a_robot_that_is_not_there_is_told_in_one_line() -> None:
    pytest.importorskip("franky", reason="franky-control is not installed")
    with pytest.raises(DeviceError, match=r"^franka: cannot reach the robot at 127\.0\.0\.99: .* FCI mode") as error:
        FrankaArm(replace(SETTINGS, address="127.0.0.99"))
    assert "\n" not in str(error.value)


def test_pressed_into_a_floor_it_pushes_like_two_springs_in_a_row(rig: FrankaRig) -> None:
    """The floor's 1000 N/m and the tip's 1500 make 600; 20 mm deep that is 12 N."""
    assert rig.follow()
    height = float(rig.home[2] + SETTINGS.table[2])
    rig.franka.set(wall_height=height, wall_stiffness=1000.0)
    forces = []
    for depth in (0.01, 0.02):
        target = rig.off(0.0)
        target[2] -= depth
        rig.go(0.6, lambda t, target=target: target)
        # A machine that was busy for 20 ms has had the arm hold its place.
        assert rig.until(lambda: rig.following, 2.0, lambda t, target=target: target) and rig.fault == ArmFault.NONE
        forces.append(rig.driver.latest.force[2])
        felt = 1000.0 * (height - SETTINGS.table[2] - rig.position[2])
        assert forces[-1] == pytest.approx(felt, abs=0.2)
    assert forces[1] - forces[0] == pytest.approx(600.0 * 0.01, rel=0.4)  # the joints' friction holds some of it


def test_who_connects_is_scheduled_as_before(franka: EmulatedFranka) -> None:
    before = os.sched_getscheduler(0), os.sched_getparam(0).sched_priority
    FrankaArm(replace(SETTINGS, address=franka.address)).close()
    assert (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority) == before


def at_real_time() -> dict[int, int]:
    """The real-time priority of each of this process's threads that has one."""
    threads = [int(name) for name in os.listdir("/proc/self/task")]
    return {thread: os.sched_getparam(thread).sched_priority for thread in threads if os.sched_getscheduler(thread)}


def test_the_control_loop_has_the_highest_priority_and_no_other_thread_any(franka: EmulatedFranka) -> None:
    highest = os.sched_get_priority_max(os.SCHED_FIFO)
    with ThreadPoolExecutor(1) as thread:
        try:
            thread.submit(os.sched_setscheduler, 0, os.SCHED_FIFO, os.sched_param(highest)).result()
        except PermissionError:
            pytest.skip("no permission for real-time priority")
    before = at_real_time()  # the loop of a robot that never ended its motion waits as long as the process lives
    with FrankaArm(replace(SETTINGS, address=franka.address)) as arm:
        assert at_real_time().keys() <= before.keys()
        assert arm.prepare() is ArmFault.NONE and arm.start() is ArmFault.NONE
        assert [priority for thread, priority in at_real_time().items() if thread not in before] == [highest]
    assert at_real_time().keys() <= before.keys()
