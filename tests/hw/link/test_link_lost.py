"""A peer that is lost, comes back or has its clock set."""

import os

import numpy as np
import pytest
from link_samples import KEY, SIGNALS, Pair, status

from mmt_drake.diagrams.proof.faults.wires import End, FaultyWire
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions
from mmt_drake.hw.link.samples import Samples


@pytest.mark.parametrize("cut", ["both", "there", "back"])
def test_a_cut_cable_is_told_by_both_ends_and_what_is_shown_falls_to_where_it_is_safe(cut: str) -> None:
    pair = Pair(LinkOptions(timeout=0.05))
    pair.connect()
    for _ in range(20):
        model, motion = pair.tick()
    assert model[2:].tolist() == [1.0, 1.0] and motion[3:].any()
    for name in ("there", "back"):
        if cut in (name, "both"):
            getattr(pair, name).fault = lambda p, now: []
    for _ in range(50):
        pair.tick()
    for _ in range(60):  # the end that still hears learns it from the other one, a timeout later at most
        model, motion = pair.tick()
    assert status(pair.operator)["alive"] == status(pair.telerobot)["alive"] == 0.0
    assert model[2:].tolist() == [0.0, 0.0] and model[1] > 500.0  # no contact, the parameters kept
    assert not motion[3:].any() and motion[:3].any()  # standing still where it was
    assert max(pair.operator.age, pair.telerobot.age) > 0.05
    pair.there.fault = pair.back.fault = lambda p, now: [(now, p)]
    for _ in range(40):
        model, motion = pair.tick()
    assert status(pair.operator)["alive"] == status(pair.telerobot)["alive"] == 1.0
    assert status(pair.operator)["sessions"] == 1.0  # the same session goes on
    assert model[2] == 1.0 and motion[3:].any()


def test_the_peer_counts_as_lost_at_the_first_tick_after_the_timeout() -> None:
    pair = Pair(LinkOptions(timeout=0.05))
    pair.connect()
    pair.tick()
    pair.tick()
    alive = []
    for _ in range(60):
        pair.tick(operator=False)
        alive.append(pair.telerobot.alive)
    assert alive.index(False) == 50  # the last sample came 1 ms before the first of these ticks


def test_a_goodbye_is_heard_at_once(pair: Pair) -> None:
    pair.tick()
    pair.operator.close()
    _, motion = pair.tick(operator=False)
    assert pair.telerobot.ended and not pair.telerobot.alive and pair.telerobot.age == np.inf
    assert not motion[3:].any()


def test_a_peer_that_starts_again_is_taken_once_its_old_self_is_silent(pair: Pair) -> None:
    for _ in range(10):
        pair.tick()
    pair.operator = pair.start(OPERATOR)
    sessions = [(pair.tick(), status(pair.telerobot)["sessions"])[1] for _ in range(300)]
    assert sessions[:95] == [1.0] * 95 and sessions[150:] == [2.0] * 150  # the timeout is 100 ms
    assert pair.telerobot.alive
    sent = pair.motion()
    assert pair.tick()[1].tobytes() == sent.tobytes()


def test_a_second_operator_does_not_take_over_from_one_that_is_there(pair: Pair) -> None:
    copies = FaultyWire(lambda: pair.now)
    pair.back.fault = lambda p, now: [(copies.inject(p), (now, p))[1]]  # type: ignore[func-returns-value]
    second = Link(OPERATOR, SIGNALS, KEY, End(pair.there, copies), clock=lambda: pair.now)
    other = np.full(6, 9.0)
    for _ in range(300):
        second.exchange(0.0, other, np.zeros(4))
        sent = pair.motion()
        _, motion = pair.tick()
        assert motion.tobytes() == sent.tobytes()
    assert status(pair.telerobot)["sessions"] == 1.0


def test_a_flood_costs_a_tick_a_bounded_number_of_packets(pair: Pair) -> None:
    for _ in range(5000):
        pair.there.inject(os.urandom(100))
    before = len(pair.there.flying)
    pair.tick(operator=False)
    assert before - len(pair.there.flying) == 128


def test_what_stands_behind_a_motion_is_held_between_samples_while_the_motion_goes_on() -> None:
    samples = Samples(np.zeros(3), 10, motion=2)
    for sequence, (due, place, rate, other) in enumerate([(0, 0.0, 1.0, 5.0), (2_000_000_000, 2.0, 1.0, 7.0)]):
        samples.add(sequence, due, np.array([place, rate, other]))
    np.testing.assert_allclose(samples.show(1_500_000_010), [1.5, 1.0, 5.0], atol=1e-12)
    np.testing.assert_allclose(samples.show(2_000_000_010), [2.0, 1.0, 7.0], atol=1e-12)


@pytest.mark.parametrize("playout", [0.0, 0.02])
@pytest.mark.parametrize("step_s", [3600.0, -3600.0, 0.4, -0.4])
def test_a_clock_that_is_set_is_survived(playout: float, step_s: float) -> None:
    pair = Pair(LinkOptions(playout=playout))
    pair.shift[OPERATOR] = pair.shift[TELEROBOT] = 10**13
    pair.connect()
    for _ in range(100):
        pair.tick()
    pair.shift[OPERATOR] += round(step_s * 1e9)
    for _ in range(150):
        pair.tick()
    told = status(pair.telerobot)
    assert told["alive"] == 1.0 and told["sessions"] == 1.0
    assert told["clock_steps"] == 1.0
    if playout == 0.0:
        sent = pair.motion()
        assert pair.tick()[1].tobytes() == sent.tobytes()
        return
    for _ in range(50):
        t = pair.ticks[OPERATOR] * 1e-3 - playout
        _, motion = pair.tick()
        assert np.abs(motion[:3] - np.sin(20.0 * t + np.arange(3))).max() < 20.0 * 1.1e-3  # a tick's way


def test_clocks_that_drift_stay_in_step() -> None:
    pair = Pair(LinkOptions(playout=0.01))
    pair.connect()
    errors = []
    for n in range(8000):
        pair.shift[TELEROBOT] += 100  # 1e-4, ten times what quartz does
        tick = pair.ticks[OPERATOR]
        _, motion = pair.tick()
        if n > 1000:
            t = tick * 1e-3 - 0.010
            errors.append(np.abs(motion[:3] - np.sin(20.0 * t + np.arange(3))).max())
    assert status(pair.telerobot)["clock_steps"] == 0.0
    assert np.max(errors) < 20.0 * 2e-3
