"""Findings of experiments 1 and 3 that their tables do not show, in sentences that are made from the figures."""

from collections.abc import Iterable

from mmt_drake.analysis.lags import Lags
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.wording import milliseconds, percent
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun, ratio_of
from mmt_drake.diagrams.proof.experiments.targets import DELAY_COSTS
from mmt_drake.diagrams.proof.experiments.thesis import DELAYED, MAIN, NOT_THE_THESIS_S
from mmt_drake.diagrams.stations.scenario import updates_name
from mmt_drake.network.parameters import usual_delay

_TWICE = 2.0
"""Errors count as different where one is more than twice the other."""
_PEAK = 10.0
"""A force is named that is so many times the measured force's RMS."""


def findings(cases: Cases) -> list[str]:
    """One sentence or two per finding, the thesis's own beside it; every number is the cases'."""
    running = by_equations(cases)
    found = [_shapes(running)]
    if _round_trip(cases[MAIN]) > 0.0:
        found.append(_between_switches(running))
    found.append(_lags(cases[MAIN]))
    found += [_beside_operator(cases[far], cases[near]) for far, near in DELAYED.items() if {far, near} <= cases.keys()]
    found += [_smeared(case) for case in cases.values()]
    return [sentence for sentence in found if sentence]


def by_equations(cases: Cases) -> list[MeasuredRun]:
    """The cases that are the thesis's but for how eq. 30 is solved."""
    return [case for case in cases.values() if case.name not in NOT_THE_THESIS_S]


def _known(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _range(values: list[float]) -> str:
    low, high = percent(min(values)), percent(max(values))
    return low if low == high else f"{low} to {high}"


def _between_switches(running: list[MeasuredRun]) -> str:
    ratios = _known(ratio_of(case.settled.between_switches_error) for case in running)
    if not ratios:
        return ""
    return (
        f"Away from touches and releases, in the same second half, it is off by {_range(ratios)} "
        "(thesis: practically no effect of the delay while no model is switched)."
    )


def _shapes(running: list[MeasuredRun]) -> str:
    """Which cases err like experiment 1 of the thesis, by frequency, and which like its experiment 3."""
    rising, falling = [], []
    for case in running:
        low, high = (ratio_of(case.metrics.rendered_error, band) for band in ("below_0.3_hz", "3_to_10_hz"))
        if low is None or high is None or smeared(case):
            continue
        if high > _TWICE * low:
            rising.append(case.name)
        if low > _TWICE * high:
            falling.append(case.name)
    return (
        "More than twice as large at 3 to 10 Hz as below 0.3 Hz, as the thesis has it in experiment 1: "
        f"{', '.join(rising) or 'no case'}. The other way round, as it has it in experiment 3: "
        f"{', '.join(falling) or 'no case'}."
    )


def _lags(main: MeasuredRun) -> str:
    touch, release = main.metrics.touch.median_s, main.metrics.release.median_s
    round_trip = _round_trip(main)
    lags = [f"{name} {milliseconds(lag)}" for name, lag in (("touch", touch), ("release", release)) if lag is not None]
    if not lags:
        return "No touch or release was answered."
    text = f"The rendered force answers late, median: {' and '.join(lags)}"
    if round_trip == 0.0:
        return text + "; without a delay that is what detector, estimator and renderer take."
    return text + f"; the round trip takes {milliseconds(round_trip)} (thesis: 800 ms on the graph)."


def _beside_operator(far: MeasuredRun, near: MeasuredRun) -> str:
    """What a second contact detector beside the operator makes of the delay."""
    touch, release = (_answered(lags) for lags in (far.metrics.touch, far.metrics.release))
    text = (
        f"{far.name}, with a second contact detector beside the operator on the cloud that the network has brought: "
        f"touches are answered {touch}, releases {release} (to reach: within one tick)."
    )
    most = DELAY_COSTS.to_reach or 0.0
    for what, ours, theirs in (
        ("The rendered force is", far.metrics, near.metrics),
        ("In the second half of the contact time it is", far.settled, near.settled),
    ):
        off, near_off = ratio_of(ours.rendered_error_true), ratio_of(theirs.rendered_error_true)
        if off is not None and near_off is not None:
            text += (
                f" {what} {percent(off)} off, without the delay {percent(near_off)}: "
                f"{100.0 * (off - near_off):+.2g} percentage points (to reach: {100.0 * most:g})."
            )
    return f"{text} Both against the plant's force without noise; the case takes up new parameters {_updates(far)}."


def _updates(case: MeasuredRun) -> str:
    """How new parameters are taken up, in words."""
    return (updates_name(case.scenario) or "not at all").replace("_", " ")


def _answered(lags: Lags) -> str:
    answered = _known(lags.lags_s)
    if not answered or len(answered) < len(lags.lags_s):
        return f"in {len(answered)} of {len(lags.lags_s)} cases"
    return f"{milliseconds(max(answered, key=abs))} late at most"


def _round_trip(case: MeasuredRun) -> float:
    """What the network takes there and back [s]."""
    scenario = case.scenario
    return sum(usual_delay(way, scenario.step) for way in (scenario.to_telerobot, scenario.to_operator))


def smeared(case: MeasuredRun) -> list[str]:
    """Bands whose error is larger than that of the unfiltered force over the same samples.

    There the band's filter, which runs over the whole recording, has brought in the error of another time.
    """
    error = case.metrics.rendered_error
    whole = (error.tangential["all"] or 0.0) * error.reference_rms["all"]
    return [
        band
        for band, ratio in error.tangential.items()
        if ratio is not None and ratio * error.reference_rms[band] > whole
    ]


def _smeared(case: MeasuredRun) -> str:
    bands = [band for band in smeared(case) if band != "all"]
    if not bands:
        return ""
    error = case.metrics.rendered_error
    named = ", ".join(f"{BAND_NAMES[band]} {percent(ratio_of(error, band))}" for band in bands)
    peak = ""
    if case.peak_force > _PEAK * error.reference_rms["all"]:
        peak = f" (the rendered force reached {case.peak_force:,.0f} N at {case.peak_at:.2f} s)"
    return (
        f"{case.name}: the band filters run over the whole recording and smear the wind-up{peak} into the samples that "
        f"count: {named}, while the whole error is {percent(ratio_of(error))}."
    )
