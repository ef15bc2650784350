"""Lags of the rendered force behind touches and releases."""

from dataclasses import dataclass

import numpy as np

from mmt_drake.analysis.signals import component, delay_of, flag, rising
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import AXES


@dataclass(frozen=True)
class Lags:
    """Answers of the rendered force to one kind of event, touches or releases.

    Attributes:
        events_s: when the plant changed, in the plant's time [s].
        lags_s: for each, the time from the event *in the operator's time* (the plant's, less the operator-to-telerobot
            delay: the instant of the hand's motion that caused it) to the rendered response [s]; positive is late,
            None never answered.
        unseen: how many of the unanswered ones the recording ended before: at the typical lag it would not have seen
            their answer.
    """

    events_s: tuple[float, ...]
    lags_s: tuple[float | None, ...]
    unseen: int = 0

    @property
    def lost(self) -> int:
        """Events that were not answered while there was time for it."""
        return self.lags_s.count(None) - self.unseen

    @property
    def median_s(self) -> float | None:
        """Median over the events that were answered [s]; None if none was."""
        answered = [lag for lag in self.lags_s if lag is not None]
        return float(np.median(answered)) if answered else None


def lags(recording: Recording, delay_s: float | None = None) -> tuple[Lags, Lags]:
    """Lags of touches and of releases.

    An event is a change of `in_contact`; its response is the rendered force leaving exactly zero (touch) or returning
    to it (release) in all three axes. Events before the first sample at which `theta_stable` is set are left out,
    since no renderer that needs parameters can answer them; where the recording has no such column, or theta never
    becomes stable, all events count. So are, where `renderer_status` says so, those whose motion was before the first
    parameters had come over the network.

    Events and responses are paired in two passes. The first takes for each event the earliest response after the
    middle of the interval that the event ended, so an early answer gets a negative lag; the median of these is the
    typical lag. The second pairs an event with the response nearest to where the typical lag predicts it, if that
    response is in turn nearest to this event. So a lost answer does not shift all later ones, and an answer may come
    after the next event, as it does when contacts are shorter than the round trip.

    Args:
        recording: with `in_contact` and `rendered_force_*`.
        delay_s: operator-to-telerobot delay [s]; None: as the recording tells it, 0 where it does not.

    Raises:
        BadInput: a column is missing or broken, or the delay is no time.
    """
    delay_s = delay_of(recording, delay_s)
    time = recording.time
    contact = flag(recording, "in_contact")
    rendering = np.logical_or.reduce([component(recording, "rendered_force", axis) != 0.0 for axis in AXES])
    changes = time[np.sort(np.concatenate([rising(contact), rising(~contact)]))]
    first_stable, first_rendered = _first(recording, "theta_stable"), _first(recording, "renderer_status")

    def answers(state: Flags, response: Flags) -> Lags:
        events = time[rising(state)]
        events = events[(events >= first_stable) & (events - delay_s >= first_rendered)]
        before = np.searchsorted(changes, events) - 1
        earlier = np.where(before >= 0, changes[before], -np.inf)
        return _paired(events, (earlier + events) / 2, time[rising(response)] + delay_s, time[-1] + delay_s)

    return answers(contact, rendering), answers(~contact, ~rendering)


def _first(recording: Recording, name: str) -> float:
    """Time at which a column first is not 0 [s]; minus infinity where there is none to wait for."""
    if name not in recording:
        return -np.inf
    known = np.flatnonzero(recording[name])
    return float(recording.time[known[0]]) if known.size else -np.inf


def _paired(events: Array, earliest: Array, responses: Array, seen_until: float) -> Lags:
    """Lags of `events` (m,), none answered before `earliest` (m,), by `responses` (k,) that were seen until then.

    All in the plant's time [s].
    """
    answers: list[float | None] = [None] * len(events)
    unseen = 0
    first = np.searchsorted(responses, earliest)
    has_answer = first < len(responses)
    if has_answer.any():
        predicted = events + np.median(responses[first[has_answer]] - events[has_answer])
        # `earliest` increases with the events: a response may belong to those up to a certain one
        possible = np.searchsorted(earliest, responses, side="right")
        for event in np.flatnonzero(has_answer):
            response = _nearest(responses, int(first[event]), len(responses), predicted[event])
            if _nearest(predicted, 0, int(possible[response]), responses[response]) == event:
                # To a nanosecond, which is what clocks tell; the rest is rounding.
                answers[event] = round(float(responses[response] - events[event]), 9) + 0.0
        unseen = sum(at > seen_until for at, answer in zip(predicted, answers, strict=True) if answer is None)
    return Lags(tuple(map(float, events)), tuple(answers), unseen)


def _nearest(times: Array, start: int, stop: int, wanted: float) -> int:
    """The index of that of the increasing times[start:stop] which is nearest to the one wanted; of two, the earlier."""
    after = start + int(np.searchsorted(times[start:stop], wanted))
    if after == start or (after < stop and times[after] - wanted < wanted - times[after - 1]):
        return after
    return after - 1
