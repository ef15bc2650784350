"""What the supervisor lets through, what stops it, how fast, and who may start it again."""

from collections.abc import Callable

import numpy as np
import pytest

from mmt_drake.diagrams.proof.faults.supervisor import OLDEST, PERIOD, Bench, Inputs, armed_bench, ordinary, press
from mmt_drake.errors import BadInput
from mmt_drake.hw.safety import kernel
from mmt_drake.hw.safety.limits import STOP_WITHIN, SafetyLimits
from mmt_drake.hw.safety.reasons import Reason, describe


def given(**members: object) -> Callable[[Inputs], None]:
    """Inputs of which these members, or their parts, are so: `velocity` of the motion, or a whole vector."""

    def change(inputs: Inputs) -> None:
        for name, value in members.items():
            part = inputs.motion[3:] if name == "velocity" else getattr(inputs, name)
            part[:] = value

    return change


def stop(inputs: Inputs) -> None:
    inputs.switches[1] = 1.0


def test_before_a_person_arms_there_is_no_force() -> None:
    bench = Bench()
    assert not bench.run(500).any()
    assert bench.reason == Reason.NOT_ARMED


def test_what_is_well_passes_unchanged() -> None:
    bench = armed_bench()
    for _ in range(200):
        inputs = ordinary(bench.tick)
        np.testing.assert_array_equal(bench.step(inputs), inputs.command)
    assert bench.status[3] == 0  # nothing was limited


def test_the_force_comes_back_linearly_after_arming() -> None:
    bench = Bench(SafetyLimits(rise=0.2))
    bench.run(2)
    press_now = ordinary(bench.tick)
    press(press_now)
    bench.step(press_now)
    gains = []
    for _ in range(220):
        bench.run(1)
        gains.append(bench.status[4])
    np.testing.assert_allclose(gains, np.minimum(1.0, (np.arange(220) + 2) * PERIOD / 0.2), atol=1e-12)


def test_a_switch_that_hangs_never_arms() -> None:
    bench = Bench()
    bench.run(500, press)
    assert not bench.armed


def test_force_is_limited_and_keeps_its_direction() -> None:
    bench = armed_bench(SafetyLimits(force=6.0, power=1e6))
    command = np.array([9.0, -12.0, 36.0])
    np.testing.assert_allclose(bench.run(5, given(command=command)), np.tile(command * 6.0 / 39.0, (5, 1)), rtol=1e-14)
    assert bench.armed and bench.status[3] == 1


@pytest.mark.parametrize("size", [1e3, 1e160, 1e300])
def test_a_wild_command_stays_within_the_limit(size: float) -> None:
    bench = armed_bench()
    assert np.linalg.norm(bench.run(10, given(command=size)), axis=1).max() <= 6.0 * (1 + 1e-12)


def test_the_power_given_to_the_hand_is_limited_and_the_power_taken_is_not() -> None:
    bench = armed_bench(SafetyLimits(power=0.5))
    moved = [0.4, 0.0, 0.0]
    given_power = bench.run(3, given(velocity=moved, command=[5.0, 0.0, 0.0]))
    np.testing.assert_allclose(given_power[:, 0], 0.5 / 0.4, rtol=1e-14)
    assert bench.status[3] == 2
    taken_power = bench.run(3, given(velocity=moved, command=[-5.0, 0.0, 0.0]))
    np.testing.assert_array_equal(taken_power[:, 0], -5.0)


def test_after_a_fault_the_force_falls_linearly_and_is_exactly_zero_in_time() -> None:
    bench = armed_bench(SafetyLimits(ramp=0.015))
    before = bench.run(1)[0]
    forces = bench.run(40, stop)
    left = np.maximum(0.0, 1.0 - np.arange(1, 41) * PERIOD / 0.015)
    np.testing.assert_allclose(forces, left[:, None] * before, atol=1e-12)
    assert not forces[15:].any()


