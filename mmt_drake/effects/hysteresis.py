"""A contact whose force depends on the way that led there, however slowly (Bouc and Wen).

alpha z beside the contact spring, with z' = d' - beta abs(d') abs(z)^(n-1) z - gamma d' abs(z)^n. Near the last turn it
is a spring alpha; far from it z settles at (beta + gamma)^(-1/n). Unless said gamma = beta and n = 1. In the plane d
and z are vectors, z' = d' - (beta abs(u) + gamma u) abs(z)^(n-1) z, where u is the part of d' along z (Harvey and Gavin
2014, Earthquake Engineering and Structural Dynamics 43(13)).

alpha z^2/2 is stored, and alpha abs(z)^(n+1) abs(d') (beta + gamma sgn(d' z)) burnt, which is never negative where
abs(gamma) <= beta (Erlicher and Point 2004, C. R. Mecanique 332(1)).

Easily confused with:

- `coulomb_friction`: in a contact whose motion is prescribed the same loop, once strokes are much longer than 1/beta;
  strokes shorter than that tell them apart.
"""

from math import inf

from mmt_drake.effects.effect import NOT_NEGATIVE, Effect, Parameter, Ranges, Values, both_ways
from mmt_drake.effects.passivity import Passive
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import At, Numbers, Own, Result, Slot, law, norm
from mmt_drake.model.structure import Structure


def _stored(at: At, q: Own, p: Numbers) -> Result:
    return 0.5 * p[0] * q[0] ** 2, 0.0, 0.0, 0.0


@law(Slot.CONTACT, remembers=True, in_plane=True, stored=_stored)
def _bouc_wen(at: At, q: Own, p: Numbers) -> Result:
    alpha, beta, gamma, n = p[0], p[1], p[2], p[3]
    z, size = q[0], norm(q[0], q[2])
    along = (at.d_rate * z + at.d_rate_across * q[2]) / size if size > 0.0 else 0.0  # rate of d towards z
    power = size ** (n - 1.0)
    z_rate = at.d_rate - (beta * abs(along) + gamma * along) * power * z
    return alpha * z, z_rate, 0.0, n * (beta + abs(gamma)) * norm(at.d_rate, at.d_rate_across) * power


def _check(model: Structure, values: Values, source: str) -> None:
    if values["gamma"] < -values["beta"]:
        # Else z would grow without bound.
        expected = f"at least -beta = {-values['beta']:g} m^-n"
        raise BadInput(source, at="gamma", found=f"{values['gamma']:g}", expected=expected)


_LOOP = 0.05  # beta times the deflection, below which there is next to no loop
_turns = both_ways("sliding_velocity")  # the loop closes only where a motion turns


def _loops(values: Values, ranges: Ranges) -> bool:
    """True where there is a loop: with next to no beta it is a spring."""
    largest = max(map(abs, ranges["deflection"]))
    bent = max(values["beta"], abs(values.get("gamma", 0.0))) * largest ** values.get("n", 1.0)
    return _turns(values, ranges) and bent > _LOOP


EFFECT = Effect(
    name="hysteresis",
    block="contact",
    family="contact_loss",
    elsewhere={"driven_body": ("dry_friction", "friction")},  # of a bearing: bristles that yield
    parameters=(
        Parameter("alpha", "N/m", NOT_NEGATIVE),
        Parameter("beta", "m^-n", NOT_NEGATIVE, vanishes_at=1.0, shape=True),
        Parameter("gamma", "m^-n", vanishes_at=1.0, default="beta"),
        Parameter("n", "1", (1.0, inf), vanishes_at=1.0, default=1.0),
    ),
    equation="alpha z, z' = d' - beta |d'| |z|^(n-1) z - gamma d' |z|^n, beside the contact spring",
    source="Bouc 1967, Fourth Conf. on Nonlinear Oscillations; Wen 1976, J. Eng. Mech. Div. ASCE 102(2)",
    law=_bouc_wen,
    check=_check,
    stiffness=lambda values: values["alpha"],
    passive=Passive("|gamma| <= beta", lambda model, values: bool(abs(values["gamma"]) <= values["beta"])),
    engages=_loops,
    holds=("ground_spring",),  # of a driven body, without a loop
    starts=lambda scales: [{"alpha": 0.3 * scales.stiffness, "beta": part / scales.deflection} for part in (0.3, 2.0)],
)
