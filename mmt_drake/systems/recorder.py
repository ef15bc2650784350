"""Records the signals of a diagram in one MCAP file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, wait
from pathlib import Path
from typing import Literal

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, LeafSystem

from mmt_drake.errors import BadInput
from mmt_drake.recording.clouds import thinned
from mmt_drake.recording.in_turn import InTurn
from mmt_drake.recording.mcap_writer import McapWriter

CloudPolicy = Literal["none", "light", "full"]

BLOCK = 1.0
"""Simulation time between two chunks of the file [s]; a crash loses that much at most."""

LIGHT_INTERVAL = 1.0
"""Time between two clouds that are recorded lightly [s]."""


class McapRecorder(LeafSystem):
    """Writes one row of signals per period, and point clouds, to an ``.mcap`` file.

    .. pydrake_system::

        name: McapRecorder
        input_ports:
        - signals
        - point_cloud

    - ``signals`` (sum of the signals' sizes): their values one after the other, in the order
      and with the units and frames of CONVENTIONS.md ("Recordings").
    - ``point_cloud`` (abstract, ``mmt_drake.cloud.Cloud``; optional): the surface, table frame.

    Rows are taken at publish events from time 0 on, before anything is updated, kept in a block, and written block by
    block. A publish event comes as soon as the tick before is done: in real time a period early. In real time rows are
    therefore taken among the updates of a tick, once the devices have been read, and a thread prepares the blocks; what
    the disk refuses is then told up to a block later.
    The file is this system's state: it stands in ``self``, not in the Context, so that one recorder records one run.
    Call ``close`` at the end; until then the last block is missing.

    Args:
        path: the file; see ``McapWriter`` for what stands there when.
        signals: base name and size of each part of the input.
        period: time between rows [s].
        clouds: ``none``; ``light``, one a second thinned to 5000 points at most; ``full``, every new one, whole.
        realtime: for a run by the wall clock; it has no row at its very end.

    Raises:
        BadInput: an unknown signal, cloud policy or a period that is not positive; a file that cannot
            be begun. In a run: the disk refuses, or time goes back (a second run).
    """

    def __init__(
        self,
        path: str | Path,
        signals: Sequence[tuple[str, int]],
        period: float = 1e-3,
        clouds: CloudPolicy = "light",
        realtime: bool = False,
    ):
        super().__init__()
        if clouds not in ("none", "light", "full"):
            raise BadInput("recorder", at="clouds", found=repr(clouds), expected="'none', 'light' or 'full'")
        if not 0.0 < period < np.inf:
            raise BadInput("recorder", at="period", found=period, expected="more than 0 s")
        self._writer = McapWriter(path, signals, clouds=clouds != "none")
        self._path = path
        self._edges = np.cumsum([0, *(size for _, size in signals)])
        self._names = [name for name, _ in signals]
        length = max(1, round(BLOCK / period))
        # Of two blocks one is filled while the other is written.
        self._blocks = [(np.zeros(length), np.zeros((length, int(self._edges[-1])))) for _ in range(1 + realtime)]
        self._time, self._block = self._blocks[0]
        self._filled = 0
        self._tasks = InTurn() if realtime else None
        self._writing: Future[None] | None = None
        self._last = -np.inf
        self._closed = False
        self._thin = clouds == "light"
        self._next_cloud = -np.inf if clouds != "none" else np.inf
        self._last_stamp = -np.inf
        self._signals = self.DeclareVectorInputPort("signals", int(self._edges[-1]))
        self._cloud = self.DeclareAbstractInputPort("point_cloud", AbstractValue.Make(None))
        if realtime:
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, lambda context, state: self._record(context))
        else:
            self.DeclarePeriodicPublishEvent(period, 0.0, self._record)

    def close(self) -> None:
        """Write what is left and complete the file. A second call does nothing.

        Raises:
            BadInput: the disk refused.
        """
        if not self._closed:
            self._closed = True
            self._flush()
            if self._tasks is not None:
                self._tasks.close()
            self._writer.close()

    def _record(self, context: Context) -> None:
        time = context.get_time()
        if time <= self._last or self._closed:
            if time == self._last and not self._closed:
                return  # a Simulator initialised again publishes its first row again
            found = "a row after the end" if self._closed else f"time going back from {self._last:g} to {time:g} s"
            raise BadInput(self._path, found=found, expected="one run per recorder; build the diagram again")
        self._last = time
        row = self._filled
        self._time[row] = time
        self._block[row] = self._signals.Eval(context)
        self._filled = row + 1
        try:
            if self._filled == len(self._time):
                self._flush()
            if time >= self._next_cloud:
                self._record_cloud(context, time)
        except BadInput:
            self._closed = True  # the writer has kept what it could; closing has nothing to add
            raise

    def _record_cloud(self, context: Context, time: float) -> None:
        if not self._cloud.HasValue(context):
            self._next_cloud = np.inf
            return
        cloud = self._cloud.Eval(context)
        if cloud is None or cloud.stamp <= self._last_stamp:
            return
        self._last_stamp = cloud.stamp
        points = np.asarray(cloud.points(), dtype=np.float32)
        if self._thin:
            self._next_cloud = time + LIGHT_INTERVAL * (1.0 - 1e-9)  # times of ticks are sums of rounded steps
            points = thinned(points)
        self._do(lambda: self._writer.write_cloud(cloud.stamp, points))

    def _flush(self) -> None:
        filled, self._filled = self._filled, 0
        time, block = self._time[:filled], self._block[:filled]
        parts = zip(self._names, self._edges[:-1], self._edges[1:], strict=True)
        columns = {name: block[:, start:stop] for name, start, stop in parts}
        task = self._do(lambda: self._writer.write_block(time, columns))
        if task is not None:
            before, self._writing = self._writing, task
            if before is not None:
                wait([before])
            self._blocks.reverse()
            self._time, self._block = self._blocks[0]

    def _do(self, task: Callable[[], None]) -> Future[None] | None:
        """Have the writer do something, in real time beside the clock."""
        if self._tasks is not None:
            return self._tasks.add(task)
        task()
        return None
