"""The pacing figures: both loops by the same clock, the ratio that of the figures beside it."""

from __future__ import annotations

import pytest

from diagrams.bench import pacing


def test_the_ratio_is_that_of_the_figures_and_no_tick_began_early() -> None:
    told = {item.name: item.value for item in pacing.measurements(seconds=0.3, turns=2)}
    p99 = {name: told[f"{name}: lateness of a tick, 99th percentile"] for name in ("bare loop", "setup1 recorded")}
    ratio = told["setup1 recorded: 99th percentile of lateness over the bare loop's"]
    assert ratio == pytest.approx(p99["setup1 recorded"] / p99["bare loop"])
    for name in p99:
        assert 0.0 < told[f"{name}: lateness of a tick, median"] <= p99[name]
        assert p99[name] <= told[f"{name}: lateness of a tick, worst of 600"]
        assert 0.0 <= told[f"{name}: ticks not done when the next was due"] <= 100.0
