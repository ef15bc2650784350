"""The paced loop: no tick early, none left out, everything taken down; the process given back as it was."""

import gc
import os
import resource
import sys
import time
from collections.abc import Callable

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, DiscreteValues, LeafSystem

from mmt_drake.errors import BadInput
from mmt_drake.realtime import Pace, PaceReport, ProcessOptions, advance_paced, real_time_process, warm
from mmt_drake.realtime.runner import wait_until

PERIOD = 2e-3


class Ticks(LeafSystem):
    """Takes down when its updates and publishes happen, by a clock."""

    def __init__(self, clock: Callable[[], int] = time.monotonic_ns, busy: Callable[[int], None] = lambda k: None):
        super().__init__()
        self.updates: list[tuple[float, int]] = []
        self.evaluations = 0
        self._clock, self._busy = clock, busy
        self.DeclareDiscreteState(1)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)
        self.DeclareVectorOutputPort("seen", 1, self._seen)

    def _update(self, context: Context, state: DiscreteValues) -> None:
        self.updates.append((context.get_time(), self._clock()))
        self._busy(len(self.updates))

    def _seen(self, context: Context, output: BasicVector) -> None:
        self.evaluations += 1


class Clock:
    """A clock that a test turns: every look at it takes a microsecond, sleeping as long as it should."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, oversleep: int = 0) -> None:
        self.now, self.sleeps = 10**9, []
        self.oversleep = oversleep
        monkeypatch.setattr("mmt_drake.realtime.runner.time.sleep", self.sleep)

    def __call__(self) -> int:
        self.now += 1000
        return self.now

    def sleep(self, seconds: float) -> None:
        self.sleeps.append(seconds)
        self.now += round(seconds * 1e9) + self.oversleep


def test_every_update_happens_at_its_time_in_order_and_none_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch)
    system, pace = Ticks(clock), Pace()
    simulator = Simulator(system)
    simulator.Initialize()
    advance_paced(simulator, 0.1, PERIOD, pace, clock=clock)
    assert [t for t, _ in system.updates] == pytest.approx(np.arange(50) * PERIOD)
    first = system.updates[0][1]
    for t, wall in system.updates:
        assert abs(wall - first - round(t * 1e9)) <= 5000
    assert simulator.get_context().get_time() == 0.1
    assert len(pace.late_s) == 50 and np.all(pace.late_s >= 0.0) and np.all(pace.late_s < 3e-6)
    assert pace.to_json()["overruns"] == 0
    assert np.allclose(pace.behind_s, -PERIOD, atol=1e-5)
    assert len(clock.sleeps) == 49  # the first is due at once


def test_a_sleep_ends_before_the_tick_is_due_and_spinning_does_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch, oversleep=150_000)
    due = clock.now + 2_000_000
    assert due <= wait_until(due, clock) <= due + 1000
    assert clock.sleeps == [pytest.approx(1.8e-3, abs=2e-6)]
    assert wait_until(due - 500_000, clock) < due + 10_000  # past: at once
    assert len(clock.sleeps) == 1


def test_a_tick_that_takes_too_long_is_an_overrun_and_is_made_up_for(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(monkeypatch)

    def busy(tick: int) -> None:
        clock.now += 5_000_000 if tick == 10 else 100_000

    system, pace = Ticks(clock, busy), Pace(ticks=4)
    simulator = Simulator(system)
    simulator.Initialize()
    advance_paced(simulator, 0.1, PERIOD, pace, clock=clock)
    told = pace.to_json()
    assert told["steps"] == 50 and told["overruns"] == 2  # the long one, and the next that began 3 ms late
    assert told["behind_worst_s"] == pytest.approx(3e-3, abs=1e-5)
    assert told["late_worst_s"] == pytest.approx(3e-3, abs=1e-5)
    assert np.flatnonzero(pace.behind_s > 0).tolist() == [9, 10]
    assert "overruns: 2 of 50 steps (4 %)" in pace.line() and "worst 3.0" in pace.line()


def test_by_the_real_clock_no_tick_begins_early_and_the_run_takes_as_long_as_it_says() -> None:
    system, pace = Ticks(), Pace()
    simulator = Simulator(system)
    simulator.Initialize()
    start = time.monotonic()
    advance_paced(simulator, 0.2, PERIOD, pace)
    assert time.monotonic() - start >= 0.2 - PERIOD
    first = system.updates[0][1]
    assert all(wall - first >= t * 1e9 - 5e6 for t, wall in system.updates)
    assert np.all(pace.late_s >= 0.0)


def test_a_run_ends_between_ticks_when_it_is_told_to_and_tells_where_it_is() -> None:
    system, pace, seen = Ticks(), Pace(), []
    simulator = Simulator(system)
    simulator.Initialize()
    advance_paced(
        simulator, 1.0, PERIOD, pace, ended=lambda: len(system.updates) >= 7, progress=seen.append,
        progress_interval=3 * PERIOD,
    )  # fmt: skip
    assert len(system.updates) == 7 and simulator.get_context().get_time() == pytest.approx(7 * PERIOD)
    assert seen == pytest.approx([3 * PERIOD, 6 * PERIOD])


def test_an_end_between_two_ticks_is_reached() -> None:
    simulator = Simulator(Ticks())
    simulator.Initialize()
    advance_paced(simulator, 2.5 * PERIOD, PERIOD, Pace())
    assert simulator.get_context().get_time() == 2.5 * PERIOD


def test_a_report_shows_how_late_the_present_tick_began_and_how_many_before_it_were_overruns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock, shown = Clock(monkeypatch), []

    def busy(tick: int) -> None:
        shown.append([report.GetOutputPort(name).Eval(inside)[0] for name in ("lateness", "overruns")])
        clock.now += 5_000_000 if tick == 10 else 100_000

    pace = Pace()
    builder = DiagramBuilder()
    ticks, report = builder.AddSystem(Ticks(clock, busy)), builder.AddSystem(PaceReport(pace))
    simulator = Simulator(builder.Build())
    inside = report.GetMyContextFromRoot(simulator.get_context())
    simulator.Initialize()
    advance_paced(simulator, 30 * PERIOD, PERIOD, pace, clock=clock)
    late, overruns = np.transpose(shown)
    np.testing.assert_array_equal(late, pace.late_s)
    assert late.max() > 2e-3 and len(ticks.updates) == 30
    np.testing.assert_array_equal(overruns, np.concatenate([[0], np.cumsum(pace.behind_s > 0.0)[:-1]]))


def test_without_a_tick_there_is_nothing_to_tell() -> None:
    assert Pace().to_json() == {} and "no step" in Pace().line()


@pytest.mark.parametrize("bad", [{"period": 0.0}, {"period": np.nan}])
def test_a_pace_that_makes_no_sense_is_refused(bad: dict[str, float]) -> None:
    simulator = Simulator(Ticks())
    with pytest.raises(BadInput, match=next(iter(bad))):
        advance_paced(simulator, 1.0, **({"period": PERIOD} | bad), pace=Pace())  # type: ignore[arg-type]


def test_warming_evaluates_outputs_and_changes_nothing() -> None:
    system = Ticks()
    simulator = Simulator(system)
    simulator.Initialize()
    warm(simulator)
    assert system.evaluations >= 10 and not system.updates
    assert simulator.get_context().get_time() == 0.0


# ---------------------------------------------------------------------------------------------------------- process
def state() -> tuple[object, ...]:
    return (
        gc.isenabled(), gc.get_freeze_count(), os.sched_getscheduler(0), os.sched_getparam(0).sched_priority,
        os.sched_getaffinity(0), resource.getrlimit(resource.RLIMIT_MEMLOCK), sys.getswitchinterval(),
    )  # fmt: skip


def test_the_collector_is_off_meanwhile_and_everything_is_given_back_whatever_happens() -> None:
    before = state()
    cpu = min(os.sched_getaffinity(0))
    with pytest.raises(KeyboardInterrupt), real_time_process(ProcessOptions(cpu=cpu)) as done:
        assert not gc.isenabled() and gc.get_freeze_count() > 0 and sys.getswitchinterval() < 1e-3
        assert os.sched_getaffinity(0) == {cpu} and f"on processor {cpu}" in done
        raise KeyboardInterrupt
    assert state() == before


def test_priority_and_locked_memory_are_had_where_permitted_and_else_refused_in_one_line() -> None:
    before = state()
    for options, told in ((ProcessOptions(priority=1), "priority"), (ProcessOptions(lock_memory=True), "memory")):
        try:
            with real_time_process(options) as done:
                assert any(told in item for item in done)
                if options.priority:
                    assert os.sched_getscheduler(0) == os.SCHED_FIFO and os.sched_getparam(0).sched_priority == 1
        except BadInput as refused:
            assert "doctor" in str(refused)
        assert state() == before


def test_a_priority_that_is_not_permitted_is_refused_and_nothing_is_left_changed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def deny(*_: object) -> None:
        raise PermissionError

    before = state()
    monkeypatch.setattr(os, "sched_setscheduler", deny)
    with pytest.raises(BadInput, match=r"--priority.*doctor"), real_time_process(ProcessOptions(priority=50)):
        pass
    assert state() == before


def test_a_priority_is_taken_unasked_where_it_is_permitted_and_else_the_run_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[tuple[int, int]] = []
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(os, "sched_setscheduler", lambda _, policy, param: asked.append((policy, param.sched_priority)))
    with real_time_process(ProcessOptions()) as done:
        assert asked == [(os.SCHED_FIFO, 40)] and "real-time priority 40" in done
    asked.clear()
    with real_time_process(ProcessOptions(priority=0)) as done:
        assert not asked and not any("priority" in item for item in done)
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # the rest would have none
    with real_time_process(ProcessOptions()) as done:
        assert not asked and "no real-time priority on one processor" in done

    def deny(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(os, "sched_setscheduler", deny)
    with real_time_process(ProcessOptions()) as done:
        assert any("not permitted" in item and "doctor" in item for item in done)


@pytest.mark.parametrize("priority", [100, -1])
def test_a_priority_that_does_not_exist_is_refused(priority: int) -> None:
    with pytest.raises(BadInput, match="1 to 99"):
        ProcessOptions(priority=priority)


def test_a_processor_that_is_not_there_is_refused() -> None:
    with pytest.raises(BadInput, match="--cpu"), real_time_process(ProcessOptions(cpu=10_000)):
        pass
