"""Force that is recorded later than the position that caused it, by a constant time.

The model answers to the motion (or the input) of `delay` seconds ago; before the first sample the motion is at rest
where the first sample is. Two clocks with an offset, a filter in one channel, a network.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter

EFFECT = Effect(
    name="time_delay",
    block="channel",
    family="timing",
    parameters=(Parameter("delay", "s", NOT_NEGATIVE),),
    equation="force(t) answers to position(t - delay)",
    source="Richard 2003, Automatica 39(10)",
    change=lambda model, values: model.with_additions(delay=values["delay"]),
    starts=lambda scales: [{"delay": part / scales.frequency} for part in (0.005, 0.02, 0.08, 0.25)],
)
