"""Two sides of a run, each by its own clock, become one recording, as near as the packets tell how the clocks stand."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.model.held_body import HELD_BODY
from mmt_drake.recording.clock_bounds import clock_bounds
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import LINK_CLOCKS
from mmt_drake.recording.two_recordings import DELAY, join

Array = NDArray[np.float64]

STEP, TICKS = 1e-3, 20_000
OFFSET = 4321.5
"""The operator's clock less the telerobot's, when the run begins [s]."""


def hand(t: Array) -> Array:
    """(n, 3) of the time that passes, for both."""
    return np.column_stack([0.02 * np.sin(2.0 * t), 0.03 * np.cos(1.3 * t), -0.002 + 0.001 * np.sin(t)])


def sides(drift: float = 0.0, *, start: float = 0.25, transit: float = 2e-3, seed: int = 0) -> tuple[Recording, ...]:
    """The operator's and the telerobot's recording; that begins `start` [s] later, its clock runs `drift` faster."""
    draws = np.random.default_rng(seed)
    true = {"operator": STEP * np.arange(TICKS), "telerobot": start + STEP * np.arange(TICKS)}
    clock = {"operator": lambda t: 100.0 + OFFSET + t, "telerobot": lambda t: 100.0 + t * (1.0 + drift)}
    stamps = {}
    for side, other in (("operator", "telerobot"), ("telerobot", "operator")):
        now = true[side]
        delivered = true[other] + transit * (1.0 + draws.exponential(1.0, TICKS))
        newest = np.searchsorted(np.maximum.accumulate(delivered), now, side="right") - 1
        there, at = newest >= 0, np.maximum(newest, 0)
        polled = np.minimum(np.searchsorted(now, np.maximum.accumulate(delivered)), TICKS - 1)[at]
        columns = {
            "own": clock[side](now),
            "peer_tick": clock[other](true[other][at]) * there,
            "peer_sent": clock[other](true[other][at] + 1e-5) * there,
            "arrived": clock[side](now[polled] + 2e-5) * there,
            "shown": clock[other](true[other][at]) * there,
        }
        stamps[side] = {f"link_clock_{name}": columns[name] for name in LINK_CLOCKS}
    time = STEP * np.arange(TICKS)

    def named(name: str, values: Array) -> dict[str, Array]:
        return {f"{name}_{axis}": values[:, i] for i, axis in enumerate("xyz")}

    def of(side: str, columns: Mapping[str, Array], delay: str) -> Recording:
        made_by = {"scenario": "setup1", "step_s": "0.001", "side": side, DELAY: delay}
        return Recording(time, {**columns, **stamps[side]}, f"{side}.mcap", made_by=made_by)

    rendered = 10.0 * hand(true["operator"])
    operator = named("master_position", hand(true["operator"])) | named("rendered_force", rendered)
    operator |= {"operator_contact": (np.sin(true["operator"]) > 0.0).astype(float)}
    operator |= named("position", hand(true["operator"]))
    telerobot = named("position", hand(true["telerobot"])) | named("force", 10.0 * hand(true["telerobot"]))
    stamp = np.where(time > 1.0, 1.0, 0.0)
    telerobot |= {f"held_body_{name}": stamp if "stamp" in name or name == "seen" else 0.0 * time for name in HELD_BODY}
    return of("operator", operator, "0.004"), of("telerobot", telerobot, "0.004")


def test_clocks_are_set_against_each_other_within_the_uncertainty_that_is_told() -> None:
    joined = join(*sides())
    assert not joined.clocks.drift_told and joined.clocks.drift == 0.0
    assert abs(joined.clocks.offset + OFFSET) < joined.clocks.uncertainty < 3.5e-3
    instant = 0.25 + joined.recording.time
    speed = np.abs(np.diff(hand(instant), axis=0)).max() / STEP
    for i, axis in enumerate("xyz"):
        off = np.abs(joined.recording[f"master_position_{axis}"] - hand(instant)[:, i]).max()
        assert off <= speed * joined.clocks.uncertainty + 1e-9


@pytest.mark.parametrize("drift", [3e-4, -3e-4])
def test_a_drift_that_is_more_than_the_packets_leave_open_is_told_and_taken_out(drift: float) -> None:
    joined = join(*sides(drift, transit=2e-4))
    assert joined.clocks.drift_told
    assert joined.clocks.least_drift <= drift <= joined.clocks.most_drift
    assert joined.clocks.drift == pytest.approx(drift, abs=1e-4)
    instant = 0.25 + joined.recording.time
    off = np.abs(joined.recording["master_position_y"] - hand(instant)[:, 1]).max()
    assert off < 0.04 * joined.clocks.uncertainty


def test_what_the_telerobot_recorded_stands_in_the_joined_recording_to_the_bit() -> None:
    operator, telerobot = sides()
    joined = join(telerobot, operator).recording  # in any order
    rows = np.isin(telerobot.time, joined.time)
    assert rows.sum() == len(joined) > 19_000
    for name in ("position_x", "position_y", "force_z"):
        assert np.array_equal(joined[name], telerobot[name][rows])
    assert joined.has_vector("rendered_force") and set(np.unique(joined["operator_contact"])) == {0.0, 1.0}
    assert not any(name.startswith("link_clock") for name in joined.columns)
    assert joined.made_by["scenario"] == "setup1" and "side" not in joined.made_by


def test_the_delay_is_that_of_the_way_and_of_what_was_simulated_before_it() -> None:
    joined = join(*sides())
    way = 4e-3  # in the median 1.7 of the least, and half a tick
    assert joined.delay_s == pytest.approx(4e-3 + way, abs=2.5e-3 + joined.clocks.uncertainty)
    assert float(joined.recording.made_by[DELAY]) == pytest.approx(joined.delay_s, abs=1e-6)


def test_stamps_of_the_operator_s_run_become_those_of_the_telerobot_s() -> None:
    stamps = join(*sides()).recording["held_body_stamp_x"]
    assert stamps[0] == 0.0 and stamps[-1] == pytest.approx(1.0 - 0.25, abs=4e-3)


def test_quick_packets_both_ways_leave_little_open() -> None:
    sent = np.linspace(0.0, 60.0, 6001)
    draws = np.random.default_rng(1)
    there, back = (2e-4 + draws.exponential(5e-4, sent.size) for _ in range(2))
    bounds = clock_bounds(sent + there + 7.0, sent, sent + 7.0, sent + back, "two clocks")
    assert bounds.offset == pytest.approx(7.0, abs=2.1e-4) and bounds.uncertainty < 3e-4
    assert np.abs(bounds.first(bounds.second(sent)) - sent).max() < 1e-9


def test_a_way_that_is_slower_one_way_stays_within_the_uncertainty() -> None:
    sent = np.linspace(0.0, 10.0, 1001)
    bounds = clock_bounds(sent + 0.05 + 7.0, sent, sent + 7.0, sent + 0.001, "two clocks")
    assert abs(bounds.offset - 7.0) <= bounds.uncertainty < 0.06


def test_a_clock_that_was_set_in_between_is_refused() -> None:
    sent = np.linspace(0.0, 10.0, 1001)
    jump = np.where(sent > 5.0, 0.5, 0.0)
    with pytest.raises(BadInput, match="contradict each other"):
        clock_bounds(sent + 0.001 + jump, sent, sent + jump, sent + 0.001, "two clocks")


def refusal(first: Recording, second: Recording) -> str:
    with pytest.raises(BadInput) as caught:
        join(first, second)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def without(recording: Recording, part: str) -> Recording:
    kept = {name: values for name, values in recording.columns.items() if part not in name}
    return replace(recording, columns=kept)


def test_what_does_not_belong_together_is_refused_with_the_reason() -> None:
    operator, telerobot = sides()
    other_operator, other_telerobot = sides(start=0.2503)
    assert "one of each side" in refusal(operator, other_operator)
    assert "found the telerobot's side" in refusal(telerobot, other_telerobot)
    assert "no column link_clock_own" in refusal(operator, without(telerobot, "link_clock"))
    later = {name: v + 50.0 * (v > 0.0) for name, v in operator.columns.items() if name.startswith("link_clock")}
    assert "another run" in refusal(replace(operator, columns={**operator.columns, **later}), telerobot)
    told = replace(operator, made_by={**operator.made_by, DELAY: "soon"})
    assert "found 'soon', expected a time" in refusal(told, telerobot)
    renamed = replace(telerobot, made_by={**telerobot.made_by, "scenario": "setup3"})
    assert "scenario: found setup3, expected setup1" in refusal(operator, renamed)
    unheard = {name: 0.0 * telerobot[name] for name in telerobot.columns if name.startswith("link_clock_p")}
    assert "no packet of the other side" in refusal(operator, replace(telerobot, columns=telerobot.columns | unheard))
