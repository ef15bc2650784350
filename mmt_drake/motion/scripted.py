"""Named motions of the operator's hand, in closed form.

Every motion begins and ends at rest at (0, 0, clearance) [m], above the object, and begins again
after `duration` seconds. Contact is z < 0. With the default parameters the hand stays below 1 m/s and
within 0.1 m of the middle; `visits` and `carry_over` go to three objects, 0.2 m.
"""

import inspect
import math
import numbers
from collections.abc import Callable

from mmt_drake.errors import BadInput
from mmt_drake.motion.along_axis import chirp, sines, stroke_and_hold, strokes
from mmt_drake.motion.analytic import AnalyticMotion
from mmt_drake.motion.between_targets import press_slide_lift, reaches
from mmt_drake.motion.carrying import carry
from mmt_drake.motion.reaching import AXES
from mmt_drake.motion.visits import carry_over, visits

#: Every scripted motion by its name.
SCRIPTED: dict[str, Callable[..., AnalyticMotion]] = {
    builder.__name__: builder
    for builder in (strokes, chirp, press_slide_lift, sines, reaches, stroke_and_hold, carry, visits, carry_over)
}

_CHOICES = {"axis": tuple(AXES), "first": ("fast", "slow")}
_MAY_BE_ZERO = {"seed", "lifts", "tremor", "first_low", "last_low"}


def scripted_parameters(name: str) -> dict[str, float | int | str]:
    """Parameters of a scripted motion and their defaults.

    Raises:
        BadInput: no motion has that name.
    """
    if name not in SCRIPTED:
        raise BadInput("scripted motion", found=repr(name), expected=f"one of {', '.join(SCRIPTED)}")
    return {key: item.default for key, item in inspect.signature(SCRIPTED[name]).parameters.items()}


def scripted_motion(name: str, **parameters: float | int | str) -> AnalyticMotion:
    """A scripted motion by its name.

    Args:
        name: one of `SCRIPTED`.
        parameters: those of the builder of that name.

    Raises:
        BadInput: an unknown name or parameter, or a value that makes no sense.
    """
    defaults = scripted_parameters(name)
    for key, value in parameters.items():
        if key not in defaults:
            raise BadInput(name, at=key, found="an unknown parameter", expected=f"one of {', '.join(defaults)}")
        _check(name, key, value, like=defaults[key])
    return SCRIPTED[name](**parameters)


def _check(name: str, key: str, value: object, like: float | int | str) -> None:
    if isinstance(like, str):
        if value not in _CHOICES[key]:
            raise BadInput(name, at=key, found=repr(value), expected=" or ".join(_CHOICES[key]))
        return
    kind = numbers.Integral if isinstance(like, int) else numbers.Real
    least = "an integer" if isinstance(like, int) else "a finite number"
    zero = key in _MAY_BE_ZERO
    if not isinstance(value, kind) or isinstance(value, bool) or not math.isfinite(value):
        raise BadInput(name, at=key, found=repr(value), expected=least)
    if value < 0 or (value == 0 and not zero):
        raise BadInput(name, at=key, found=value, expected=f"{least}, {'>= 0' if zero else '> 0'}")
