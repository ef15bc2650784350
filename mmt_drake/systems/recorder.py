"""Records the signals of a diagram in one MCAP file."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context

from mmt_drake.errors import BadInput
from mmt_drake.recording.clouds import thinned
from mmt_drake.recording.in_turn import InTurn
from mmt_drake.recording.mcap_writer import McapWriter
from mmt_drake.systems.leaf import LeafSystem

CloudPolicy = Literal["none", "light", "full"]

BLOCK = 1.0
"""Simulation time between two chunks of the file [s]; a crash loses that much at most."""

LIGHT_INTERVAL = 1.0
"""Time between two clouds that are recorded lightly [s]."""

BLOCKS = 8
"""In real time: so many blocks may wait for a slow disk, the one being filled among them."""

PATIENCE = 10.0
"""In real time: for so long a disk may do nothing at the end of a run [s]."""

_TASKS = 64  # clouds and blocks that may wait

_Block = tuple[NDArray[np.float64], NDArray[np.float64]]


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
    therefore taken among the updates of a tick, once the devices have been read, and a thread writes the blocks. There
    whoever holds a device comes first: a disk that is slow makes gaps in the recording, never a late tick, and one that
    refuses ends the recording, not the run; what is complete by then is kept. Both are counted and reported. The end of
    a run waits for the disk as long as it gets on, and gives the rest of the recording up if it hangs.
    The file is this system's state: it stands in ``self``, not in the Context, so that one recorder records one run.
    Call ``close`` at the end; until then the last block is missing.

    Args:
        path: the file; see ``McapWriter`` for what stands there when.
        signals: base name and size of each part of the input.
        period: time between rows [s].
        clouds: ``none``; ``light``, one a second thinned to 5000 points at most; ``full``, every new one, whole.
        realtime: for a run by the wall clock; it has no row at its very end.
        tell: called with a line for a person, from any thread, when a recording in real time ends early or has a gap.
        constants: what stands still, see ``Recording.constants``.
        made_by: how it is made, see ``Recording.made_by``.

    Attributes:
        trouble: why a recording in real time ended before its run; None while all is well.
        dropped: rows and clouds that a disk was too slow for, in real time.
        patience: in real time: how long the end waits for a disk that does nothing [s].

    Raises:
        BadInput: an unknown signal, cloud policy or a period that is not positive; a file that cannot
            be begun. In a run: time goes back (a second run), or, but for real time, the disk refuses.
    """

    def __init__(
        self,
        path: str | Path,
        signals: Sequence[tuple[str, int]],
        period: float = 1e-3,
        clouds: CloudPolicy = "light",
        realtime: bool = False,
        tell: Callable[[str], object] | None = None,
        constants: Mapping[str, float] | None = None,
        made_by: Mapping[str, str] | None = None,
    ):
        super().__init__()
        if clouds not in ("none", "light", "full"):
            raise BadInput("recorder", at="clouds", found=repr(clouds), expected="'none', 'light' or 'full'")
        if not 0.0 < period < np.inf:
            raise BadInput("recorder", at="period", found=period, expected="more than 0 s")
        self._writer = McapWriter(path, signals, clouds=clouds != "none", constants=constants, made_by=made_by)
        self._path = path
        self._edges = np.cumsum([0, *(size for _, size in signals)])
        self._names = [name for name, _ in signals]
        length = max(1, round(BLOCK / period))
        self._blocks = [
            (np.zeros(length), np.zeros((length, int(self._edges[-1])))) for _ in range(BLOCKS if realtime else 1)
        ]
        self._block: _Block | None = self._blocks[0]
        self._free = deque(self._blocks[1:])
        self._filled = 0
        self._tasks = InTurn(_TASKS, "recorder") if realtime else None
        self._tell = tell
        self.trouble: BadInput | None = None
        self.dropped = 0
        self.patience = PATIENCE
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

    @property
    def file(self) -> McapWriter:
        """What writes the file, and knows where it stands."""
        return self._writer

    def close(self, *, whole: bool = True) -> None:
        """Write what is left and complete the file. A second call does nothing.

        Args:
            whole: whether the run came to its end; if not, the file does not get its name (see ``McapWriter``).

        Raises:
            BadInput: the disk refused; not in real time, see `trouble`.
        """
        if not self._closed:
            self._closed = True
            if self._tasks is None:
                self._flush()
                self._writer.close(whole=whole)
                return
            if not self._tasks.close(lambda: self._finish(whole), self.patience):
                found = f"a disk that has done nothing for {self.patience:g} s"
                expected = f"one that writes what is left; its beginning is in {self._writer.path}"
                trouble = BadInput(self._path, found=found, expected=expected)
                self._end(trouble, "the end of the recording is lost")

    def _finish(self, whole: bool) -> None:
        """Write what is left and complete the file, in real time."""
        if self._block is not None:
            self._attempt(self._flushing())
        self._attempt(lambda: self._writer.close(whole=whole))

    def settle(self) -> None:
        """In real time: wait until every block that is full is with the operating system, or refused."""
        if self._tasks is not None:
            self._tasks.wait()

    def _record(self, context: Context) -> None:
        time = context.get_time()
        if time <= self._last or self._closed:
            if time == self._last and not self._closed:
                return  # a Simulator initialised again publishes its first row again
            found = "a row after the end" if self._closed else f"time going back from {self._last:g} to {time:g} s"
            raise BadInput(self._path, found=found, expected="one run per recorder; build the diagram again")
        self._last = time
        block = self._block_to_fill()
        if block is None:
            return
        row = self._filled
        block[0][row] = time
        block[1][row] = self._signals.Eval(context)
        self._filled = row + 1
        try:
            if self._filled == len(block[0]):
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
        stamp = -np.inf if cloud is None else max(cloud.stamp, 0.0)  # a camera has seen it before the run, perhaps
        if stamp <= self._last_stamp:
            return
        self._last_stamp = stamp
        points = np.asarray(cloud.points(), dtype=np.float32)
        if self._thin:
            self._next_cloud = time + LIGHT_INTERVAL * (1.0 - 1e-9)  # times of ticks are sums of rounded steps
            points = thinned(points)
        self._do(lambda: self._writer.write_cloud(stamp, points), 1)

    def _flush(self) -> None:
        filled = self._filled
        if self._do(self._flushing(), filled) and self._tasks is not None:
            self._block = None  # the thread has it

    def _flushing(self) -> Callable[[], None]:
        """What writes the rows at hand, and has their block filled anew."""
        block, filled = self._block or self._blocks[0], self._filled
        parts = list(zip(self._names, self._edges[:-1], self._edges[1:], strict=True))
        self._filled = 0

        def write() -> None:
            columns = {name: block[1][:filled, start:stop] for name, start, stop in parts}
            self._writer.write_block(block[0][:filled], columns)
            if self._tasks is not None:
                self._writer.settle()  # or a refusal would be known a block later
                self._free.append(block)

        return write

    # ---------------------------------------------------------------------------------------------- in real time
    def _block_to_fill(self) -> _Block | None:
        """Where the next row goes; None if the recording has ended, or every block is waiting for the disk."""
        if self._block is None and self._free:
            self._block = self._free.popleft()
        if self.trouble is not None:
            return None
        if self._block is None:
            self._drop(1)
        return self._block

    def _do(self, task: Callable[[], object], lost: int) -> bool:
        """Have the writer do something, in real time beside the clock; what is lost if that is too slow is counted."""
        if self._tasks is None:
            task()
        elif not self._tasks.offer(lambda: self._attempt(task)):
            self._drop(lost)
            return False
        return True

    def _drop(self, count: int) -> None:
        if not self.dropped and self._tell is not None:
            self._tell(f"{self._path}: the disk is too slow: the recording has a gap")
        self.dropped += count

    def _attempt(self, task: Callable[[], object]) -> None:
        """Do something with the file; whatever comes up ends the recording, and nothing else."""
        if self.trouble is not None:
            return
        try:
            task()
        except Exception as error:
            known = error if isinstance(error, BadInput) else None
            self._end(known or BadInput(self._path, found=repr(error), expected="a recording that goes on"))

    def _end(self, trouble: BadInput, what: str = "the recording has ended, the run goes on") -> None:
        """No more is recorded from here on, and that is reported."""
        self.trouble = trouble
        if self._tell is not None:
            self._tell(f"{what}: {trouble}")
