"""Two machines' recordings of one run, made one: the operator's columns on the telerobot's clock.

Each side of a run on two machines records by its own clock, and beside its signals the time stamps of its packets
(`signals.LINK_CLOCKS`). By these the two files are known to be of one run, and their clocks are set against each other.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.check import completed
from mmt_drake.recording.clock_bounds import ClockBounds, clock_bounds
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import HELD, LINK_CLOCKS
from mmt_drake.recording.stored import LongColumns, as_array, stored

DELAY: Final = "to_telerobot_delay_s"
"""Key of `Recording.made_by`: the operator-to-telerobot delay that most samples have [s]."""

_PREFIX = "link_clock_"
_SAME_TICK = 1e-6  # [s]; stamps are written to the nanosecond
_ENOUGH = 0.9  # share of the peer's ticks, as received, that must stand in the peer's own recording
_STAMPS = ("held_body_stamp_x", "held_body_stamp_y", "held_body_seen")  # by the operator's run


@dataclass(frozen=True)
class JoinedSides:
    """Two recordings made one.

    Attributes:
        recording: the telerobot's rows, with the operator's columns at their instants.
        clocks: the telerobot's clock (first) against the operator's (second).
        delay_s: from the operator's hand to the telerobot's probe, in the median: the way, its play-out, and what
            the scenario simulates before it [s].
        left_out: rows of the telerobot of whose instant the operator has none.
    """

    recording: Recording
    clocks: ClockBounds
    delay_s: float
    left_out: int


def join(first: Recording, second: Recording) -> JoinedSides:
    """Make one recording of the two sides of a run, given in any order.

    Columns that both sides have are the telerobot's. The operator's others are interpolated linearly at the instant of
    each of its rows; flags and codes keep their last value.

    Raises:
        BadInput: not one of each side, other scenarios, other runs, or no time that both have recorded.
    """
    operator, telerobot = _sides(first, second)
    _check_scenario(operator, telerobot)
    _check_run(operator, telerobot)
    _check_run(telerobot, operator)
    to_telerobot, to_operator = _packets(telerobot), _packets(operator)
    both = f"{operator.source}, {telerobot.source}"
    clocks = clock_bounds(*to_telerobot, *to_operator[::-1], source=both)
    own, known = _stamped(operator, "own"), operator[f"{_PREFIX}own"] > 0.0
    if not (np.diff(own) > 0.0).all():
        raise BadInput(operator.source, at=f"{_PREFIX}own", found="times going back", expected="a clock that goes on")
    instants = clocks.second(telerobot[f"{_PREFIX}own"])
    inside = (instants >= own[0]) & (instants <= own[-1]) & (telerobot[f"{_PREFIX}own"] > 0.0)
    if np.count_nonzero(inside) < 3:
        raise BadInput(both, found="no time that both have recorded", expected="two sides that ran at the same time")
    columns = {
        name: stored(telerobot[name][inside])
        for name in telerobot.columns
        if name not in telerobot.derived and not name.startswith(_PREFIX)
    }
    last = np.searchsorted(own, instants[inside], side="right") - 1
    for name in operator.columns:
        if name not in telerobot.columns and name not in operator.derived:
            values = operator[name][known]
            columns[name] = stored(values[last] if name in HELD else np.interp(instants[inside], own, values))
    for name in set(_STAMPS) & set(columns):
        columns[name] = stored(_of_telerobots_run(as_array(columns[name]), operator, telerobot, clocks))
    delay = _delay(telerobot, clocks) + told_delay(operator)
    made_by = {name: text for name, text in telerobot.made_by.items() if name not in ("side", DELAY)}
    made_by |= {
        "joined": both,
        "clock_offset_s": f"{clocks.offset:.9f}",
        "clock_drift": f"{clocks.drift:.3g}",
        "clock_uncertainty_s": f"{clocks.uncertainty:.3g}",
        DELAY: f"{delay:.6f}",
    }
    constants = {**operator.constants, **telerobot.constants}
    whole = completed(
        telerobot.time[inside],
        LongColumns(columns),
        both,
        forces=False,
        notes=(*operator.notes, *telerobot.notes),
        clouds=telerobot.clouds,
        constants=constants,
    )
    return JoinedSides(replace(whole, made_by=made_by), clocks, delay, int(np.count_nonzero(~inside)))


def _sides(first: Recording, second: Recording) -> tuple[Recording, Recording]:
    """The operator's and the telerobot's."""
    for recording in (first, second):
        missing = [name for name in LINK_CLOCKS if f"{_PREFIX}{name}" not in recording]
        if missing:
            expected = "one side of a run on two machines (`mmt-drake run --side`), with its packets' time stamps"
            raise BadInput(recording.source, found=f"no column {_PREFIX}{missing[0]}", expected=expected)
    of_operator = ["master_position_x" in recording for recording in (first, second)]
    if of_operator[0] == of_operator[1]:
        name = "operator" if of_operator[0] else "telerobot"
        raise BadInput(second.source, found=f"the {name}'s side, as in {first.source}", expected="one of each side")
    return (first, second) if of_operator[0] else (second, first)


def _check_scenario(operator: Recording, telerobot: Recording) -> None:
    for key, what in (("scenario", "scenario"), ("step_s", "step")):
        one, other = operator.made_by.get(key), telerobot.made_by.get(key)
        if one is not None and other is not None and one != other:
            expected = f"{one}, as in {operator.source}"
            raise BadInput(telerobot.source, at=what, found=other, expected=expected)


def _check_run(here: Recording, peer: Recording) -> None:
    """Refuse a peer's recording that does not hold the ticks whose packets came here."""
    received, ticks = _stamped(here, "peer_tick"), _stamped(peer, "own")
    share = 0.0
    if len(received) and len(ticks):
        received = received[(received >= ticks[0] - _SAME_TICK) & (received <= ticks[-1] + _SAME_TICK)]
        at = np.clip(np.searchsorted(ticks, received - _SAME_TICK), 0, len(ticks) - 1)
        share = float(np.mean(np.abs(ticks[at] - received) <= _SAME_TICK)) if len(received) else 0.0
    if share < _ENOUGH:
        found = "the time stamps of another run" if len(_stamped(here, "peer_tick")) else "no packet of the other side"
        raise BadInput(here.source, at=f"{_PREFIX}peer_tick", found=found, expected=f"those of {peer.source}")


