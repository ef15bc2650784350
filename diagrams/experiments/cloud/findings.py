"""What the experiment on measured clouds says, in sentences made from its numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.wording import percent, significant
from mmt_drake.diagrams.experiments.cloud.run import Case, Result, cases_of


def cloud_findings(result: Result) -> list[str]:
    """The verdict: up to which noise contact is found without a slip, by which filters, and what these cost."""
    plan = result.plan
    best = {noise: _best(cases_of(result, noise=noise)) for noise in sorted(plan.noise)}
    sure = [noise for noise, case in best.items() if case.score.slips == 0]
    sentences = [_verdict(sure, best)]
    sentences += [_told(case) for case in best.values()]
    for alpha in plan.alpha:
        cases = cases_of(result, alpha=alpha)
        slips = sum(case.score.slips for case in cases)
        contacts = sum(case.score.contacts for case in cases)
        sentences.append(
            f"{filter_name(alpha).capitalize()}: {slips} slips in {contacts} contacts, all cameras together."
        )
    return sentences


def filter_name(alpha: float) -> str:
    """A temporal filter in words."""
    return "each frame by itself" if alpha == 1.0 else f"temporal filter with alpha {alpha:g}"


def middle(values: NDArray[np.float64]) -> tuple[float | None, float | None]:
    """Median, and half the range from the 5th to the 95th percentile; None of nothing."""
    if len(values) == 0:
        return None, None
    low, median, high = np.percentile(values, (5.0, 50.0, 95.0))
    return float(median), float(0.5 * (high - low))


def _best(cases: Sequence[Case]) -> Case:
    """The case with the fewest slips, and of those the one that is wrong for the least time."""
    return min(cases, key=lambda case: (case.score.slips, case.score.wrong))


def _verdict(sure: Sequence[float], best: dict[float, Case]) -> str:
    if not sure:
        return "Verdict: on no cloud that was tried is every contact found once and none besides."
    most = max(sure)
    unsure = [noise for noise in best if noise not in sure]
    rest = f"; with {_noise(min(unsure))} no filter that was tried is enough" if unsure else ""
    return (
        f"Verdict: with {_noise(most)} ({_mm(best[most].untouched.roughness)} left in the cloud) every contact is "
        f"found once and none besides, if the cloud is filtered well{rest}."
    )


def _told(case: Case) -> str:
    s = case.score
    lag, spread = middle(s.touch_lags)
    touch = "" if lag is None or spread is None else f"; touch is told {_ms(lag)} late, give or take {_ms(spread)}"
    counts = f"{s.missed} of {s.contacts} contacts missed, {s.false} false, {s.breaks} breaks"
    return (
        f"With {_noise(case.noise)} best are voxels of {_mm(case.voxel)}, {filter_name(case.alpha)}: {counts}, "
        f"wrong for {percent(s.wrong)} of the time{touch}."
    )


def _noise(amount: float) -> str:
    return "no noise" if amount == 0.0 else f"{amount:g} times a stereo camera's noise"


def _mm(length: float) -> str:
    return f"{significant(1e3 * length, 3)} mm"


def _ms(time: float) -> str:
    return f"{significant(1e3 * time, 3)} ms"
