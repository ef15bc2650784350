"""A force sensor that follows with the lag of a first-order filter.

tau y' = F - y, y recorded. Between samples F is taken as linear, for which the filter's answer is exact; at the first
sample it has settled.

Easily confused with:

- `time_delay`: alike in strokes slower than 1/(2 pi tau); fast ones tell them apart: a lag weakens them, a delay does
  not.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law
from mmt_drake.numeric.low_pass import low_passed


@law(Slot.SENSOR, remembers=True, order=0, every_axis=True)
def _first_order(at: At, q: Own, p: Numbers) -> Result:
    # Remembered are the filter's output and its input.
    tau, u = p[0], at.force
    if tau == 0.0 or at.t == 0.0:
        return u, u, u, 0.0
    if at.h == 0.0:  # the same instant once more
        return q[0], q[0], u, 0.0
    y = low_passed(q[0], q[1], u, at.h / tau)
    return y, y, u, 0.0


EFFECT = Effect(
    name="force_lag",
    block="force_sensor",
    family="timing",
    parameters=(Parameter("tau", "s", NOT_NEGATIVE),),
    equation="recorded force y, tau y' = force - y",
    source="Doebelin 2004, Measurement Systems, chapter 3",
    law=_first_order,
    starts=lambda scales: [{"tau": part / scales.frequency} for part in (0.01, 0.05, 0.2)],
)
