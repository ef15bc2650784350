"""Tasks in the order in which they come; nobody waits for one that hangs."""

import subprocess
import sys
import threading

from mmt_drake.recording.in_turn import InTurn


def test_closing_does_all_that_was_offered_and_then_the_last_task() -> None:
    done = list[int]()
    tasks = InTurn(64, "test")
    for k in range(50):
        assert tasks.offer(lambda k=k: done.append(k))
    assert tasks.close(lambda: done.append(50))
    assert done == list(range(51))
    assert tasks.close(lambda: done.append(51)) and done[-1] == 50


def test_closing_gives_up_a_task_that_hangs_with_others_behind_it_and_that_goes_on() -> None:
    done, goes_on, hangs = list[str](), threading.Event(), threading.Event()
    tasks = InTurn(1, "test")

    def hang() -> None:
        hangs.set()
        goes_on.wait()

    assert tasks.offer(hang)
    hangs.wait()
    assert tasks.offer(lambda: done.append("behind it")) and not tasks.offer(lambda: done.append("one too many"))
    assert not tasks.close(patience=0.05) and not done
    goes_on.set()
    tasks.wait()
    assert done == ["behind it"]


def test_a_task_that_hangs_does_not_keep_the_process_from_ending() -> None:
    code = "import threading; from mmt_drake.recording.in_turn import InTurn; "
    code += "InTurn(1, 'test').offer(threading.Event().wait); print('ends')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60.0)
    assert done.stdout == "ends\n"


def test_after_the_end_nothing_is_waited_for() -> None:
    tasks = InTurn(2, "tasks")
    tasks.close()
    waiting = threading.Thread(target=tasks.wait, daemon=True)
    waiting.start()
    waiting.join(5.0)
    assert not waiting.is_alive()
