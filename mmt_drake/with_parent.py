"""Ends a worker's process when the one that started it is gone, however that went, or wants it gone."""

import multiprocessing
import os
import threading
from collections.abc import Sequence
from multiprocessing.connection import Connection, wait

_STATUS = 1  # of the process; nobody is there to read it


def end_with_parent(*pipes: Connection) -> None:
    """Have this process end at once when its parent does; to be called in a child that `multiprocessing` started.

    Args:
        pipes: of which the parent holds the other ends; it also ends when one of those is closed.

    A worker of a pool waits for ever for work that a killed parent cannot hand out, or goes on with what it has. The
    parent holds one end of a pipe open, of which this process watches the other: the kernel closes it whatever ends
    the parent, SIGKILL too. (Linux could send a signal, but when the *thread* that started the child ends, and from a
    fork server when that does.) In a process that is nobody's child nothing happens.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=([parent.sentinel, *pipes],), name="with parent", daemon=True).start()


def _end_after(ends: Sequence[int | Connection]) -> None:
    wait(ends)
    os._exit(_STATUS)  # not the thread alone, and no handler of an exit that would wait for the others
