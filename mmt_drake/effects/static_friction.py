"""Stick and slip with a break-away level above the sliding level, after Karnopp.

The body sticks (v = 0) while abs(v) < v_d and the drive of the body at rest is below Fs; otherwise friction is
Fd sgn v. It takes the place of the structure's Fc. Under a prescribed velocity (`kelvin_voigt`) nothing can stick:
there friction is Fd in the direction of sliding, which is kept while abs(v) is at most v_d.

Easily confused with:

- `coulomb_friction`: alike once the body slides; starts from rest, after a dwell, tell them apart.
- `stribeck_friction`: both fall after break-away, one in a step and one along a curve; slow, steady strokes about v_s
  tell them apart.
- `presliding_friction`: alike in long strokes; below break-away the body rests here and creeps on its bristles there:
  loads just below break-away tell them apart.
"""

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Scales, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.errors import BadInput
from mmt_drake.model.structure import Friction, Structure


def _karnopp(model: Structure, values: Values) -> Structure:
    return model.with_value("Fc", 0.0).with_additions(friction=Friction(values["Fs"], values["Fd"], values["v_d"]))


def _check(model: Structure, values: Values, source: str) -> None:
    if values["Fd"] > values["Fs"]:
        raise BadInput(source, at="Fd", found=f"{values['Fd']:g}", expected=f"at most Fs = {values['Fs']:g} N")


def _starts(scales: Scales) -> list[Values]:
    return [
        {"Fs": level * scales.force, "Fd": part * level * scales.force, "v_d": band * scales.velocity}
        for level in (0.1, 0.3, 0.8)
        for part in (0.4, 0.8)
        for band in (0.02, 0.1)
    ]


EFFECT = Effect(
    name="static_friction",
    block="friction",
    family="dry_friction",
    parameters=(
        Parameter("Fs", "N", NOT_NEGATIVE, vanishes_at="Fc"),
        Parameter("Fd", "N", NOT_NEGATIVE, vanishes_at="Fc"),
        Parameter("v_d", "m/s", NOT_NEGATIVE, shape=True),
    ),
    equation="sticks (v = 0) while |v| < v_d and the drive of the body at rest is below Fs; else Fd sgn v",
    source="Karnopp 1985, J. Dyn. Sys. Meas. Control 107(1)",
    change=_karnopp,
    check=_check,
    replaces="Fc",
    holds=("coulomb_friction",),  # one that breaks away at the level that it slides at
    passive=ALWAYS,
    starts=_starts,
)
