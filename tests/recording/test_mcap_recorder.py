"""The recorder in a diagram: every tick once, exactly; clouds as asked; one run per recorder; cheap."""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.recording import load
from mmt_drake.systems.recorder import McapRecorder

SIGNALS = [("position", 3), ("force", 3), ("in_contact", 1)]


class Clock(LeafSystem):
    """Functions of time on the recorder's input, and a cloud of `points` points 30 times a second."""

    def __init__(self, points: int):
        super().__init__()
        self._base = Cloud(np.random.default_rng(0).uniform(-0.1, 0.1, (points, 3)))
        self.DeclareVectorOutputPort("signals", 7, self._signals)
        self.DeclareAbstractOutputPort("cloud", lambda: AbstractValue.Make(self._base), self._cloud)

    def _signals(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(values(context.get_time()))

    def _cloud(self, context: Context, output: AbstractValue) -> None:
        stamp = np.floor(context.get_time() * 30 + 1e-6) / 30
        output.set_value(self._base.moved((stamp, 0.0, 0.0), stamp))


def values(now: float) -> np.ndarray:
    return np.array([0.1 * np.sin(now), 0.1 * now, -1e-3, np.cos(now), 1 / 3, -now, now > 1.0])


def build(path: Path, points: int = 10, **options: object) -> tuple[Diagram, McapRecorder]:
    builder = DiagramBuilder()
    source = builder.AddSystem(Clock(points))
    recorder = builder.AddSystem(McapRecorder(path, SIGNALS, **options))
    builder.Connect(source.GetOutputPort("signals"), recorder.GetInputPort("signals"))
    builder.Connect(source.GetOutputPort("cloud"), recorder.GetInputPort("point_cloud"))
    return builder.Build(), recorder


def test_every_tick_is_in_the_file_once_and_exact(tmp_path: Path) -> None:
    diagram, recorder = build(tmp_path / "a.mcap")
    simulator = Simulator(diagram)
    simulator.Initialize()
    for end in (0.5, 0.5, 1.2345, 2.5):  # stops within ticks and at them
        simulator.AdvanceTo(end)
    recorder.close()
    recorder.close()
    read = load(tmp_path / "a.mcap")
    np.testing.assert_allclose(read.time, np.arange(2501) * 1e-3, atol=1e-9)
    expected = np.array([values(k * 1e-3) for k in range(2501)])
    np.testing.assert_allclose(read.vector("position"), expected[:, :3], rtol=1e-12)
    np.testing.assert_allclose(read.vector("force"), expected[:, 3:6], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(read["in_contact"], expected[:, 6])


def test_in_real_time_the_rows_are_those_of_the_ticks_in_order_with_their_clouds_however_slow_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, realtime in (("a", False), ("b", True)):
        diagram, recorder = build(tmp_path / f"{name}.mcap", realtime=realtime)
        write = recorder._writer.write_block

        def slowly(*block: Any, write: Callable[..., None] = write) -> None:
            time.sleep(0.2)
            write(*block)

        monkeypatch.setattr(recorder._writer, "write_block", slowly)
        Simulator(diagram).AdvanceTo(3.5)
        recorder.close()
    usual, by_the_clock = load(tmp_path / "a.mcap"), load(tmp_path / "b.mcap")
    np.testing.assert_array_equal(by_the_clock.time, usual.time[:-1])
    for name, column in by_the_clock.columns.items():
        if name not in by_the_clock.derived:
            np.testing.assert_array_equal(column, usual.columns[name][:-1], err_msg=name)
    assert [stamp for stamp, _ in by_the_clock.clouds] == [stamp for stamp, _ in usual.clouds]


def test_in_real_time_a_disk_that_refuses_ends_the_recording_and_not_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    diagram, recorder = build(tmp_path / "a.mcap", realtime=True, clouds="none", tell=told.append)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(2.5)
    recorder.settle()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recorder._writer, "_append", full)
    for second in range(3, 7):
        simulator.AdvanceTo(second)
        time.sleep(0.05)
    assert recorder.trouble is not None and "No space left on device" in str(recorder.trouble)
    recorder.close()
    assert len(told) == 1 and "the run goes on" in told[0] and "until 1.999 s is kept" in told[0]
    assert len(load(recorder.file.path)) == 2000 and recorder.dropped == 0
    assert str(recorder.file.path) in told[0] and not (tmp_path / "a.mcap").exists()


def test_in_real_time_a_disk_that_hangs_makes_a_gap_that_is_counted_and_no_tick_waits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    diagram, recorder = build(tmp_path / "a.mcap", realtime=True, clouds="full", tell=told.append)
    write, hangs, goes_on = recorder._writer.write_block, threading.Event(), threading.Event()

    def hang(*block: Any) -> None:
        hangs.set()
        goes_on.wait()
        write(*block)

    monkeypatch.setattr(recorder._writer, "write_block", hang)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(1.5)
    assert hangs.wait(30.0)  # taken before the queue is full, else its place is free once more and there are two gaps
    simulator.AdvanceTo(12.0)  # would never end if a tick waited
    goes_on.set()
    recorder.settle()
    simulator.AdvanceTo(13.0)
    recorder.close()
    read = load(tmp_path / "a.mcap")
    gaps = 12_999 - np.diff(read.time).size
    clouds = 13 * 30 - len(read.clouds)
    assert gaps > 0 and recorder.dropped == gaps + clouds and recorder.trouble is None
    assert np.diff(read.time).max() == pytest.approx((gaps + 1) * 1e-3) and read.time[-1] == pytest.approx(12.999)
    assert told == [f"{tmp_path / 'a.mcap'}: the disk is too slow: the recording has a gap"]


def test_in_real_time_the_end_waits_for_a_disk_that_gets_on_and_not_for_one_that_hangs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    goes_on = threading.Event()
    for name, waits in (("slow", lambda: time.sleep(0.15)), ("hangs", goes_on.wait)):
        told: list[str] = []
        diagram, recorder = build(tmp_path / f"{name}.mcap", realtime=True, clouds="none", tell=told.append)
        append = recorder._writer._append

        def late(data: bytes, append: Callable[[bytes], None] = append, waits: Callable[[], object] = waits) -> None:
            waits()
            append(data)

        monkeypatch.setattr(recorder._writer, "_append", late)
        recorder.patience = 0.6
        Simulator(diagram).AdvanceTo(4.5)
        recorder.close()  # in about 0.9 s, though no single task takes 0.6 s; or after that
        if name == "slow":
            assert recorder.trouble is None and not told and len(load(tmp_path / "slow.mcap")) == 4500
        else:
            assert len(told) == 1 and "the end of the recording is lost" in told[0] and "0.6 s" in told[0]
            assert recorder.trouble is not None
    goes_on.set()


def test_the_first_row_is_written_once_when_a_simulator_is_initialised_twice(tmp_path: Path) -> None:
    diagram, recorder = build(tmp_path / "a.mcap")
    simulator = Simulator(diagram)
    simulator.Initialize()
    simulator.Initialize()
    simulator.AdvanceTo(0.01)
    recorder.close()
    assert len(load(tmp_path / "a.mcap")) == 11


def again(recorder: McapRecorder) -> None:
    pass


@pytest.mark.parametrize(
    ("between", "found"), [(again, "time going back from 0.1 to 0 s"), (McapRecorder.close, "a row after the end")]
)
def test_a_second_run_is_refused(between: Callable[[McapRecorder], None], found: str, tmp_path: Path) -> None:
    diagram, recorder = build(tmp_path / "a.mcap")
    Simulator(diagram).AdvanceTo(0.1)
    between(recorder)
    with pytest.raises(BadInput, match=found):
        Simulator(diagram).AdvanceTo(0.1)
    recorder.close()
    assert len(load(tmp_path / "a.mcap")) == 101  # the first run is whole


@pytest.mark.parametrize(
    ("policy", "stamps", "points"),
    [("light", [0.0, 1.0, 2.0], 4000), ("full", np.arange(76) / 30, 12_000), ("none", [], 0)],
)
def test_clouds_are_recorded_as_asked(policy: str, stamps: list[float], points: int, tmp_path: Path) -> None:
    diagram, recorder = build(tmp_path / "a.mcap", points=12_000, clouds=policy)
    Simulator(diagram).AdvanceTo(2.5)
    recorder.close()
    clouds = load(tmp_path / "a.mcap").clouds
    np.testing.assert_allclose([stamp for stamp, _ in clouds], stamps, atol=1e-9)
    assert all(len(cloud) == points for _, cloud in clouds)
    if clouds:  # the surface moves: 1 m/s along x
        moved = clouds[-1][1][0] - clouds[0][1][0]
        np.testing.assert_allclose(moved, [clouds[-1][0], 0.0, 0.0], atol=1e-6)


def test_what_was_recorded_is_there_while_the_run_goes_on(tmp_path: Path) -> None:
    diagram, _ = build(tmp_path / "a.mcap")
    Simulator(diagram).AdvanceTo(3.5)
    time.sleep(0.2)
    read = load(tmp_path / "a.part.mcap")
    assert len(read) == 3000 and any("cut off" in note for note in read.notes)


@pytest.mark.parametrize("realtime", [False, True])
def test_a_cloud_from_before_the_run_is_recorded_at_its_beginning(realtime: bool, tmp_path: Path) -> None:
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource(values(0.0)))
    seen = Cloud(np.eye(3)).moved((0.0, 0.0, 0.0), -0.05)  # as a camera stamps what it has seen
    camera = builder.AddSystem(ConstantValueSource(AbstractValue.Make(seen)))
    recorder = builder.AddSystem(McapRecorder(tmp_path / "a.mcap", SIGNALS, clouds="full", realtime=realtime))
    builder.Connect(source.get_output_port(), recorder.GetInputPort("signals"))
    builder.Connect(camera.get_output_port(), recorder.GetInputPort("point_cloud"))
    Simulator(builder.Build()).AdvanceTo(0.05)
    recorder.close()
    assert recorder.trouble is None
    assert [(stamp, len(points)) for stamp, points in load(tmp_path / "a.mcap").clouds] == [(0.0, 3)]


