"""Claims: what the thesis's figures show, each as something that a run either shows too or does not.

The thesis does not say whether its measured force is the one that is sent to the estimator or the one that the
estimator sees, behind its filters. So a claim is held against runs measured by either.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from mmt_drake.analysis.metrics import ForceError, Metrics

_LOW, _MIDDLE, _HIGH = "below_0.3_hz", "0.3_to_3_hz", "3_to_10_hz"
_ROUND_TRIP_S, _NEAR_S = 0.8, 0.02
_ALIKE = 0.25  # difference of spikes in height, up to which they look the same


REFERENCES: Final = ("raw", "filtered")
"""What may be the thesis's measured force: `force_*`, as sent to the estimator, and `filtered_force_*`, as it is behind
the estimator's filters, late by them. An estimator that filters nothing sees the force that is sent."""


@dataclass(frozen=True)
class Runs:
    """The runs with one cause in them, measured: rendered and estimated force against one of `REFERENCES`.

    Attributes:
        running: experiment 1.
        frozen: the same with the parameters frozen after 5 s of contact.
        delayed: experiment 3, 400 ms each way.
        spikes, frozen_spikes: by how much rendered and estimated force differ in the height of their spikes, see
            `run.spikes`, running and frozen.
    """

    running: Metrics
    frozen: Metrics
    delayed: Metrics
    spikes: float
    frozen_spikes: float

    def rendered(self, band: str = "all") -> float:
        """By how much the rendered force is off, running."""
        return _off(self.running.rendered_error, band)

    @property
    def estimated(self) -> float:
        """By how much the estimated force is off, running."""
        return _off(self.running.estimated_error_raw)

    @property
    def fitted(self) -> float:
        """By how much it is off what the estimator sees, whatever the reference."""
        return _off(self.running.estimated_error)

    @property
    def risen(self) -> bool:
        """Whether freezing makes the estimated force err."""
        return _off(self.frozen.estimated_error_raw) >= max(0.1, 2.0 * self.estimated)


@dataclass(frozen=True)
class Claim:
    """What one figure of the thesis shows, or two that show the same.

    Attributes:
        figures: their numbers.
        says: what the thesis says of them, in our words.
        needs: what a run has to show to reproduce them, in words.
        holds: whether it does.
    """

    figures: tuple[int, ...]
    says: str
    needs: str
    holds: Callable[[Runs], bool]

    @property
    def name(self) -> str:
        """The figures' numbers."""
        return ", ".join(map(str, self.figures))


def _off(error: ForceError | None, band: str = "all") -> float:
    """The tangential error in a band; NaN, which no claim survives, where it is not known."""
    ratio = None if error is None else error.tangential[band]
    return float("nan") if ratio is None else ratio


def _late(lag: float | None) -> bool:
    return lag is not None and abs(lag - _ROUND_TRIP_S) <= _NEAR_S


def _frozen_alike(runs: Runs) -> bool:
    ratio = _off(runs.frozen.estimated_error_raw) / _off(runs.frozen.rendered_error)
    return runs.risen and 0.5 <= ratio <= 2.0 and runs.frozen_spikes <= _ALIKE


def _delayed_poor_at_low(runs: Runs) -> bool:
    off = runs.delayed.between_switches_error
    poor = _off(off, _LOW) >= max(0.2, 2.0 * _off(off, _HIGH))
    return poor and _late(runs.delayed.touch.median_s) and _late(runs.delayed.release.median_s)


CLAIMS: Final = (
    Claim(
        (10, 30),
        "the estimated force follows the measured one, the rendered force follows neither.",
        "estimated off by at most 10 %, rendered by at least 20 %",
        lambda runs: runs.estimated <= 0.1 and runs.rendered() >= 0.2,
    ),
    Claim(
        (29,),
        "the estimator's error is noticeably lower than the renderer's.",
        "estimated off the force that the estimator sees by at most 10 %, and at most half as much as rendered",
        lambda runs: runs.fitted <= 0.1 and runs.fitted <= 0.5 * runs.rendered(),
    ),
    Claim(
        (24,),
        "measured and rendered force look alike and part at higher frequencies.",
        "rendered off by at most 30 % below 0.3 Hz, twice as much from 3 to 10 Hz",
        lambda runs: runs.rendered(_LOW) <= 0.3 and runs.rendered(_HIGH) >= 2.0 * runs.rendered(_LOW),
    ),
    Claim(
        (25,),
        "at low frequencies the error is smaller, but reaches 30 %.",
        "rendered off by 5 to 40 % below 0.3 Hz",
        lambda runs: 0.05 <= runs.rendered(_LOW) <= 0.4,
    ),
    Claim(
        (26,),
        "at high frequencies the error is as large as the force.",
        "rendered off by 70 to 150 % from 3 to 10 Hz",
        lambda runs: 0.7 <= runs.rendered(_HIGH) <= 1.5,
    ),
    Claim(
        (27, 28),
        "the spectrum of the error stays low up to 0.3 Hz and is of the order of the force's above.",
        "rendered off by at most 30 % below 0.3 Hz, by at least 40 % in both bands above",
        lambda runs: runs.rendered(_LOW) <= 0.3 and min(runs.rendered(_MIDDLE), runs.rendered(_HIGH)) >= 0.4,
    ),
    Claim(
        (11,),
        "with the parameters frozen after 5 s the estimated force starts to err like the rendered one.",
        "frozen: estimated off by at least 10 %, twice as much as running, half to twice as much as rendered; height "
        "of spikes (envelope from 3 to 10 Hz) of both within 25 %",
        _frozen_alike,
    ),
    Claim(
        (31,),
        "the spikes of estimated and rendered force, which differed, become alike once the parameters are frozen.",
        "height of spikes of both within 25 % frozen, but not running; estimated off by at least 10 % frozen, twice as "
        "much as running",
        lambda runs: runs.risen and runs.frozen_spikes <= _ALIKE < runs.spikes,
    ),
    Claim(
        (14,),
        "with 400 ms each way: poor at low, good at high frequencies; 800 ms late at touch and release.",
        "delayed, between switches: off by at least 20 % below 0.3 Hz and twice as much as from 3 to 10 Hz; 780 to "
        "820 ms later than the contact at both",
        _delayed_poor_at_low,
    ),
    Claim(
        (35,),
        "with 400 ms each way: 800 ms late where the force ends at a release.",
        "delayed: 780 to 820 ms later than the contact at releases",
        lambda runs: _late(runs.delayed.release.median_s),
    ),
)
