"""A recording in the live view: it plays while somebody looks, goes where its slider is moved, and loops."""

import time
from pathlib import Path

import numpy as np
import pytest
from browsers import move, status, stream
from packed import is_drawn, transform

import mmt_drake as mmt
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import THETA
from mmt_drake.recording import Recording
from mmt_drake.viewer.charts import COLUMNS, page
from mmt_drake.viewer.replay import LOOP, PLAY, SPEED, TIME, Replay, replay_panels
from mmt_drake.viewer.viewer import Viewer

SECONDS = 1.5


class Hand:
    """A replay whose clock and sliders a test turns."""

    def __init__(self, viewer: Viewer, recording: Recording) -> None:
        self.now, self.viewer = 0.0, viewer
        self.replay = Replay(viewer, recording, lambda: self.now)
        self.shown: list[list[float]] = []
        self.width = len(replay_panels(recording).columns)
        self._keep()
        viewer.looking = 1

    def step(self, seconds: float = 0.0, **sliders: float) -> float:
        """Where it is after so long, sliders having been moved before."""
        self.viewer.values |= {{"time": TIME}.get(name, name): value for name, value in sliders.items()}
        self.now += seconds
        self.replay.step()
        self._keep()
        return self.replay.at

    def _keep(self) -> None:
        message = self.viewer.drawn.pop(("samples",), None)
        if message is not None:
            rows = np.frombuffer(message["samples"]).reshape(-1, self.width).tolist()
            self.shown = rows if message["fresh"] else self.shown + rows


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return mmt.run("setup1", seconds=SECONDS, record=tmp_path_factory.mktemp("replay") / "a.mcap")


@pytest.fixture
def hand(viewer: Viewer, recording: Recording) -> Hand:
    """A replay of it."""
    return Hand(viewer, recording)


def test_it_plays_by_the_clock_times_its_speed_and_only_while_somebody_looks(hand: Hand) -> None:
    assert hand.step(0.5) == pytest.approx(0.5)
    assert hand.step(0.1, speed=4.0) == pytest.approx(0.9)
    hand.viewer.looking = 0
    assert hand.step(10.0) == pytest.approx(0.9)
    hand.viewer.looking = 1
    assert hand.step(0.1, play=0.0) == pytest.approx(0.9)
    assert hand.step(10.0) == pytest.approx(0.9)
    assert hand.step(0.01, play=1.0) == pytest.approx(0.94)


def test_at_its_end_it_stops_and_begins_anew_when_played_again_or_looped(hand: Hand, recording: Recording) -> None:
    end = recording.time[-1]
    assert hand.step(5.0) == end and hand.viewer.values[PLAY] == 0.0
    assert hand.step(5.0) == end
    assert hand.step(0.1, play=1.0) == 0.0 and hand.step(0.2) == pytest.approx(0.2)
    assert hand.step(5.0, loop=1.0) == 0.0 and hand.viewer.values[PLAY] == 1.0
    assert [row[0] for row in hand.shown] == [0.0]  # the charts too


def test_a_moved_slider_takes_it_there_with_the_charts_of_the_time_before(hand: Hand, recording: Recording) -> None:
    hand.step(0.3)
    assert hand.step(0.0, time=1.2, play=0.0) == 1.2
    times = [row[0] for row in hand.shown]
    np.testing.assert_allclose(times, np.arange(0.0, 1.2 + 1e-9, 0.01), atol=1e-9)
    assert hand.step(0.0, time=0.7) == 0.7
    np.testing.assert_allclose([row[0] for row in hand.shown], np.arange(0.0, 0.7 + 1e-9, 0.01), atol=1e-9)


def test_what_is_drawn_and_charted_is_the_recording(hand: Hand, recording: Recording) -> None:
    hand.step(0.0, time=1.2, play=0.0)
    row = int(np.argmin(np.abs(recording.time - 1.2)))
    for name, column in (("probe", "position"), ("hand", "master_position"), ("proxy", "proxy_position")):
        drawn = transform(hand.viewer, f"/station/{name}")[:3, 3]
        np.testing.assert_allclose(drawn, recording.vector(column)[row], atol=1e-12)
    drawn = transform(hand.viewer, "/station/object")[:2, 3]
    np.testing.assert_allclose(drawn, [recording["body_position_x"][row], recording["body_position_y"][row]])
    assert is_drawn(hand.viewer, "/station/cloud")
    shown = dict(zip(COLUMNS, hand.shown[-1], strict=True))
    for column in ("force_y", "rendered_force_y", "estimated_force_y", "true_force_y", "theta_k2", "theta_stable"):
        np.testing.assert_equal(shown[column], recording[column][row])
    assert shown["in_contact"] == recording["detected_contact"][row] == 1.0


