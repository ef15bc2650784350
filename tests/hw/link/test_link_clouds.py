"""Surfaces arrive whole or not at all, whatever is lost on the way."""

import random
import struct

import numpy as np
import pytest
from link_samples import Pair

from mmt_drake.cloud import Cloud, plane
from mmt_drake.hw.link import wire
from mmt_drake.hw.link.clouds import BLOCK_POINTS, CloudCollector, CloudSender
from mmt_drake.hw.link.options import LinkOptions


@pytest.mark.parametrize("loss", [0.0, 0.3])
def test_a_surface_arrives_to_single_precision_through_loss_and_then_costs_nothing_more(loss: float) -> None:
    pair, draw = Pair(), random.Random(5)
    pair.connect()
    pair.back.fault = lambda p, now: [] if draw.random() < loss else [(now, p)]
    sent = plane(1000, (0.1, 0.2)).moved((0.01, 0.02, -0.003), 4.0)
    for n in range(400):
        if n % 33 == 0:
            pair.telerobot.offer_cloud(sent.moved(sent.translation, 4.0 + n))
        pair.tick()
    shown = pair.operator.cloud
    np.testing.assert_allclose(shown.points(), sent.points(), atol=2e-8)
    assert 4.0 < shown.stamp <= 4.0 + 399
    blocks = {n: len(p) for n, p in enumerate(pair.back.sent) if len(p) > 400}
    rounds = len(blocks) / -(-1000 // BLOCK_POINTS)
    assert rounds < (1.4 if loss == 0.0 else 8.0)


def test_a_surface_that_moves_follows_with_one_small_packet_a_frame(pair: Pair) -> None:
    base = plane(500, (0.1, 0.1))
    for n in range(300):
        if n % 33 == 0:
            pair.telerobot.offer_cloud(base.moved((1e-4 * n, 0.0, 0.0), 1e-3 * n))
        pair.tick()
    assert pair.operator.cloud.translation[0] == pytest.approx(1e-4 * 297)
    grid = pair.operator.cloud.kernel_arrays[0]
    pair.telerobot.offer_cloud(base.moved((0.5, 0.0, 0.0), 1.0))
    pair.tick()
    pair.tick()
    assert pair.operator.cloud.translation[0] == 0.5
    assert pair.operator.cloud.kernel_arrays[0] is grid  # the neighbour structure is not built again


def test_a_large_surface_is_thinned_and_one_tick_never_sends_more_than_two_more_packets() -> None:
    pair = Pair(LinkOptions(cloud_points=2000))
    pair.connect()
    pair.telerobot.offer_cloud(plane(30_000, (0.3, 0.3)))
    for _ in range(60):
        before = len(pair.back.sent)
        pair.tick()
        assert len(pair.back.sent) - before <= 3
    assert len(pair.operator.cloud) == len(plane(30_000, (0.3, 0.3)).base[::15])
    assert max(map(len, pair.back.sent)) <= wire.LARGEST_SIZE


def test_a_new_surface_is_taken_only_after_the_interval() -> None:
    sender = CloudSender(5000, 500)
    sender.offer(plane(10, (0.1, 0.1)), 0)
    first = sender.block(0)
    sender.offer(plane(10, (0.1, 0.1)), 499)
    assert sender.block(0) == first
    sender.offer(plane(10, (0.2, 0.1)), 500)
    assert sender.block(0) != first
    assert sender.block(2) is None  # the peer has it


def test_blocks_of_two_surfaces_never_mix() -> None:
    sender, collector = CloudSender(5000, 0), CloudCollector()
    one, two = plane(300, (0.1, 0.1)), plane(300, (0.2, 0.2))
    sender.offer(one, 0)
    of_one = [sender.block(0) for _ in range(4)]
    sender.offer(two, 1)
    of_two = [sender.block(0) for _ in range(4)]
    for body in (*of_one[:3], *of_two[:3], of_one[3]):
        assert body is not None and collector.add_block(body)
        assert len(collector.cloud) == 0
    assert of_two[3] is not None and collector.add_block(of_two[3])
    np.testing.assert_allclose(collector.cloud.points(), two.points(), atol=2e-8)
    for body in of_one:
        assert body is not None and collector.add_block(body)
    assert collector.number == 2


@pytest.mark.parametrize(
    "body",
    [
        b"",
        struct.pack("<IHHI", 1, 0, 1, 0),
        struct.pack("<IHHI", 1, 0, 1, 2) + bytes(12),
        struct.pack("<IHHI", 1, 1, 1, 1) + bytes(12),
        struct.pack("<IHHI", 1, 0, 9, 1) + bytes(12),
        struct.pack("<IHHI", 1, 0, 1, 2**32 - 1) + bytes(12),
        struct.pack("<IHHI3f", 1, 0, 1, 1, 0.0, float("nan"), 0.0),
    ],
)
def test_a_block_that_is_none_is_refused(body: bytes) -> None:
    collector = CloudCollector()
    assert not collector.add_block(body)
    assert len(collector.cloud) == 0


def test_a_place_that_is_none_is_refused() -> None:
    collector = CloudCollector()
    for body in (b"", struct.pack("<I4d", 1, 0.0, float("inf"), 0.0, 0.0)):
        assert not collector.add_translation(body, 1)


def test_an_older_place_that_comes_late_does_not_move_the_surface_back() -> None:
    sender, collector = CloudSender(5000, 0), CloudCollector()
    base = plane(10, (0.1, 0.1))
    translations = []
    for x in (0.1, 0.2):
        sender.offer(base.moved((x, 0.0, 0.0), x), 0)
        translations.append(sender.translation())
    block = sender.block(0)
    assert block is not None and translations[0] is not None and translations[1] is not None
    collector.add_translation(translations[1], 8)  # before the points are here, even
    collector.add_block(block)
    collector.add_translation(translations[0], 7)
    assert collector.cloud.translation[0] == 0.2
    assert isinstance(collector.cloud, Cloud)