def test_late_ticks_do_not_make_the_ramp_longer() -> None:
    """Ten times too slow by the device's clock: the ramp takes as long as ever by that clock."""
    bench = armed_bench(SafetyLimits(gap=0.050))
    start = bench.tick
    times = []
    for i in range(1, 10):
        inputs = ordinary(bench.tick)
        stop(inputs)
        inputs.device[1] = 1000.0 + start * PERIOD + 0.010 * i
        force = bench.step(inputs)
        times.append((0.010 * i, np.linalg.norm(force)))
    assert all(size == 0.0 for t, size in times if t >= STOP_WITHIN)


def test_the_ramp_obeys_the_power_limit() -> None:
    bench = armed_bench(SafetyLimits(power=0.5))
    bench.run(5, given(command=[2.0, 0.0, 0.0], velocity=0.0))
    let_go = given(switches=[0.0, 1.0], velocity=[0.9, 0.0, 0.0])
    assert (bench.run(20, let_go) @ [0.9, 0.0, 0.0]).max() <= 0.5 * (1 + 1e-12)


def test_only_a_fresh_press_after_the_fault_arms_again() -> None:
    bench = armed_bench()
    bench.run(50, given(switches=1.0))
    bench.run(50, press)  # the same press, held on after the fault has gone
    assert not bench.armed and bench.reason == Reason.EMERGENCY_STOP
    assert describe(bench.status) == "stopped: emergency stop; ready to arm"
    bench.run(2)
    bench.run(1, press)
    assert bench.armed and describe(bench.status) == "armed"


def test_nothing_arms_while_a_fault_is_there() -> None:
    bench = armed_bench()
    bench.run(30, stop)
    bench.run(50, given(switches=[1.0, 0.0], ages=[3.0, 0.03]))
    assert not bench.armed
    assert describe(bench.status, ("peer", "worker")) == "stopped: emergency stop; now peer is stale or lost"


@pytest.mark.parametrize("reason", [Reason.SPEED, Reason.WORKSPACE, Reason.STUCK, Reason.SILENT_DEVICE])
def test_what_is_wrong_with_the_hand_is_told_whatever_else_is_wrong(reason: Reason) -> None:
    """The arm that follows it knows of it by this alone."""
    bench = armed_bench()
    still = ordinary(bench.tick)

    def both(inputs: Inputs) -> None:
        inputs.command[:], inputs.ages[:] = np.nan, np.inf
        if reason == Reason.SPEED:
            inputs.motion[3] = 1.5
        elif reason == Reason.WORKSPACE:
            inputs.motion[2] = 0.3
        elif reason == Reason.STUCK:
            inputs.motion = still.motion
        else:
            inputs.device = still.device

    bench.run(200, both)
    assert bench.status[2] == reason


def test_a_clutch_may_hold_the_position_under_a_force() -> None:
    bench = armed_bench()
    held = ordinary(bench.tick).motion.copy()
    held[3:] = 0.0

    def clutch(inputs: Inputs) -> None:
        inputs.motion[:], inputs.device[2] = held, 1.0

    bench.run(400, clutch)
    assert bench.armed


def test_a_device_at_rest_that_makes_no_force_is_not_stuck() -> None:
    bench = armed_bench()
    rest = ordinary(bench.tick).motion.copy()
    rest[3:] = 0.0
    bench.run(1000, given(motion=rest, command=[0.0, 0.3, 0.0]))
    assert bench.armed


@pytest.mark.parametrize("stuck", [0.05, 0.1])
@pytest.mark.parametrize(
    ("force", "speed", "held"), [(0.49, 0.0, True), (0.51, 0.0, False), (0.0, 0.0099, True), (0.0, 0.0101, False)]
)
def test_a_position_is_stuck_after_its_time_where_half_a_newton_or_a_centimetre_a_second_should_move_it(
    stuck: float, force: float, speed: float, held: bool
) -> None:
    bench = armed_bench(SafetyLimits(stuck=stuck))
    rest = ordinary(bench.tick).motion.copy()
    rest[3:] = speed / np.sqrt(3.0)
    still = given(motion=rest, command=force / np.sqrt(3.0))
    bench.run(1, still)  # this is where it rests
    bench.run(round(stuck / PERIOD) - 1, still)
    assert bench.armed
    bench.run(2, still)
    assert bench.armed is held and (held or bench.reason == Reason.STUCK)


