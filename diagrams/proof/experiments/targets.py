"""Targets: what the thesis says of a figure, what is to be reached of it and how it is measured, once for all.

Ratios are shown in percent. Set-up 1, the thesis's object, 1 kHz, noise of 0.02 N, 1e-5 m and 5e-4 m/s, errors against
the plant's force without noise, in contact, after 5 s of contact, unless a target says otherwise.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from mmt_drake.analysis.hand import AT_REST
from mmt_drake.analysis.lags import Lags
from mmt_drake.analysis.metrics import ForceError, Metrics
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.diagrams.proof.studies.study import BY_PRIOR, Reached, Target

BANDS: Final = tuple(band for band in BAND_NAMES if band != "all")
"""In each of which the force is to be right."""


def _rendered(to_reach: float | None, says: Mapping[str, tuple[float | None, str]]) -> dict[str, Target]:
    return {band: Target(f"rendered force, {BAND_NAMES[band]}", "", *says[band], to_reach) for band in BANDS}


RENDERED: Final = _rendered(
    0.005, dict(zip(BANDS, ((0.3, "up to 30 %"), (1.0, "about 100 %"), (1.0, "up to 100 %")), strict=True))
)
"""Experiment 1, strokes and chirps, by band."""
RENDERED_DELAYED: Final = _rendered(
    0.005, dict(zip(BANDS, ((None, "poor"), (None, "nothing"), (None, "good")), strict=True))
)
"""The same with 400 ms each way (experiment 3), of which the thesis says the reverse and prints no figure."""
RENDERED_HAND: Final = _rendered(0.02, dict.fromkeys(BANDS, (None, "not tried")))
"""Real hand motions, bands that hold at least 5 % of the force."""
RENDERED_OTHER: Final = _rendered(None, dict.fromkeys(BANDS, (None, "not tried")))
"""Objects that are not the thesis's."""

OVER_NOISE: Final = Target("error against the measured force over its noise", "times", to_reach=1.1)
"""Real hand motions."""
ESTIMATED: Final = Target("estimated force", "", 0.05, "about 5 %")
STABLE: Final = Target("stable after", "s of contact", 16.1, "16.1 s, on a real arm", 0.5)
FOUND_S: Final = 3.0


def found(parameter: str) -> Target:
    """When a parameter is within 5 % of the truth and stays there; asked where the force's noise would allow it."""
    return Target(f"{parameter} within 5 % after", "s of contact", to_reach=FOUND_S)


DELAY_COSTS: Final = Target("error less that without the delay", "", 0.0, "the same", 0.005)


def lag(event: str, tick: float) -> Target:
    """How late the rendered force answers a touch or a release, within one tick [s] of the geometry."""
    return Target(f"longest lag of a {event}", "s", 0.8, "800 ms", tick)


BUFFER_COSTS: Final = Target("error less that at the constant delay", to_reach=0.01)
JUMP: Final = Target("largest jump of the rendered force", to_reach=0.05)
"""Of its RMS, beside the constant delay."""
PLANT_JUMP: Final = Target("largest jump of the plant's force", to_reach=0.05)
UPDATE_JUMP: Final = Target("largest jump that an update makes")
UPDATE_JUMP_N: Final = Target("largest jump that an update makes", "N")
GIVEN: Final = Target("runs in which the hand gets energy that was not put in", "runs", to_reach=0.0)
"""Adversaries of a renderer, in `experiment passivity`."""
ENERGY_MADE: Final = Target("energy out of nothing", "J")

REST: Final = Target("the hand's speed where it means to hold still", to_reach=AT_REST)
"""Of its speed before: below this the loop is stable."""
RETURNED: Final = Target("energy beyond what the object could return", "J", to_reach=0.0)

ENGINE_ERROR: Final = Target("off the exact H(s)", to_reach=1e-5)
"""Input known inside the step."""
ENGINE_SAMPLED: Final = Target("the same, poses only sampled", to_reach=1e-5)
ENGINE_COST: Final = Target("a step", "us")
"""To be below that of every other engine in the same run."""

