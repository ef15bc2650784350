"""A recording in the live view: played, scrubbed and looped by the sliders of its page."""

import math
import time
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.plotting import MEASURED
from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.recording.clouds import thinned
from mmt_drake.viewer.charts import SHOWN_SECONDS, Chart, ChartLine, Panels, station_panels
from mmt_drake.viewer.scene import Scene
from mmt_drake.viewer.viewer import Viewer

SAMPLE_S, FRAME_S = 0.01, 0.03
"""Between two samples of the charts [s of the recording], and between two pictures [s of wall clock]."""

TIME, SPEED, PLAY, LOOP = "time [s]", "speed", "play", "loop"
"""The sliders: where it is, how fast it goes, whether it goes, and whether it begins anew."""

_MARGIN = 0.02  # of the object about the motion, where no cloud says how large it is [m]
_ROUNDING_S = 1e-6  # of times that are written in decimals


def replay_panels(recording: Recording, truth: Mapping[str, float] | None = None) -> Panels:
    """What is charted of a recording.

    Args:
        recording: of a station or a motion; or of one axis or a driven body: then each of its columns, without a scene.
        truth: symbol of theta -> the object's own value, SI units.
    """
    if recording.kind in ("contact", "motion"):
        panels = station_panels(truth)
        known = "theta_m" in recording
        return panels if known else replace(panels, charts=tuple(chart for chart in panels.charts if chart.wide))
    names = tuple(name for name in recording.columns if name not in recording.derived)
    charts = []
    for column, name in enumerate(names, 1):
        title = f"{name} [{recording.units[name]}]" if recording.units[name] else name
        charts.append(Chart(title, (ChartLine(column, name, MEASURED),), wide=True))
    return Panels(("time", *names), tuple(charts), scene=False)


class Replay:
    """A recording on a viewer's page. It goes on while somebody looks.

    Args:
        viewer: with the page of `replay_panels`.
        recording: to be shown.
        clock: [s].

    Attributes:
        at: where it is, in the recording's time [s].

    Raises:
        BadInput: the recording has no rows.
    """

    def __init__(self, viewer: Viewer, recording: Recording, clock: Callable[[], float] = time.monotonic) -> None:
        if len(recording) == 0:
            raise BadInput(recording.source, found="no rows", expected="a recording of something")
        self._viewer, self._clock, self._then = viewer, clock, clock()
        self._first, self._last = float(recording.time[0]), float(recording.time[-1])
        rows = np.searchsorted(recording.time, np.arange(self._first, self._last + SAMPLE_S, SAMPLE_S) - _ROUNDING_S)
        rows = np.unique(np.minimum(rows, len(recording) - 1)).astype(np.int64)
        self._time: list[float] = recording.time[rows].tolist()
        self._clouds, self._seen = recording.clouds, (-1, Cloud.empty())
        panels = replay_panels(recording)
        self._scene = Scene(viewer) if panels.scene else None
        touching = {"in_contact": _contact_of(recording)}
        self._charted = _columns(recording, rows, (touching.get(name, name) for name in panels.columns[1:]))
        if self._scene is not None:
            self._drawn = _of_station(recording, rows)
            self._set_up(self._scene)
        self.at, self._row, self._playing = self._first, -1, True
        self._show(fresh=True)
        viewer.add_slider(PLAY, 0.0, 1.0, 1.0, 1.0)
        viewer.add_slider(LOOP, 0.0, 1.0, 1.0, 0.0)
        viewer.add_slider(SPEED, 0.1, 4.0, 0.1, 1.0)

    def step(self) -> None:
        """Obey the sliders, go on by the time that has passed, and draw.

        Raises:
            OSError: the viewer's server has ended.
        """
        now = self._clock()
        passed, self._then = now - self._then, now
        said = self._viewer.hear()
        moved = said[TIME] != self.at
        began = said[PLAY] > 0.5 and not self._playing
        self._playing = said[PLAY] > 0.5
        fresh = moved
        if moved:
            self.at = said[TIME]
        elif self._playing and self._viewer.looking:
            self.at += passed * said[SPEED]
            if self.at >= self._last:
                fresh = said[LOOP] > 0.5 or began
                self.at = self._first if fresh else self._last
                self._playing = fresh
                self._viewer.add_slider(PLAY, 0.0, 1.0, 1.0, float(fresh))
        self._show(fresh=fresh)

    def _set_up(self, scene: Scene) -> None:
        for name, port in (("hand", "motion"), ("probe", "measurement"), ("proxy", "proxy")):
            if port not in self._drawn:
                scene.hide(name)
        position = self._drawn["measurement"][:, :3]
        low, high = position.min(axis=0), position.max(axis=0)
        scene.look_at(0.5 * (low + high), float((high - low).max()))
        if not self._clouds and low[2] < _MARGIN:  # it comes to the table
            ends = np.array([[*(low[:2] - _MARGIN), 0.0], [*(high[:2] + _MARGIN), 0.0]])
            scene.draw_object(ends)

    def _show(self, *, fresh: bool) -> None:
        row = max(bisect_right(self._time, self.at + _ROUNDING_S) - 1, 0)
        since = bisect_right(self._time, self.at - SHOWN_SECONDS) if fresh else self._row + 1
        for each in range(since, row + 1):
            self._viewer.add_samples([self._time[each], *self._charted[each].tolist()], fresh=fresh and each == since)
        if self._scene is not None and row != self._row:
            self._scene.show({name: values[row].tolist() for name, values in self._drawn.items()}, self._cloud())
        self._row = row
        self._viewer.add_slider(TIME, self._first, max(self._last, self._first + SAMPLE_S), SAMPLE_S, self.at)
        self._viewer.flush()

    def _cloud(self) -> Cloud | None:
        """The latest one."""
        index = bisect_right(self._clouds, self.at, key=lambda cloud: cloud[0]) - 1
        if index < 0:
            return None
        if index != self._seen[0]:
            self._seen = index, Cloud(thinned(self._clouds[index][1]))
        return self._seen[1]


def _contact_of(recording: Recording) -> str:
    """The column that says whether it touches: the detector's, where it is there."""
    return "detected_contact" if "detected_contact" in recording else "in_contact"


def _columns(recording: Recording, rows: NDArray[np.int64], names: Iterable[str]) -> Array:
    """Some columns, (rows, names); NaN where the recording has none."""
    nowhere = np.full(len(rows), math.nan)
    return np.column_stack([recording[name][rows] if name in recording else nowhere for name in names])


def _of_station(recording: Recording, rows: NDArray[np.int64]) -> dict[str, Array]:
    """Name of a port of `mmt_drake.systems.live_view.LiveView` -> what is drawn of it, (rows, size)."""

    def vector(name: str) -> Array:
        return _columns(recording, rows, (f"{name}_{axis}" for axis in "xyz"))

    still = np.zeros((len(rows), 3))
    found = {"measurement": np.hstack([vector("position"), still, vector("force")])}
    if recording.has_vector("master_position"):
        found["motion"] = np.hstack([vector("master_position"), still])
    if recording.has_vector("proxy_position"):
        found["proxy"] = vector("proxy_position")
    if recording.has_vector("rendered_force"):
        found["rendered_force"] = vector("rendered_force")
    if (touching := _contact_of(recording)) in recording:
        found["in_contact"] = _columns(recording, rows, [touching])
    if "body_position_x" in recording:
        found["body_position"] = _columns(recording, rows, ["body_position_x", "body_position_y"])
    return found
