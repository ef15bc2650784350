"""The number of things that this process may do at once."""

import os

from mmt_drake.errors import BadInput


def processors() -> int:
    """`MMT_JOBS` of the environment; else the processors of the machine, or what `taskset` or a container leaves.

    Raises:
        BadInput: `MMT_JOBS` is no whole number above 0.
    """
    if asked := os.environ.get("MMT_JOBS"):
        if not (asked.isascii() and asked.isdigit() and int(asked) > 0):
            raise BadInput("environment", at="MMT_JOBS", found=asked, expected="a whole number above 0")
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
