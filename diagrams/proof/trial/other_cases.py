"""The trial's cases on the other structures: a driven body, a transmission and a Kelvin-Voigt contact."""

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from mmt_drake.diagrams.proof.trial.cases import Case, CaseMaker, Kind, Nominal, four, visibility
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession, MaterialSession, TransmissionSession
from mmt_drake.diagrams.proof.trial.sizes import log

Values = dict[str, float]
_Draw = Callable[[np.random.Generator, Mapping[str, float], float], Values]

_OFFSETS = ("constant_force", "asymmetric_friction")


def draw_driven(rng: np.random.Generator, name: str, effect: str | None, size: float, *, wrong: bool) -> Case:
    """A case on a driven body: a carriage, or one in half of the plain cases a pendulum.

    Args:
        rng: for all that is left open.
        name: of the case.
        effect: one of `DRIVEN`, or None for none.
        size: 0 (barely visible) to 1 (plain).
        wrong: whether the nominal parameters are off by up to 20 %.
    """
    base = {
        "m": rng.uniform(0.5, 3.0),
        "b": 0.0 if effect == "viscous_friction" else rng.uniform(3.0, 20.0),
        "k": 0.0 if effect == "ground_spring" or rng.random() < 0.5 else rng.uniform(20.0, 200.0),
        "Fc": 0.0 if effect == "coulomb_friction" else rng.uniform(0.2, 2.0),
        # Beside an offset, friction that differs by direction is nothing but another offset.
        "offset": 0.0 if effect in _OFFSETS or rng.random() < 0.5 else rng.uniform(-0.5, 0.5),
        "gravity": 0.0,
        "pendulum": rng.uniform(2.0, 10.0) if effect is None and rng.random() < 0.5 else 0.0,
    }
    base = {symbol: four(value) for symbol, value in base.items()}
    given = off(rng, base) if wrong else base
    nominal: Nominal = {
        "structure": "driven_body",
        "parameters": {symbol: given[symbol] for symbol in ("m", "b", "k", "Fc", "offset")},
    }
    if base["pendulum"]:
        nominal["gravity"] = {"kind": "pendulum", "value": given["pendulum"]}
    session = DrivenSession(int(rng.integers(2**31)), noise=four(float(rng.uniform(1e-5, 5e-5))))
    return case_of(name, _drawn(rng, effect, base, size, DRIVEN), size, base, nominal, session, wrong=wrong)


def draw_material(rng: np.random.Generator, name: str, effect: str | None, size: float, *, wrong: bool) -> Case:
    """A case on a Kelvin-Voigt contact; arguments as `draw_driven`, effects of `MATERIAL`."""
    base = {"k": rng.uniform(200.0, 900.0), "b": rng.uniform(5.0, 40.0), "x0": rng.uniform(-0.05, 0.05), "F0": 0.0}
    base = {symbol: four(value) for symbol, value in base.items()}
    given = off(rng, base) if wrong else base
    parameters = {**{symbol: given[symbol] for symbol in ("k", "b")}, "x0": base["x0"]}
    nominal: Nominal = {"structure": "kelvin_voigt", "parameters": parameters}
    session = MaterialSession(int(rng.integers(2**31)), noise=four(float(rng.uniform(0.01, 0.03))))
    return case_of(name, _drawn(rng, effect, base, size, MATERIAL), size, base, nominal, session, wrong=wrong)


def draw_transmission(rng: np.random.Generator, name: str, effect: str | None, size: float, *, wrong: bool) -> Case:
    """A case on a transmission that resonates at 6 to 15 Hz; arguments as `draw_driven`, effects of `TRANSMISSION`."""
    k, rate = rng.uniform(100.0, 1000.0), 2.0 * math.pi * rng.uniform(6.0, 15.0)
    base = {
        "ratio": _either(rng) * rng.uniform(0.3, 2.0),
        "offset": rng.uniform(-0.05, 0.05),
        "k": k,
        "b": 2.0 * rng.uniform(0.05, 0.3) * k / rate,
        "m": k / rate**2,
        "c": 0.0 if effect == "viscous_friction" else rng.uniform(0.05, 0.3) * k / rate,
        "Fc": 0.0 if effect == "coulomb_friction" or rng.random() < 0.5 else rng.uniform(2e-4, 1e-3) * k,
    }
    base = {symbol: four(value) for symbol, value in base.items()}
    given = {**off(rng, base), "k": base["k"]} if wrong else base
    nominal: Nominal = {"structure": "transmission", "parameters": dict(given)}
    session = TransmissionSession(int(rng.integers(2**31)), noise=four(float(rng.uniform(1e-5, 5e-5))))
    return case_of(name, _drawn(rng, effect, base, size, TRANSMISSION), size, base, nominal, session, wrong=wrong)


def off(rng: np.random.Generator, base: Mapping[str, float]) -> Values:
    """Parameters that are wrong by up to 20 %."""
    return {symbol: four(value * (1.0 + rng.uniform(-0.2, 0.2))) for symbol, value in base.items()}


def _drawn(
    rng: np.random.Generator, effect: str | None, base: Mapping[str, float], size: float, sizes: Mapping[str, _Draw]
) -> dict[str, Values]:
    """The effect and its parameters, if there is one."""
    return {} if effect is None else {effect: sizes[effect](rng, base, size)}


