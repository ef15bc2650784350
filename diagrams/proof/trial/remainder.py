"""A concealed effect above a remainder that nobody has named: what real recordings are like."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mmt_drake.diagrams.proof.trial.cases import PLAIN, Case, draw_single, four
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.plants import OWN, Plant
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.numeric.arrays import Array

Draw = Callable[[np.random.Generator, float], Mapping[str, float]]

_MOVED = 0.01
"""By this part a number of the object is moved to see what a refit can take on."""
_TURNS = 4
_DRAWS = 20
_FITTED = ("m", "k1", "k2", "b1", "b2", "Fc")


@dataclass(frozen=True)
class Beneath:
    """A law of the remainder.

    Attributes:
        strength: the symbol of its size.
        shape: its other parameters, given the RMS of the body's displacement [m].
        not_false: names of the library that are true of a part of it.
    """

    strength: str
    shape: Draw
    not_false: tuple[str, ...] = ()


REMAINDERS: Final[dict[str, Beneath]] = {
    # A spring, on the short way of one stroke, is what a long wave of it is; and each of its waves is a ripple.
    "texture": Beneath(
        "F", lambda rng, way: {"length": way * rng.uniform(0.4, 0.8)}, ("ground_spring", "torque_ripple")
    ),
    # Its mean is a level like any other.
    "wandering_friction": Beneath(
        "F", lambda rng, way: {"period": rng.uniform(6.0, 15.0)}, ("coulomb_friction", "load_dependent_friction")
    ),
    "flicker_noise": Beneath("amplitude", lambda rng, way: {"seed": float(rng.integers(2**31))}, ("force_bias",)),
    # Between b v and c v |v|: either takes on most of it.
    "power_drag": Beneath("c", lambda rng, way: {}, ("viscous_friction", "quadratic_drag")),
}


def draw_beneath(
    rng: np.random.Generator, name: str, effect: str, size: float, remainder: str, share: float, plant: Plant = OWN
) -> Case:
    """A case with one plain effect above a remainder; of full size where a smaller one is not plain.

    Args:
        rng: for all that is left open.
        name: of the case.
        effect: of the library.
        size: 0 (barely visible) to 1 (plain).
        remainder: in `REMAINDERS`.
        share: RMS of what a refit leaves of the remainder, over that of what it leaves of the effect.
        plant: what simulates the object.
    """
    case = draw_single(rng, name, effect, size, plant)
    for _ in range(_DRAWS):
        if case.visibility >= PLAIN:
            break
        case = draw_single(rng, name, effect, 1.0, plant)
    law, session = REMAINDERS[remainder], case.session
    assert isinstance(session, ContactSession)
    way = float(np.std(session.without_effects(case.base)[1][:, 0]))
    shape = {symbol: four(value) if symbol != "seed" else value for symbol, value in law.shape(rng, way).items()}
    fitted = _directions(case.base, session)
    above = session.true_reading(case.base, case.effects)
    wanted = share * _left(above - session.true_reading(case.base, ()), fitted)
    strength = 0.1 * float(np.std(above))
    for _ in range(_TURNS):  # nearly linear in it
        beneath = Concealed(remainder, {law.strength: strength, **shape})
        found = _left(session.true_reading(case.base, (*case.effects, beneath)) - above, fitted)
        if not math.isfinite(found) or found == 0.0:
            break
        strength *= min(max(wanted / found, 0.1), 10.0)
    beneath = Concealed(remainder, {law.strength: four(strength), **shape})
    return replace(case, remainder=(beneath,), not_false=law.not_false)


def _directions(base: Mapping[str, float], session: ContactSession) -> Array:
    """What the true output does as each number of the object that is not 0 moves (n, k), orthonormal."""
    plain = session.true_reading(base, ())
    moved = [{**base, name: base[name] * (1.0 + _MOVED)} for name in _FITTED if base[name] != 0.0]
    columns = np.column_stack([session.true_reading(other, ()) - plain for other in moved])
    return np.asarray(np.linalg.qr(columns)[0])


def _left(change: Array, fitted: Array) -> float:
    """RMS of what a refit of the object's numbers leaves of a change in the output, to first order."""
    rest = change - fitted @ (fitted.T @ change)
    return float(np.sqrt(np.mean(rest**2)))
