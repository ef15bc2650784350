"""How many processors this process may use."""

import os


def processors() -> int:
    """Those of the machine, or as many as `taskset` or a container leaves."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
