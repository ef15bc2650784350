"""A force sensor that picks up a vibration: mains hum, a fan, a pump.

amplitude sin(2 pi frequency t + phase) is added to the recorded tangential force, t from the first sample.

Easily confused with:

- `force_drift`: alike in less than a quarter of a period; a longer recording tells them apart.
"""

from math import pi, sin

from mmt_drake.effects.effect import NOT_NEGATIVE, PHASES, Effect, Parameter, Scales, Values
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law


@law(Slot.SENSOR, order=1)
def _hum(at: At, q: Own, p: Numbers) -> Result:
    amplitude, frequency, phase = p[0], p[1], p[2]
    return at.force + amplitude * sin(2.0 * pi * frequency * at.t + phase), q[0], q[1], 0.0


def _starts(scales: Scales) -> list[Values]:
    frequencies = [*scales.peaks, *(part * scales.frequency for part in (0.3, 1.0, 3.0))]
    return [
        {"amplitude": 0.1 * scales.force, "frequency": frequency, "phase": phase}
        for frequency in frequencies
        for phase in PHASES
    ]


EFFECT = Effect(
    name="periodic_disturbance",
    block="force_sensor",
    family="sensor",
    parameters=(
        Parameter("amplitude", "N", NOT_NEGATIVE),
        Parameter("frequency", "Hz", NOT_NEGATIVE, vanishes_at=1.0, shape=True),
        Parameter("phase", "rad", shape=True),
    ),
    equation="recorded force = force + amplitude sin(2 pi frequency t + phase)",
    source="Doebelin 2004, Measurement Systems, chapter 2",
    law=_hum,
    starts=_starts,
    engages=lambda values, ranges: values["frequency"] * (ranges["time"][1] - ranges["time"][0]) >= 2.0,  # repeats
)