FALSE_ALARMS: Final = Target("false alarms", "contacts", to_reach=0.0)
NOTICED: Final = Target("noticed at the latest after", "s of contact", to_reach=1.0)
"""The estimator's word on its own model, in `experiment adequacy`."""
NOT_ENTERED: Final = Target("laws that did not enter in time", to_reach=0.2)
WRONG_LAWS: Final = Target("runs in which a wrong law was told", to_reach=1.0 / 150.0)
FELT_AFTER: Final = Target("rendered force after the laws have entered, at worst", to_reach=0.015)
FELT_AFTER_FOREIGN: Final = replace(FELT_AFTER, to_reach=0.04)
"""What a learner tells, in `experiment learning`."""
CARRIED: Final = Target("force while an object is carried", to_reach=0.05)
CARRIED_MASS: Final = Target("mass 3 s after it was lifted", to_reach=0.02)
CARRIED_LATE: Final = Target("lift and landing, told late by", "s", to_reach=0.030)
CARRIED_SLIP: Final = Target("slips in the grip that are not told within 30 ms", "runs", to_reach=0.0)
CARRIED_PACE: Final = Target("real time over simulated time", "times")
"""An object that is lifted, in `experiment carrying`, at worst."""
LATE_BY: Final = Target("sum of delay and time constant off by", "s", to_reach=0.0005)
LATE_ERROR: Final = Target("rendered force after 0.5 s of contact", to_reach=0.03)
"""Of a force that is measured late, in `experiment late`, at worst."""
NOT_COVERED: Final = Target("further off than two deviations", to_reach=0.10)
OVER_THE_BOUND: Final = Target("median deviation over the noise's bound", "times", to_reach=3.0)
"""Numbers that the motion tells, in `experiment coverage`."""
TOLD_TRULY: Final = Target("outside their 95 % intervals", to_reach=0.10)
"""Numbers that a first model calls determined, in `experiment fit`."""
FIRST_HALF_SECOND: Final = Target("rendered force, first 0.5 s of contact", to_reach=0.25)
REST_OF_CONTACT: Final = Target("all contact after it", to_reach=0.02)
TOUCHES: Final = Target("first 50 ms of all touches")
MEDIAN_TOUCH: Final = Target("of the median touch", to_reach=0.10)
"""Of a run's contact, in `experiment plants`."""
MEDIAN_OBJECT: Final = Target("median of the objects", to_reach=0.01)
MOST_OBJECTS: Final = Target("95th percentile", to_reach=0.05)
WORST_OBJECT: Final = Target("worst")
MEDIAN_OBJECT_REST: Final = Target("median, all contact after 0.5 s", to_reach=0.015)
MOST_OBJECTS_REST: Final = Target("95th percentile of that", to_reach=0.05)


def bands(
    case: str, error: ForceError | None, targets: Mapping[str, Target], bound: Mapping[str, float | None] | None = None
) -> list[Reached]:
    """The error of the rendered force in every band that holds enough of the force.

    Args:
        case: whose.
        error: of it, against the plant's force without noise.
        targets: by band.
        bound: by band, see `Reached`.
    """
    if error is None:
        return []
    return [
        Reached(case, target, error.tangential[band], (bound or {}).get(band))
        for band, target in targets.items()
        if band in error.telling
    ]


def stable(case: str, metrics: Metrics, *, by_prior: bool) -> Reached:
    """Time in contact until the parameters are stable; what starts from a stable prior gets no verdict."""
    time = metrics.time_to_stable_s
    return Reached(case, STABLE, time, never=time is None, unasked=BY_PRIOR if by_prior else "")


def estimated(case: str, error: ForceError | None) -> list[Reached]:
    """The error of the estimated force, of which the thesis says something and nothing is asked."""
    return [] if error is None else [Reached(case, ESTIMATED, error.tangential["all"])]


def answered(case: str, metrics: Metrics, tick: float) -> list[Reached]:
    """The longest lag of a touch and of a release, `tick` [s] being the clock's."""
    events = (("touch", metrics.touch), ("release", metrics.release))
    return [Reached(case, lag(event, tick), _longest(found), never=found.lost > 0) for event, found in events]


def _longest(lags: Lags) -> float | None:
    """The lag farthest from none [s]; None where no event could be answered, or one was lost."""
    return None if lags.lost else max((abs(each) for each in lags.lags_s if each is not None), default=None)


SECOND_TOUCH: Final = Target("first 0.5 s of a touch of a known object, worst", to_reach=0.03)
SECOND_TOUCH_FOREIGN: Final = Target("the same on the foreign plant", to_reach=0.08)
"""Of set-up 4, on its own and on the foreign plant."""
TOUCH_LATE: Final = Target("touch or release off the truth", "s", to_reach=0.03)
ENERGY_GIVEN: Final = Target("energy given that was not put in", "J", to_reach=1e-5)
SLOWNESS: Final = Target("time for a second of simulation", "s", to_reach=1.0 / 3.0)
IDENTITY_LOST: Final = Target("object-minutes in view without the first identity", to_reach=0.1)
SWAPPED: Final = Target("identities swapped without a word", "times", to_reach=0.0)
