"""Names and numbers as people write them."""

import math
from collections.abc import Iterable
from typing import Final

from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.decide.budget import NAMELESS, PARAMETERS, SHARED
from mmt_drake.diagnosis.decide.mismatch import Dependence, Mismatch
from mmt_drake.diagnosis.tell.result import TABULATED, Diagnosis, EffectParameter, Fit, NamedEffect
from mmt_drake.effects.wording import words

PERCENT: Final = (
    "Percent of an error means one thing here: a share of the mean squared error that the model handed in makes "
    "on held-out data."
)
"""The only definition of percent; other errors are told as RMS, in the unit of what was measured."""

FOLLOWED: Final = 0.1
"""A signal is told only if the error's mean over it has more than this part of the error's variance ..."""
CLEARLY: Final = 0.1
"""... and this much more of it than the mean over any other signal has."""

_SMALL: Final = 0.01
_CLEARLY_LESS: Final = 0.8
_PREFIXED: Final = ("m", "N", "rad", "A", "V")
_PREFIXES: Final = (("m", 1e3), ("µ", 1e6), ("n", 1e9))

_PARTS: Final = {
    PARAMETERS: "wrong parameters",
    SHARED: "parameters and effects together",
    NAMELESS: "what nobody has named",
}


def all_words(names: Iterable[str]) -> str:
    """Names side by side: `static friction + contact gap`."""
    return " + ".join(map(words, names))


def listed(names: Iterable[str], last: str = "and") -> str:
    """`a`, `a and b`, `a, b and c`."""
    *most, end = [name for name in names if name] or [""]
    return f"{', '.join(most)} {last} {end}" if most else end


def capitalised(text: str) -> str:
    """The text with a capital first letter, the others as they are."""
    return text[:1].upper() + text[1:]


def part_words(part: str, effects: Iterable[NamedEffect] | None = None) -> str:
    """A part of a budget as people write it; `effects`: those that are told, where it matters whether there are any."""
    names = None if effects is None else {effect.name for effect in effects}
    if part == SHARED and names is not None and not names - {TABULATED}:
        return "parameters and the table together" if names else "wrong parameters that cannot be told apart"
    return _PARTS.get(part, words(part))


def share_words(share: float) -> str:
    """A share of the squared error as percent (`PERCENT`), without digits that mean nothing."""
    if 0.0 < share < 0.005:
        return "under 1 %"
    return f"{100.0 * share:.0f} %"


def model_words(diagnosis: Diagnosis) -> str:
    """What the model that was diagnosed is called."""
    return "the model handed in" if diagnosis.first_model is None else "the first model"


def rms_words(fit: Fit, nrmse: float) -> str:
    """An error of `Fit.heldout_nrmse` as RMS with its unit; over the spread of what was measured if that is unknown."""
    rms = fit.rms(nrmse)
    if rms is None:
        return f"{significant(nrmse, 3)} of the measured spread"
    prefix, factor = "", 1.0
    if 0.0 < rms < _SMALL and fit.unit.partition(" ")[0] in _PREFIXED:
        prefix, factor = next((one for one in _PREFIXES if rms * one[1] >= 1.0), _PREFIXES[-1])
    return f"{significant(rms * factor, 3)} {prefix}{fit.unit}".rstrip()


def noise_words(fit: Fit) -> str:
    """What noise alone would leave, to stand behind errors; nothing where that is unknown.

    Where a model leaves clearly less the noise was taken for too much, and that is said.
    """
    floor, errors = fit.noise_floor, fit.heldout_nrmse
    if floor is None:
        return ""
    least = min((e for e in (errors.nominal, errors.refit, errors.augmented) if e is not None), default=floor)
    if least < _CLEARLY_LESS * floor:
        return f"; that is less than the {rms_words(fit, floor)} taken for noise, which is then less too"
    return f"; noise alone would leave {rms_words(fit, floor)}"


def bounded(value: float, interval: tuple[float, float] | None) -> tuple[str, str | None]:
    """A number, and its 95 % interval, to three digits, or as many as tell its ends apart; None where it is unknown."""
    if interval is None or not all(map(math.isfinite, interval)):
        return significant(value, 3), None
    for digits in range(3, 7):
        low, known, high = (significant(number, digits) for number in (interval[0], value, interval[1]))
        if len({low, known, high}) == 3:
            break
    return known, f"{low} to {high}"


def in_degrees(effect: NamedEffect, number: EffectParameter) -> EffectParameter:
    """A number of an effect as people read it: angles of frames in degrees, all else as it is."""
    if effect.family != "geometry" or number.unit != "rad" or not isinstance(number.value, float):
        return number
    ends = None if number.ends is None else (math.degrees(number.ends[0]), math.degrees(number.ends[1]))
    return EffectParameter(math.degrees(number.value), "degrees", ends)


def followed(mismatch: Mismatch) -> Dependence | None:
    """The signal that the error follows, where that is clear; None where none is followed, or several alike."""
    clear = [one for one in mismatch.depends_on if one.score > FOLLOWED]
    if not clear or any(clear[0].score < one.score + CLEARLY for one in mismatch.depends_on[1:]):
        return None
    return clear[0]


def span(interval: tuple[float, float]) -> str:
    """A stretch of time: `3.1 to 4 s`."""
    return f"{significant(interval[0], 3)} to {significant(interval[1], 3)} s"
