"""A contact whose force relaxes while it is held: a spring and a damper in series beside the contact spring (Maxwell).

k_maxwell (d - q) with q' = (d - q)/tau. A deflection that is held gives k_maxwell d exp(-t/tau) more, a slow one
nothing, a fast one a spring k_maxwell more. At each touch the branch is relaxed.

Easily confused with:

- `time_delay`: in slow strokes both pass for another contact damper, a greater one here and a lesser one there; a hold
  after a fast stroke tells them apart: only the branch relaxes.
- `force_lag`: in slow strokes both pass for another contact damper, as with a delay; a hold after a fast stroke tells
  them apart: the branch overshoots and relaxes, the lag creeps up.
- `hysteresis`: alike at one frequency; the same stroke slow and fast tells them apart: only relaxation minds the time.
"""

from math import inf

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Scales, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law

TIME_CONSTANT = Parameter("tau", "s", (1e-5, inf), vanishes_at=0.1, shape=True)
"""Of a branch that relaxes."""
_NO_MORE_THAN_A_SPRING = 10.0  # durations of the longest contact that the branch takes to give way


def _stored(at: At, q: Own, p: Numbers) -> Result:
    return 0.5 * p[0] * (at.d - q[0]) ** 2, 0.0, 0.0, 0.0


@law(Slot.CONTACT, remembers=True, stored=_stored)
def _maxwell(at: At, q: Own, p: Numbers) -> Result:
    k, rate = p[0], 1.0 / p[1]
    stretch = at.d - q[0]
    return k * stretch, stretch * rate, 0.0, rate


def _starts(scales: Scales) -> list[Values]:
    return [{"k_maxwell": 0.3 * scales.stiffness, "tau": tau} for tau in time_constants(scales)]


def time_constants(scales: Scales) -> list[float]:
    """With which a search begins: of what relaxes within a slow motion, along it, and hardly [s]."""
    return [part / scales.frequency for part in (0.05, 0.3, 2.0)]


def relaxes(values: Values, ranges: Ranges) -> bool:
    """True where the branch, relaxed at each touch, gives way until the release, and not from sample to sample.

    One that does not give way is a spring, and one that gives way at once a damper.
    """
    slowest = _NO_MORE_THAN_A_SPRING * ranges["since_touch"][1]
    return ranges["step"][1] < values["tau"] < slowest


EFFECT = Effect(
    name="viscoelastic_relaxation",
    block="contact",
    family="contact_loss",
    parameters=(Parameter("k_maxwell", "N/m", NOT_NEGATIVE), TIME_CONSTANT),
    equation="k_maxwell (d - q), q' = (d - q)/tau, beside the contact spring",
    source="Maxwell 1867, Phil. Trans. R. Soc. 157; Wiechert 1893, Annalen der Physik 286(10)",
    law=_maxwell,
    stiffness=lambda values: values["k_maxwell"],
    sought_beside=("k2",),
    passive=ALWAYS,
    engages=relaxes,
    starts=_starts,
)
