"""Tasks are done in order by another thread, and whoever waits for them waits no longer than they take."""

from __future__ import annotations

from threading import Event, Thread

from mmt_drake.recording.in_turn import InTurn


def test_what_is_offered_is_done_in_order_unless_too_much_is_waiting() -> None:
    goes_on, begun, done = Event(), Event(), list[int]()

    def hold() -> None:
        begun.set()
        goes_on.wait(10.0)

    tasks = InTurn(2, "tasks")
    assert tasks.offer(hold)
    assert begun.wait(10.0)
    assert [tasks.offer(lambda number=number: done.append(number)) for number in range(3)] == [True, True, False]
    goes_on.set()
    tasks.wait()
    assert done == [0, 1]
    tasks.close()
    tasks.close()


def test_after_the_end_nothing_is_waited_for() -> None:
    tasks = InTurn(2, "tasks")
    tasks.close()
    waiting = Thread(target=tasks.wait, daemon=True)
    waiting.start()
    waiting.join(5.0)
    assert not waiting.is_alive()
