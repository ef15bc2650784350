"""A payload taken on or lost at one moment, the body's velocity being continuous.

The mass is m before `time` and m + dm after it, `time` counted from the first sample; within 1 ms before and after it
passes smoothly from one to the other, so that a search can feel which way to move it. Where constant gravity acts along
the output, the payload's weight comes and goes with it.

Mass that is lost takes its motion along; mass that comes with the body's velocity brings energy, and is not passive.

Easily confused with:

- `second_mode`: below its resonance a hung mass is a mass more; strokes through its resonance tell them apart.
- `stiffness_step`: both change the object at one moment; slow strokes tell them apart, in which a mass does not show.
"""

from collections.abc import Callable

from numba import njit

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Scales, Values
from mmt_drake.effects.passivity import Passive
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import ActiveLaw, At, Numbers, Own, Result, Slot, law
from mmt_drake.model.structure import Structure

PASSAGE = 2e-3
"""Time that the change takes [s]."""


@njit(cache=True, inline="always")
def passed(t: float, time: float) -> float:
    """How much of what changes at `time` [s] has changed at `t`: 0 before, 1 after, smoothly within `PASSAGE`."""
    part = min(max((t - time) / PASSAGE + 0.5, 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)


@law(Slot.INERTIA)
def _payload(at: At, q: Own, p: Numbers) -> Result:
    time, dm = p[0], p[1]
    return dm * passed(at.t, time), 0.0, 0.0, 0.0


@law(Slot.BODY)
def _weight(at: At, q: Own, p: Numbers) -> Result:
    time, dm, g = p[0], p[1], p[2]
    return -g * dm * passed(at.t, time), 0.0, 0.0, 0.0


def _change(model: Structure, values: Values) -> Structure:
    time, dm, g = values["time"], values["dm"], model.value("g")
    changed = model.with_law(ActiveLaw(_payload, (time, dm), lightens=max(-dm, 0.0)))
    return changed.with_law(ActiveLaw(_weight, (time, dm, g))) if g != 0.0 else changed


def _check(model: Structure, values: Values, source: str) -> None:
    m, dm = model.value("m"), values["dm"]
    if not m + dm > 0.0:
        raise BadInput(source, at="dm", found=f"{dm:g}", expected=f"more than -{m:g} kg, the mass of the body")


def within(signal: str) -> Callable[[Values, Ranges], bool]:
    """The `engages` of what happens once: neither as soon as anything shows, nor as long as that.

    A first touch is unlike the rest, and a moment of it is no state that something was in before.
    """

    def happens(values: Values, ranges: Ranges) -> bool:
        first, last = ranges[signal]
        margin = _MARGIN * (last - first)
        return first + margin < values["time"] < last - margin

    return happens


_MARGIN = 0.01


def _starts(scales: Scales) -> list[Values]:
    times = [k / 21.0 * scales.duration for k in range(1, 21)]
    return [{"time": time, "dm": part * scales.mass} for time in times for part in (0.3, -0.3)]


EFFECT = Effect(
    name="mass_change",
    block="body",
    family="inertia",
    parameters=(Parameter("time", "s", NOT_NEGATIVE, shape=True, moment=True), Parameter("dm", "kg")),
    equation="mass m before `time`, m + dm after it, the velocity continuous",
    source="Meshchersky 1897; Sommerfeld 1943, Mechanik, section 4",
    change=_change,
    inertial=True,
    passive=Passive("dm <= 0", lambda model, values: bool(values["dm"] <= 0.0)),
    check=_check,
    engages=within("time"),
    starts=_starts,
)