def test_the_cloud_port_may_stay_open(tmp_path: Path) -> None:
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource([0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0]))
    recorder = builder.AddSystem(McapRecorder(tmp_path / "a.mcap", SIGNALS, clouds="full"))
    builder.Connect(source.get_output_port(), recorder.GetInputPort("signals"))
    Simulator(builder.Build()).AdvanceTo(0.05)
    recorder.close()
    assert len(load(tmp_path / "a.mcap")) == 51


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"signals": [("positon", 3)]}, "did you mean"),
        ({"signals": SIGNALS, "clouds": "some"}, "found 'some', expected 'none', 'light' or 'full'"),
        ({"signals": SIGNALS, "period": 0.0}, "period: found 0.0"),
    ],
)
def test_settings_that_make_no_sense_leave_no_file(options: dict[str, object], message: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=message):
        McapRecorder(tmp_path / "a.mcap", **options)
    assert list(tmp_path.iterdir()) == []


class Rows(LeafSystem):
    """The least that a recorder in Python can do: read its input at each tick and keep it."""

    def __init__(self, size: int) -> None:
        super().__init__()
        self._rows: list[np.ndarray] = []
        self.DeclareVectorInputPort("signals", size)
        self.DeclarePeriodicPublishEvent(1e-3, 0.0, self._record)

    def _record(self, context: Context) -> None:
        self._rows.append(self.GetInputPort("signals").Eval(context))


def seconds(system: LeafSystem, size: int) -> float:
    """Wall time of 10 s of simulation with the system behind a source of as many ones."""
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantVectorSource(np.ones(size)))
    builder.AddSystem(system)
    builder.Connect(source.get_output_port(), system.GetInputPort("signals"))
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    begin = time.perf_counter()
    simulator.AdvanceTo(10.0)
    return time.perf_counter() - begin


def test_recording_costs_little_more_than_reading_the_signals(tmp_path: Path) -> None:
    signals = [("position", 3), ("force", 3), ("velocity", 3), ("theta", 10), ("estimated_force", 3), ("in_contact", 1)]
    recorder = McapRecorder(tmp_path / "a.mcap", signals, clouds="none")
    took = seconds(recorder, 23)
    recorder.close()
    assert took < 4.0 * seconds(Rows(23), 23)  # 1.1 on a quiet machine, encoding included
