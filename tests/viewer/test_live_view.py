"""The live view shows the run's latest values, changes none of them, and nothing that befalls it stops the run."""

import os
import resource
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browsers import stream
from packed import is_drawn, samples, transform
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import Station, build_station
from mmt_drake.recording import load
from mmt_drake.systems import live_view
from mmt_drake.systems.live_view import LiveView
from mmt_drake.viewer import charts
from mmt_drake.viewer.viewer import Viewer

SCENARIO = "setup1-learning"  # it has all there is to be seen


@pytest.fixture
def every_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures as often as samples, however fast the run is."""
    monkeypatch.setattr(live_view, "FRAME_INTERVAL", 0.0)


def station(viewer: Viewer | None, **options: Any) -> Station:
    return build_station(load_scenario(SCENARIO), meshcat=viewer, **options)


def test_what_is_drawn_and_charted_is_what_is_recorded(viewer: Viewer, every_frame: None, tmp_path: Path) -> None:
    seconds = 2.5
    station(viewer, record=tmp_path / "a.mcap").simulate(seconds)
    found = load(tmp_path / "a.mcap")
    last = {name: found.vector(name)[-1] for name in ("position", "force", "rendered_force", "master_position")}
    assert found["detected_contact"][-1] == 1.0  # the scene shows a touch

    def at(path: str) -> Any:
        return transform(viewer, f"/station/{path}")

    np.testing.assert_allclose(at("probe")[:3, 3], last["position"])
    np.testing.assert_allclose(at("hand")[:3, 3], last["master_position"])
    np.testing.assert_allclose(at("proxy")[:3, 3], found.vector("proxy_position")[-1])
    np.testing.assert_allclose(at("force/measured")[:3, 2], 0.01 * last["force"])
    np.testing.assert_allclose(at("force/rendered")[:3, 2], 0.01 * last["rendered_force"])
    np.testing.assert_allclose(at("object")[:2, 3], [found["body_position_x"][-1], found["body_position_y"][-1]])
    normal = at("normal")[:3, 2]
    np.testing.assert_allclose(normal / np.linalg.norm(normal), [0.0, 0.0, 1.0], atol=0.05)  # a flat top

    row = dict(zip(charts.COLUMNS, samples(viewer)[-1], strict=True))
    assert row.pop("time") == pytest.approx(seconds)
    row["detected_contact"] = row.pop("in_contact")
    assert all(np.isnan(row.pop(name)) for name in ("carried_state", "carried_m"))  # there is no grip
    for name, value in row.items():
        np.testing.assert_array_equal(value, found[name][-1], err_msg=name)


def test_every_sample_reaches_the_charts_however_fast_the_run(viewer: Viewer, monkeypatch: Any) -> None:
    sent: list[Any] = []
    flush = viewer.flush

    def send() -> None:
        flush()
        sent.append(samples(viewer))

    monkeypatch.setattr(viewer, "flush", send)
    monkeypatch.setattr(live_view.time, "monotonic", iter(np.arange(0.0, 100.0, 0.007)).__next__)
    station(viewer).simulate(0.5)
    rows = np.concatenate(sent)
    np.testing.assert_allclose(rows[:, 0], np.arange(len(rows)) * live_view.SAMPLE_PERIOD, atol=1e-12)
    assert len(rows) >= 46 and len(sent) == pytest.approx(51 * 0.007 / live_view.FRAME_INTERVAL, abs=2)


def test_a_watched_run_gives_the_same_bytes(viewer: Viewer, every_frame: None, tmp_path: Path) -> None:
    recorded = []
    for name, shown in (("a", None), ("b", viewer)):
        station(shown, record=tmp_path / f"{name}.mcap").simulate(1.2)
        recorded.append((tmp_path / f"{name}.mcap").read_bytes())
    assert recorded[0] == recorded[1]


def test_what_is_not_connected_is_not_shown(viewer: Viewer, every_frame: None) -> None:
    view = LiveView(viewer)
    context = view.CreateDefaultContext()
    view.GetInputPort("motion").FixValue(context, [0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    simulator = Simulator(view, context)
    simulator.AdvanceTo(0.05)
    np.testing.assert_allclose(transform(viewer, "/station/hand")[:3, 3], [0.0, 0.1, 0.0])
    assert np.isnan(samples(viewer)[-1, 1:]).all()
    assert not is_drawn(viewer, "/station/cloud")


def test_a_viewer_that_dies_is_told_once_and_the_run_goes_on(viewer: Viewer, every_frame: None) -> None:
    view = LiveView(viewer)
    context = view.CreateDefaultContext()
    view.GetInputPort("motion").FixValue(context, np.zeros(6))
    simulator = Simulator(view, context)
    simulator.AdvanceTo(0.1)
    viewer._process.kill()
    viewer._process.wait()
    with pytest.warns(UserWarning, match="the viewer is gone, the run goes on: ") as told:
        simulator.AdvanceTo(1.0)
    assert len(told) == 1


def test_a_server_that_hangs_neither_holds_the_run_nor_fills_its_memory(viewer: Viewer, every_frame: None) -> None:
    view = LiveView(viewer)
    context = view.CreateDefaultContext()
    view.GetInputPort("motion").FixValue(context, np.zeros(6))
    os.kill(viewer._process.pid, signal.SIGSTOP)
    start = time.monotonic()
    try:
        Simulator(view, context).AdvanceTo(200.0)
    finally:
        os.kill(viewer._process.pid, signal.SIGCONT)
    assert time.monotonic() - start < 60.0
    assert len(viewer._unsent) < 1_000_000 and 0 < len(viewer._samples) <= 200_000


def test_a_browser_that_reads_nothing_or_breaks_off_neither_slows_the_run_nor_fills_its_memory(
    viewer: Viewer, every_frame: None
) -> None:
    shown = station(viewer)
    view = shown.diagram.GetSubsystemByName("live_view")
    context = view.GetMyContextFromRoot(shown.simulate(1.0).get_context())

    def cost(count: int) -> float:
        """Median over `count` publishes [s]."""
        took = []
        for _ in range(count):
            start = time.perf_counter()
            view._publish(context)
            took.append(time.perf_counter() - start)
        return float(np.median(took))

    alone = cost(300)
    stuck = stream(viewer.url, window=4096)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert cost(3000) < 5.0 * alone  # 3000 pictures: 100 s of a run
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before  # [kB]
    assert grown < 100_000
    stuck.close()
    assert cost(300) < 5.0 * alone
