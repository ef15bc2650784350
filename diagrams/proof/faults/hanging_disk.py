"""A disk that does not answer any more, put under a file that this process has open for writing."""

import fcntl
import math
import os
import select
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Self

_PAGE = 4096  # bytes, the least that a pipe holds
_SET_SIZE = getattr(fcntl, "F_SETPIPE_SZ", None)  # Linux
_LOOK = 0.01  # [s]
_LONGEST = 120.0  # [s]


class HangingDisk:
    """Stands between a file and whoever writes it; a context manager, at whose end the disk is itself again.

    The writer's own descriptor becomes a pipe's, which a thread empties into the file. When that thread stops, the pipe
    fills up and the kernel lets `write` wait, as it does for a disk or a server of files that does not answer.

    Args:
        path: of a file that this process has open.

    Raises:
        FileNotFoundError: it has not.
    """

    def __init__(self, path: Path) -> None:
        descriptor = _descriptor(path)
        self._file = os.dup(descriptor)
        self._pipe, full = os.pipe()
        if _SET_SIZE is not None:
            fcntl.fcntl(full, _SET_SIZE, _PAGE)
        os.dup2(full, descriptor)
        os.close(full)
        self._room: int | None = None  # bytes that it still takes; None: any number
        self._until = math.inf
        self._ended = False
        self._changing = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="disk", daemon=True)
        self._thread.start()

    def hang(self, after: int = 0) -> None:
        """Take so many bytes more, then nothing; two minutes later all again, or one that waits would wait for ever."""
        with self._changing:
            self._room, self._until = after, time.monotonic() + _LONGEST

    def go_on(self) -> None:
        """Take everything again."""
        with self._changing:
            self._room = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.go_on()
        self._ended = True
        self._thread.join()
        os.close(self._file)
        os.close(self._pipe)  # whoever still writes has a broken one

    def _run(self) -> None:
        while True:
            ended = self._ended  # what came before that is still taken
            if not select.select([self._pipe], [], [], _LOOK)[0]:
                if ended:
                    return
                continue
            with self._changing:
                if time.monotonic() > self._until:
                    self._room = None
                most = _PAGE if self._room is None else min(self._room, _PAGE)
                data = os.read(self._pipe, most) if most else None
                if data:
                    os.write(self._file, data)
                    self._room = None if self._room is None else self._room - len(data)
            if data is None:  # it hangs
                time.sleep(_LOOK)
            elif not data:  # nobody has the other end any more
                return


def _descriptor(path: Path) -> int:
    """Of this process, under which a file is open."""
    wanted = path.stat()
    for name in os.listdir("/dev/fd"):
        try:
            there = os.fstat(int(name))
        except OSError:  # that of the listing itself
            continue
        if (there.st_dev, there.st_ino) == (wanted.st_dev, wanted.st_ino):
            return int(name)
    raise FileNotFoundError(path)
