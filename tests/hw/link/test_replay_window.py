"""Every sequence number is taken once; how far back is limited."""

import random

from mmt_drake.hw.link.replay import WINDOW, ReplayWindow


def test_any_order_within_the_window_takes_every_number_once() -> None:
    draw = random.Random(3)
    numbers = sorted(range(20_000), key=lambda n: n + draw.uniform(0, WINDOW - 1))
    window, taken = ReplayWindow(), []
    for number in [n for n in numbers for _ in range(2)]:
        if window.is_new(number):
            window.take(number)
            taken.append(number)
    assert sorted(taken) == list(range(20_000))
    assert window.newest == 19_999


def test_what_is_too_far_behind_is_not_new_and_a_leap_forgets_what_it_leaves_behind() -> None:
    window = ReplayWindow()
    window.take(0)
    window.take(10 * WINDOW)
    assert not window.is_new(9 * WINDOW)
    assert window.is_new(9 * WINDOW + 1)
    assert not window.is_new(10 * WINDOW)
    window.take(2**63)
    assert not window.is_new(10 * WINDOW) and window.is_new(2**63 - 1)
