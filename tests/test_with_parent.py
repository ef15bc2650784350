"""A worker's process ends when the one that started it is killed, from whichever pool it is."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

POOLS = {
    "a pool of spawned workers": """
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), end_with_parent) as pool:
            pool.submit(work).result()
    """,
    "the workers of `mmt-drake trial`": """
        from mmt_drake.cli.trial import _processes
        with _processes(1, None) as pool:
            pool.submit(work).result()
    """,
    "a child of a fork server": """
        child = multiprocessing.get_context("forkserver").Process(target=lone)
        child.start()
        child.join()
    """,
}

SCRIPT = """\
import multiprocessing, os, time
from concurrent.futures import ProcessPoolExecutor
from mmt_drake.with_parent import end_with_parent

def work():
    print(os.getpid(), flush=True)
    time.sleep(60.0)

def lone():
    end_with_parent()
    work()

if __name__ == "__main__":
"""

WITHIN = 10.0  # [s] on a machine that is busy


def alive(process: int) -> bool:
    """Whether a process is there, and more than an entry that nobody has asked for yet."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are looked up in /proc")
@pytest.mark.parametrize("pool", POOLS)
def test_a_worker_ends_when_its_parent_is_killed(pool: str, tmp_path: Path, checkout: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(SCRIPT + POOLS[pool])
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    parent = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True, env=environment)
    assert parent.stdout is not None
    worker = int(parent.stdout.readline())
    try:
        assert alive(worker)
        parent.kill()
        parent.wait()
        ends = time.monotonic() + WITHIN
        while alive(worker) and time.monotonic() < ends:
            time.sleep(0.01)
        assert not alive(worker)
    finally:
        parent.stdout.close()
        if alive(worker):
            os.kill(worker, signal.SIGKILL)


def test_a_process_that_is_nobodys_child_goes_on() -> None:
    code = "from mmt_drake.with_parent import end_with_parent; end_with_parent(); print('goes on')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "goes on\n"
