"""A contact spring that hardens or softens with its deflection (Duffing).

k3 d^3 beside the contact spring, in the plane k3 abs(d)^2 d; a negative k3 softens the spring that is there. Stored is
k3 abs(d)^4/4: one that softens gives back more than it was given, and is not passive.

Easily confused with:

- `contact_gap`: both are soft at small deflections; small strokes tell them apart: in a clearance there is no force at
  all.
- `force_saturation`: both flatten the peaks; peaks of one force reached slowly and fast tell them apart: a sensor clips
  at a force, whatever the deflection.
- `hunt_crossley_damping`: both grow with the deflection; deep strokes, slow and fast, tell them apart: slowly, only the
  spring is felt.
"""

from math import sqrt

from mmt_drake.effects.effect import Effect, Parameter, Scales, Values
from mmt_drake.effects.passivity import Passive
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import OSCILLATION, At, Numbers, Own, Result, Slot, law
from mmt_drake.model.structure import Structure


def _stored(at: At, q: Own, p: Numbers) -> Result:
    return 0.25 * p[0] * at.d**2 * (at.d**2 + at.d_across**2), 0.0, 0.0, 0.0


@law(Slot.CONTACT, in_plane=True, stored=_stored)
def _cubic(at: At, q: Own, p: Numbers) -> Result:
    k3, m = p[0], p[1]
    square = at.d**2 + at.d_across**2
    rate = sqrt(3.0 * abs(k3) / m * square) if m > 0.0 else 0.0
    return k3 * at.d * square, 0.0, 0.0, OSCILLATION * rate


def _check(model: Structure, values: Values, source: str) -> None:
    if values["k3"] < 0.0 and model.value("k2") == 0.0:  # it would push away, the harder the further
        raise BadInput(
            source, at="k3", found=f"{values['k3']:g}", expected="0 or more, where there is no spring to soften"
        )


def _starts(scales: Scales) -> list[Values]:
    k3 = scales.stiffness / scales.deflection**2
    return [{"k3": 0.1 * k3}, {"k3": -0.05 * k3}]


EFFECT = Effect(
    name="nonlinear_stiffness",
    block="contact",
    family="contact_stiffness",
    parameters=(Parameter("k3", "N/m^3"),),
    equation="k3 d^3 beside the contact spring (negative softens)",
    source="Duffing 1918, Erzwungene Schwingungen bei veränderlicher Eigenfrequenz",
    law=_cubic,
    check=_check,
    elsewhere={"transmission": ("drive_stiffness", "drive")},  # of a drive train that stiffens as it is wound up
    uses=("m",),
    passive=Passive("k3 >= 0", lambda model, values: bool(values["k3"] >= 0.0)),
    starts=_starts,
)