def case_of(
    name: str,
    concealed: Mapping[str, Values],
    size: float,
    base: Values,
    nominal: Nominal,
    session: CaseMaker,
    *,
    wrong: bool,
) -> Case:
    """A case with these effects of this size, or, without any, with nominal parameters that are `wrong` or exact."""
    if not concealed:
        kind: Kind = "parameters" if wrong else "none"
        return Case(name, kind, (), base, nominal, session)
    effects = tuple(Concealed(effect, {s: four(v) for s, v in values.items()}) for effect, values in concealed.items())
    kind = "single" if len(effects) == 1 else "pair"
    return Case(name, kind, effects, base, nominal, session, four(size), visibility(base, effects, session))


def _either(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _asymmetric(rng: np.random.Generator, mean: float, size: float, plus: str, minus: str) -> Values:
    part = _either(rng) * log(0.05, 0.7, size)
    return {plus: mean * (1.0 + part), minus: mean * (1.0 - part)}


def _end_stop(rng: np.random.Generator, base: Mapping[str, float], size: float) -> Values:
    side = _either(rng)
    return {"position": side * (0.03 - log(0.002, 0.02, size)), "stiffness": rng.uniform(200.0, 2000.0), "side": side}


DRIVEN: Final[dict[str, _Draw]] = {
    "viscous_friction": lambda rng, base, size: {"b": log(0.5, 20.0, size)},
    "asymmetric_viscous_friction": lambda rng, base, size: _asymmetric(rng, base["b"], size, "b_plus", "b_minus"),
    "coulomb_friction": lambda rng, base, size: {"Fc": log(0.05, 2.0, size)},
    "asymmetric_friction": lambda rng, base, size: _asymmetric(rng, base["Fc"], size, "Fc_plus", "Fc_minus"),
    "stribeck_friction": lambda rng, base, size: {
        "Fs": base["Fc"] * (1.0 + log(0.15, 2.5, size)),
        "v_s": rng.uniform(0.01, 0.05),
    },
    "quadratic_drag": lambda rng, base, size: {"c": log(2.0, 150.0, size)},
    "nonlinear_stiffness": lambda rng, base, size: {"k3": log(1e3, 2e5, size)},
    "constant_force": lambda rng, base, size: {"F": _either(rng) * log(0.02, 1.0, size)},
    "ground_spring": lambda rng, base, size: {"k": log(1.0, 150.0, size)},
    "mass_change": lambda rng, base, size: {"time": rng.uniform(9.0, 21.0), "dm": log(0.05, 1.5, size) * base["m"]},
    "end_stop": _end_stop,
    "input_lag": lambda rng, base, size: {"tau": log(1e-3, 0.05, size)},
}
"""Effects that a driven body can have concealed -> their parameters at a size from 0 (barely visible) to 1 (plain)."""

TRANSMISSION: Final[dict[str, _Draw]] = {
    "viscous_friction": lambda rng, base, size: {"b": log(0.02, 0.5, size) * math.sqrt(base["k"] * base["m"])},
    "coulomb_friction": lambda rng, base, size: {"Fc": log(1e-4, 3e-3, size) * base["k"]},
    "gear_play": lambda rng, base, size: {"gap": log(2e-4, 6e-3, size)},
    "nonlinear_stiffness": lambda rng, base, size: {
        "k3": log(0.03, 2.0, size) * base["k"] / (2e-3 * base["ratio"]) ** 2
    },
}
"""The same of a transmission."""

MATERIAL: Final[dict[str, _Draw]] = {
    "nonlinear_stiffness": lambda rng, base, size: {"k3": log(0.03, 2.0, size) * base["k"] / 0.02**2},
    "hunt_crossley_damping": lambda rng, base, size: {"lambda": log(5.0, 300.0, size)},
    "viscoelastic_relaxation": lambda rng, base, size: {
        "k_maxwell": log(0.03, 1.0, size) * base["k"],
        "tau": rng.uniform(0.05, 0.5),
    },
    "hardening_relaxation": lambda rng, base, size: {
        "k3_maxwell": log(0.03, 2.0, size) * base["k"] / 0.02**2,
        "tau": rng.uniform(0.05, 0.5),
    },
    "hysteresis": lambda rng, base, size: {
        "alpha": log(0.05, 1.0, size) * base["k"],
        "beta": 0.5 / rng.uniform(0.0015, 0.005),
    },
    "stiffness_drift": lambda rng, base, size: {"rate": _either(rng) * log(0.001, 0.02, size)},
    "quadratic_drag": lambda rng, base, size: {"c": log(3.0, 300.0, size)},
    "coulomb_friction": lambda rng, base, size: {"Fc": log(0.02, 1.0, size)},
    "force_lag": lambda rng, base, size: {"tau": log(5e-4, 0.03, size)},
    "time_delay": lambda rng, base, size: {"delay": log(5e-4, 0.04, size)},
}
"""The same of a Kelvin-Voigt contact.

A bias is none of them: beside a rest position that is a parameter it is nothing but another rest position."""
