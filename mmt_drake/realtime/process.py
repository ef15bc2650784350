"""A real-time process: priority, a processor of its own, locked memory, no garbage collection."""

import ctypes
import gc
import os
import resource
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass

from mmt_drake.errors import BadInput

_SET_TIMER_SLACK, _GET_TIMER_SLACK = 29, 30  # of prctl(2)
_CURRENT_AND_FUTURE = 3  # MCL_CURRENT | MCL_FUTURE of mlockall(2)
_SWITCH = 1e-4  # [s]
_PRIORITY = 40  # under a real-time kernel's interrupts, at 50, and what drives an arm, at 99
_DOCTOR = "`mmt-drake doctor` says how"


@dataclass(frozen=True)
class ProcessOptions:
    """What to ask of the system for a run in real time; all of it is given back at the end.

    Attributes:
        priority: real-time priority (SCHED_FIFO) of the thread that runs the loop, 1 to 99; 0: none; None: 40 where the
            system permits it and there is another processor for the rest.
        cpu: processor for that thread; None: any.
        lock_memory: keep all memory in RAM (mlockall), so that no page has to be fetched in the midst of a tick.
    """

    priority: int | None = None
    cpu: int | None = None
    lock_memory: bool = False

    def __post_init__(self) -> None:
        if self.priority is not None and not 0 <= self.priority <= 99:
            raise BadInput("real time", at="priority", found=self.priority, expected="1 to 99, or 0 for none")


@contextmanager
def real_time_process(options: ProcessOptions) -> Iterator[list[str]]:
    """Hold the process in a state to be on time; gives what was done, a few words each.

    The garbage collector is off meanwhile, and what exists at the start is left out of its later rounds; timers of this
    thread are as exact as the kernel has them; and other Python threads give way soon. All this needs no permission;
    the rest may. Without a real-time priority the kernel lets others finish their turn, of milliseconds, first.

    Raises:
        BadInput: the system does not permit what was asked, or there is no such processor.
    """
    with ExitStack() as undo:
        done = [_without_collector(undo), *_exact_timers(undo), _giving_way(undo)]
        if options.cpu is not None:
            done.append(_pinned(options.cpu, undo))
        if options.lock_memory:
            done.append(_locked(undo))
        if options.priority != 0:  # last: what comes before should not run at it
            done.append(_prioritised(options.priority, undo))
        yield done


def _without_collector(undo: ExitStack) -> str:
    gc.collect()
    gc.freeze()
    undo.callback(gc.unfreeze)
    if gc.isenabled():
        gc.disable()
        undo.callback(gc.enable)
    return "garbage collection off"


def _exact_timers(undo: ExitStack) -> Iterator[str]:
    try:
        prctl = ctypes.CDLL(None, use_errno=True).prctl
    except (OSError, AttributeError):
        return  # not Linux: nothing to set
    prctl.argtypes = [ctypes.c_int] + [ctypes.c_ulong] * 4
    before = prctl(_GET_TIMER_SLACK, 0, 0, 0, 0)
    if before > 1 and prctl(_SET_TIMER_SLACK, 1, 0, 0, 0) == 0:
        undo.callback(prctl, _SET_TIMER_SLACK, before, 0, 0, 0)
        yield "timer slack 1 ns"


def _giving_way(undo: ExitStack) -> str:
    """A thread that waits for the interpreter gets it from another after this long, by default 5 ms."""
    undo.callback(sys.setswitchinterval, sys.getswitchinterval())
    sys.setswitchinterval(_SWITCH)
    return f"threads switch after {1e6 * _SWITCH:.0f} us"


def _pinned(cpu: int, undo: ExitStack) -> str:
    before = os.sched_getaffinity(0)
    if cpu not in before:
        raise BadInput("--cpu", found=cpu, expected=f"one of {', '.join(map(str, sorted(before)))}")
    os.sched_setaffinity(0, {cpu})
    undo.callback(os.sched_setaffinity, 0, before)
    return f"on processor {cpu}"


def _locked(undo: ExitStack) -> str:
    soft, hard = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if soft != hard:  # else an allocation in the midst of the run could fail
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_MEMLOCK, (hard, hard))
            undo.callback(resource.setrlimit, resource.RLIMIT_MEMLOCK, (soft, hard))
    if hard != resource.RLIM_INFINITY and not _has_capability(_CAP_IPC_LOCK):
        found = f"at most {hard / 1e6:.0f} MB permitted"
        raise BadInput("--lock-memory", found=found, expected=f"no limit; {_DOCTOR}")
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.mlockall(_CURRENT_AND_FUTURE):
        raise BadInput("--lock-memory", found=os.strerror(ctypes.get_errno()), expected=f"permission; {_DOCTOR}")
    undo.callback(libc.munlockall)
    return "memory locked"


def _prioritised(asked: int | None, undo: ExitStack) -> str:
    if asked is None and os.cpu_count() == 1:
        return "no real-time priority on one processor"
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    priority = _PRIORITY if asked is None else asked
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        if asked is None:
            return f"no real-time priority: not permitted, {_DOCTOR}"
        _, hard = resource.getrlimit(resource.RLIMIT_RTPRIO)
        found = f"{priority}, and at most {hard} permitted"
        raise BadInput("--priority", found=found, expected=f"a permitted one; {_DOCTOR}") from None
    undo.callback(os.sched_setscheduler, 0, policy, parameters)
    return f"real-time priority {priority}"


_CAP_IPC_LOCK = 14


def _has_capability(number: int) -> bool:
    with suppress(OSError), open("/proc/self/status", encoding="ascii") as status:
        for line in status:
            if line.startswith("CapEff:"):
                return bool(int(line.split()[1], 16) >> number & 1)
    return False
