"""The pacing figures: both loops by the same clock, the ratio that of the figures beside it."""

import pytest

from mmt_drake.diagrams.proof.bench import pacing

TICKS = {"bare loop": 300, "setup1 recorded": 1200, "setup1 recorded and shown": 300}


def test_the_ratio_is_that_of_the_figures_and_no_tick_began_early() -> None:
    told = {item.name: item.value for item in pacing.measurements(minutes=0.02)}
    p99 = {name: told[f"{name}: lateness of a tick, 99th percentile"] for name in TICKS}
    for name in list(TICKS)[1:]:
        ratio = told[f"{name}: 99th percentile of lateness over the bare loop's"]
        assert ratio == pytest.approx(p99[name] / p99["bare loop"])
    for name, ticks in TICKS.items():
        assert 0.0 < told[f"{name}: lateness of a tick, median"] <= p99[name]
        assert p99[name] <= told[f"{name}: lateness of a tick, worst of {ticks}"]
        overruns = told[f"{name}: overruns, ticks not done when the next was due"]
        assert told[f"{name}: the same, of all ticks"] == pytest.approx(100.0 * overruns / ticks)