def test_a_bare_motion_is_drawn_without_what_it_has_not(viewer: Viewer) -> None:
    time = np.arange(0.0, 1.0, 0.004)
    columns = {f"position_{axis}": 0.01 * np.sin(time + i) for i, axis in enumerate("xyz")}
    hand = Hand(viewer, Recording(time, columns))
    hand.step(0.5)
    hidden = {
        name for name in ("hand", "proxy", "probe") if ("property", f"/station/{name}", "visible") in viewer.drawn
    }
    assert hidden == {"hand", "proxy"}
    assert is_drawn(viewer, "/station/object/box") and not is_drawn(viewer, "/station/cloud")
    assert np.isnan(hand.shown[-1][1:]).all()


def test_a_driven_body_has_a_chart_of_each_column_and_no_scene(viewer: Viewer) -> None:
    time = np.arange(0.0, 3.0, 0.5)  # rows farther apart than pictures
    hand = Hand(viewer, Recording(time, {"input": np.sin(time), "output": np.cos(time)}))
    assert [chart.title for chart in replay_panels(Recording(time, {"input": time, "output": time})).charts] == [
        "input",
        "output",
    ]
    hand.step(1.7)
    np.testing.assert_array_equal(hand.shown, np.column_stack([time, np.sin(time), np.cos(time)])[:4])
    assert not is_drawn(viewer, "/station/probe/tip")


def test_a_name_from_a_file_and_the_truth_stand_in_the_page_as_text() -> None:
    column = Recording(np.arange(2.0), {"input": np.zeros(2), "output": np.zeros(2), "</script>": np.zeros(2)})
    assert page(panels=replay_panels(column)).count("</script>") == page().count("</script>")
    truth = {symbol: float(i) for i, symbol in enumerate(THETA)}
    columns = {f"{name}_{axis}": np.zeros(2) for name in ("position", "force") for axis in "xyz"}
    assert len(replay_panels(Recording(np.arange(2.0), columns), truth).charts) == 3  # nothing was estimated
    charts = replay_panels(Recording(np.arange(2.0), {**columns, "theta_m": np.zeros(2)}), truth).charts
    assert [chart.truth for chart in charts] == [None] * 3 + [float(i) for i in range(len(THETA))]


def test_nothing_is_nothing_to_play(viewer: Viewer) -> None:
    with pytest.raises(BadInput, match=r"empty\.csv: found no rows"):
        Replay(viewer, Recording(np.zeros(0), {}, source="empty.csv"))


def test_a_browser_moves_one_slider_and_leaves_the_others_where_the_replay_has_them(
    viewer: Viewer, recording: Recording
) -> None:
    replay = Replay(viewer, recording)
    deadline = time.monotonic() + 20.0
    with stream(viewer.url):
        while not viewer.looking and time.monotonic() < deadline:
            replay.step()
            time.sleep(0.01)
        assert viewer.looking == 1
        while replay.at < 0.3 and time.monotonic() < deadline:
            replay.step()
            time.sleep(0.01)
        assert status(viewer.url, move(viewer.url, SPEED, 0.1)) == 204
        before = replay.at
        while viewer.values[SPEED] != 0.1 and time.monotonic() < deadline:
            replay.step()
            assert replay.at >= before  # the time is not what the server heard of last
            time.sleep(0.01)
        assert status(viewer.url, move(viewer.url, TIME, 0.05)) == 204
        while replay.at > 0.1 and time.monotonic() < deadline:
            replay.step()
            time.sleep(0.01)
        assert 0.05 <= replay.at < 0.1 and viewer.values[LOOP] == 0.0


def test_a_port_can_be_asked_for_once(viewer: Viewer, tmp_path: Path) -> None:
    taken = int(viewer.url.split(":")[2].split("/")[0])
    with pytest.raises(BadInput, match=f"viewer: found port {taken}, which is taken, expected a free port"):
        Viewer(page(), taken)
