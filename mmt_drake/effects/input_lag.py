"""An actuator that follows its command with a first-order lag: a current loop, a valve, a heater.

The body is driven by y, tau y' = u - y, in the place of the recorded input u. Between samples u is taken as linear, for
which the answer is exact; at the first sample it has settled. In a closed loop the goal is what lags.

Easily confused with:

- `time_delay`: alike where the input changes slower than 1/(2 pi tau); faster, a lag weakens it and a delay does not.
- `second_mode`: a delay and a further mass come near to a lag together, with four numbers in the place of one.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter

EFFECT = Effect(
    name="input_lag",
    block="channel",
    family="timing",
    parameters=(Parameter("tau", "s", NOT_NEGATIVE),),
    equation="driven by y, tau y' = input - y",
    source="Ljung 1999, System Identification, section 4.2",
    change=lambda model, values: model.with_additions(lag=values["tau"]),
    only_in=("driven_body",),
    near_equal={"time_delay": "the input changes slower than 1/(2 pi tau)"},
    starts=lambda scales: [{"tau": part / scales.frequency} for part in (0.01, 0.05, 0.2)],
)
