"""A drive that does not answer a small input: an amplifier's dead band, a valve's overlap.

The body is driven by sgn(u) max(|u| - width/2, 0) instead of the input u; the output of a transmission is where that
has it.

Easily confused with:

- `coulomb_friction`: both take a constant part of a large input; friction turns with the motion, a dead band with the
  input, so coasting against the input, and holding a load, tell them apart.
- `contact_gap`: clearance of the spring, not of the input; a body without a spring has none.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter

EFFECT = Effect(
    name="dead_band",
    block="drive",
    family="drive_train",
    parameters=(Parameter("width", "1", NOT_NEGATIVE),),
    equation="driven by sgn(u) max(|u| - width/2, 0), width in units of the input",
    source="Tao and Kokotovic 1996, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, chapter 2",
    change=lambda model, values: model.with_additions(dead_band=values["width"]),
    starts=lambda scales: [{"width": part * scales.input} for part in (0.2, 0.8)],
)
