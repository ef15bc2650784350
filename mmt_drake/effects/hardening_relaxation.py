"""A contact whose force relaxes while it is held, more of it the deeper it is pressed: soft tissue, rubber.

k3_maxwell (d^3 - q) with q' = (d^3 - q)/tau: what relaxes is a force that hardens with the deflection, as all of the
force of tissue does (quasi-linear viscoelasticity), and not, as in a Maxwell branch, one in proportion to it. A
deflection that is held gives k3_maxwell d^3 exp(-t/tau) more, a slow one nothing, a fast one a hardening spring more.
Never more comes out than was put in: k3_maxwell (d^4/4 - q d + 3/4 abs(q)^(4/3)) is stored. At each touch the branch is
relaxed. In the plane d^3 is abs(d)^2 d.

Easily confused with:

- `viscoelastic_relaxation`: alike in strokes of one depth; strokes and holds of several depths tell them apart: twice
  as deep, eight times as much relaxes here, and twice as much there.
- `force_drift`: in a single press that is held long, the force falls in both; a second press later on tells them
  apart.
"""

from math import sqrt

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Scales, Values
from mmt_drake.effects.passivity import ALWAYS
from mmt_drake.effects.viscoelastic_relaxation import TIME_CONSTANT, relaxes, time_constants
from mmt_drake.model.laws import OSCILLATION, At, Numbers, Own, Result, Slot, law, norm


def _stored(at: At, q: Own, p: Numbers) -> Result:
    square, size = at.d**2 + at.d_across**2, norm(q[0], q[2])
    relaxed = 0.75 * q[0] ** 2 * size ** (-2.0 / 3.0) if size > 0.0 else 0.0
    return p[0] * (0.25 * at.d**2 * square - q[0] * at.d + relaxed), 0.0, 0.0, 0.0


@law(Slot.CONTACT, remembers=True, in_plane=True, stored=_stored)
def _hardening_branch(at: At, q: Own, p: Numbers) -> Result:
    k3, relaxing, m = p[0], 1.0 / p[1], p[2]
    square = at.d**2 + at.d_across**2
    stretch = at.d * square - q[0]
    swinging = OSCILLATION * sqrt(3.0 * k3 / m * square) if m > 0.0 else 0.0
    return k3 * stretch, stretch * relaxing, 0.0, max(relaxing, swinging)


def _starts(scales: Scales) -> list[Values]:
    k3 = 0.3 * scales.stiffness / scales.deflection**2
    return [{"k3_maxwell": k3, "tau": tau} for tau in time_constants(scales)]


EFFECT = Effect(
    name="hardening_relaxation",
    block="contact",
    family="contact_loss",
    parameters=(Parameter("k3_maxwell", "N/m^3", NOT_NEGATIVE), TIME_CONSTANT),
    equation="k3_maxwell (d^3 - q), q' = (d^3 - q)/tau, beside the contact spring",
    source="Fung 1993, Biomechanics: Mechanical Properties of Living Tissues, section 7.6",
    law=_hardening_branch,
    uses=("m",),
    sought_beside=("k2",),
    passive=ALWAYS,
    engages=relaxes,
    holds=("nonlinear_stiffness",),  # where it hardly relaxes
    starts=_starts,
)
