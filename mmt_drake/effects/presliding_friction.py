"""Friction of bristles that bend before they slip (LuGre).

z is the bristles' mean deflection. z' = v - sigma0 abs(v)/g(v) z and F = -(sigma0 z + sigma1 z'), with
g(v) = Fc + (Fs - Fc) exp(-(v/v_s)^2), Fc being the structure's own, whose place it takes. For small motions it is a
spring sigma0, for steady sliding it is friction of level g(v). v_s has an effect only where Fs differs from Fc; unless
said it is what the paper has, 1 mm/s.

sigma0 z^2/2 is stored. Bristles wound up to one level that meet another are damped the wrong way, by sigma1 v^2 times
how much the greater level exceeds the lesser, as a part of this: passive where the structure's damper to the world
takes that (Barabanov and Ortega 2000, IEEE Trans. Automatic Control 45(4)).

Easily confused with:

- `ground_spring`: alike in strokes so small that the bristles never slip; longer strokes tell them apart.
- `hysteresis`: both draw a loop whatever the speed, one over the body's way on the table and one over the deflection of
  the contact; the probe held in contact while the body creeps, or lifted off, tells them apart.
"""

from math import exp, inf

from numba import njit

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Values
from mmt_drake.effects.passivity import Passive
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law, norm
from mmt_drake.model.structure import Structure

FASTEST = 3e3
"""Bristles that would settle faster than this [1/s], which no recording shows, settle so fast."""


@njit(error_model="numpy")
def bristles(z: float, v: float, speed: float, sigma: float, level: float) -> tuple[float, float]:
    """The rate of the mean deflection z [m] of bristles of stiffness sigma [N/m], and how fast they settle [1/s].

    Args:
        z: now.
        v, speed: velocity of the body along the axis, and its size in the plane [m/s].
        sigma: 0 or more.
        level: of friction [N] in steady sliding at this velocity.
    """
    if sigma * speed < FASTEST * level:
        slip = sigma * speed / level
        return v - slip * z, slip
    settled = level * v / (speed * sigma) if sigma > 0.0 else 0.0
    return FASTEST * (settled - z), FASTEST


def _stored(at: At, q: Own, p: Numbers) -> Result:
    return 0.5 * p[0] * q[0] ** 2, 0.0, 0.0, 0.0


@law(Slot.BODY, remembers=True, in_plane=True, stored=_stored)
def _lugre(at: At, q: Own, p: Numbers) -> Result:
    sigma0, sigma1, Fs, v_s, Fc = p[0], p[1], p[2], p[3], p[4]
    if Fs == 0.0 and Fc == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    speed = norm(at.v, at.v_across)
    g = Fc + (Fs - Fc) * exp(-((speed / v_s) ** 2))
    z_rate, slip = bristles(q[0], at.v, speed, sigma0, g)
    return -(sigma0 * q[0] + sigma1 * z_rate), z_rate, 0.0, slip


def _damped_enough(model: Structure, values: Values) -> bool:
    low, high = sorted((values["Fs"], model.value("Fc")))
    return bool(values["sigma1"] * (high - low) <= model.value("b") * low)


EFFECT = Effect(
    name="presliding_friction",
    block="friction",
    family="dry_friction",
    parameters=(
        Parameter("sigma0", "N/m", NOT_NEGATIVE),
        Parameter("sigma1", "N s/m", NOT_NEGATIVE, default=0.0),
        Parameter("Fs", "N", NOT_NEGATIVE, default="Fc"),
        Parameter("v_s", "m/s", (1e-6, inf), vanishes_at=1e-3, default=1e-3),
    ),
    equation="sigma0 z + sigma1 z', z' = v - sigma0 |v|/g(v) z, g(v) = Fc + (Fs - Fc) exp(-(v/v_s)^2), for Fc sgn v",
    source="Canudas de Wit, Olsson, Astrom and Lischinsky 1995, IEEE Trans. Automatic Control 40(3)",
    law=_lugre,
    uses=("Fc",),
    inertial=True,
    passive=Passive("sigma1 |Fs - Fc| <= b min(Fs, Fc)", _damped_enough),
    replaces="Fc",
    holds=("coulomb_friction", "stribeck_friction"),  # bristles that hardly bend
    stiffness=lambda values: values["sigma0"],
    damping=lambda values: values["sigma1"],
    starts=lambda scales: [{"sigma0": level * scales.stiffness} for level in (1.0, 5.0, 25.0)],
)