def test_rise_and_stuck_time_go_by_the_device_s_clock_where_that_is_ahead() -> None:
    bench = Bench(SafetyLimits(rise=0.2, stuck=0.1))
    rest = ordinary(0).motion

    def ahead(inputs: Inputs) -> None:
        inputs.motion = rest
        inputs.device[1] = 1000.0 + 4.0 * inputs.t  # four times as fast

    def held(inputs: Inputs) -> None:
        ahead(inputs)
        inputs.device[2] = 1.0  # by the clutch: it need not move yet
        press(inputs)

    bench.run(2, ahead)
    bench.run(30, held)
    assert bench.status[4] == pytest.approx(30 * 4.0 * PERIOD / bench.limits.rise)
    bench.run(24, ahead)
    assert bench.armed
    bench.run(3, ahead)
    assert bench.reason == Reason.STUCK


@pytest.mark.parametrize(("share", "jumps"), [(0.99, False), (1.01, True)])
def test_a_position_jumps_from_ten_times_the_speed_limit_on(share: float, jumps: bool) -> None:
    bench = armed_bench()
    before = ordinary(bench.tick - 1).motion

    def jump(inputs: Inputs) -> None:
        inputs.motion[:] = before
        inputs.motion[0] += share * 10.0 * bench.limits.speed * PERIOD

    bench.run(1, jump)
    assert (bench.reason == Reason.JUMP) is jumps and bench.armed is not jumps


def test_a_tick_that_takes_no_time_is_no_jump() -> None:
    """An output may be evaluated again at a time that has been, with what the device says by then."""
    bench = armed_bench()
    again = ordinary(bench.tick - 1)
    again.motion[0] += 1e-4
    bench.step(again)
    assert bench.armed


def test_every_stop_counts_once_however_long_it_lasts() -> None:
    bench = armed_bench()
    for stops in (1, 2, 3):
        bench.run(30, stop)
        bench.run(30, lambda inputs: inputs.ages.fill(9.0))  # another fault, while there is nothing to stop
        assert bench.status[5] == stops
        bench.arm()
        assert bench.armed and bench.status[5] == stops


def test_a_tick_writes_into_its_own_memory_alone() -> None:
    beyond = np.full(kernel.MEMORY_SIZE + 64, np.nan)
    bench = armed_bench()
    inputs = ordinary(bench.tick)
    vectors = inputs.command, inputs.motion, inputs.device, inputs.ages, inputs.switches
    for fault in (0.0, 1.0):
        inputs.switches[1] = fault
        out = beyond[: kernel.MEMORY_SIZE]
        kernel.supervise(bench.memory, inputs.t, *vectors, bench.limits.kernel_vector(), OLDEST, out)
        assert np.isfinite(out).all() and np.isnan(beyond[kernel.MEMORY_SIZE :]).all()


@pytest.mark.parametrize("name", ["force", "power", "speed", "gap", "stuck", "ramp", "rise"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_limit_is_positive_and_finite(name: str, value: float) -> None:
    with pytest.raises(BadInput, match=name):
        SafetyLimits(**{name: value})


@pytest.mark.parametrize(
    "limits, place",
    [
        ({"low": (0.0, 0.0, 0.3)}, "low, high"),
        ({"high": (0.2, 0.2, np.inf)}, "high: .*3 finite numbers"),
        ({"ramp": 0.021}, "ramp"),
    ],
)
def test_limits_that_limit_nothing_are_refused(limits: dict[str, object], place: str) -> None:
    with pytest.raises(BadInput, match=place):
        SafetyLimits(**limits)  # type: ignore[arg-type]


def test_every_reason_has_a_number_and_words_of_its_own_below_those_of_the_watched_ages() -> None:
    assert len({int(reason) for reason in Reason.__members__.values()}) == len(Reason.__members__)
    assert len({reason.words for reason in Reason}) == len(Reason) and max(Reason) == Reason.STALE