def _stamped(recording: Recording, name: str) -> Array:
    """The time stamps of a column that are known, in their order."""
    values = recording[f"{_PREFIX}{name}"]
    return values[values > 0.0]


def _packets(recording: Recording) -> tuple[Array, Array]:
    """When samples arrived here, and when they were sent there, each once: (n,) and (n,) [s]."""
    sent, arrived = recording[f"{_PREFIX}peer_sent"], recording[f"{_PREFIX}arrived"]
    new: Flags = (sent > 0.0) & (np.diff(sent, prepend=-1.0) != 0.0)
    return arrived[new], sent[new]


def _of_telerobots_run(stamps: Array, operator: Recording, telerobot: Recording, clocks: ClockBounds) -> Array:
    """Times of the operator's run as times of the telerobot's; 0 stays 0, not known yet."""
    clock = np.interp(stamps, operator.time, operator[f"{_PREFIX}own"])
    return np.where(stamps > 0.0, np.interp(clocks.first(clock), telerobot[f"{_PREFIX}own"], telerobot.time), 0.0)


def _delay(telerobot: Recording, clocks: ClockBounds) -> float:
    """How much later than the operator's hand the telerobot shows its motion, in the median [s]."""
    own, shown = telerobot[f"{_PREFIX}own"], telerobot[f"{_PREFIX}shown"]
    known = (own > 0.0) & (shown > 0.0)
    return max(0.0, float(np.median(own[known] - clocks.first(shown[known]))))


def told_delay(recording: Recording) -> float:
    """The operator-to-telerobot delay that a recording tells [s]; 0 where it tells none, as but an `.mcap` does.

    Raises:
        BadInput: what the file says is no time.
    """
    text = recording.made_by.get(DELAY, "0")
    try:
        delay = float(text)
    except ValueError:
        delay = math.nan
    if not 0.0 <= delay < math.inf:
        raise BadInput(recording.source, at=f"metadata {DELAY}", found=repr(text), expected="a time, 0 s or more")
    return delay
