"""The trial's cases on the flexible object: what is concealed, in what, and the model that is handed in."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, Literal, Protocol

import numpy as np

from mmt_drake.diagrams.proof.trial.laws import IN_TWO_DIRECTIONS, INSIDE, LAWS, OUTSIDE, Concealed, linear_object
from mmt_drake.diagrams.proof.trial.plants import OWN, Plant
from mmt_drake.diagrams.proof.trial.session import ContactSession, draw_session, normal_force
from mmt_drake.diagrams.proof.trial.sizes import SIZES, Baseline
from mmt_drake.effects import LIBRARY
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording

Kind = Literal["none", "parameters", "single", "pair", "triple", "outside"]
Nominal = dict[str, Any]

_ON_FC = ("stribeck_friction", "presliding_friction", "static_friction", "asymmetric_friction")
_ON_B1 = ("asymmetric_viscous_friction", "frictional_heating")
_ABSENT = {"viscous_friction": "b1", "ground_spring": "k1", "coulomb_friction": "Fc"}  # 0 in the nominal model

#: Effects of which no case holds two: they take the same place, or are too much alike to be told apart.
_EXCLUSIVE: Final = (
    ("viscous_friction", "asymmetric_viscous_friction"),
    ("coulomb_friction", "constant_force", *_ON_FC),
    ("constant_force", "force_bias", "asymmetric_friction"),
    ("force_lag", "time_delay"),
    ("force_drift", "stiffness_drift"),
)
PLAIN = 10.0
"""Visibility from which on an effect is plain."""


class CaseMaker(Protocol):
    """Makes recordings of an object with something concealed in it."""

    @property
    def noise(self) -> float:
        """Standard deviation of the output's noise."""

    def true_reading(self, base: Mapping[str, float], effects: tuple[Concealed, ...]) -> Array:
        """The output without noise, where it counts."""

    def record(self, base: Mapping[str, float], effects: tuple[Concealed, ...]) -> Recording:
        """The recording."""


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes:
        name: of its folder; where it is sealed it says nothing of what is concealed.
        kind: what sort of case.
        effects: what is concealed; empty for `none` and `parameters`.
        base: true parameters without the effects, by symbol.
        nominal: the model file that is handed in.
        session: makes the recording.
        size: 0 (barely visible) to 1 (plain); None without effects.
        visibility: RMS of what the effects change in the true output, over its noise.
        remainder: what is in the recording beside the effects, and has no name in the library.
        not_false: names that a remainder does deserve in part: no false ones.
    """

    name: str
    kind: Kind
    effects: tuple[Concealed, ...]
    base: Mapping[str, float]
    nominal: Nominal
    session: CaseMaker
    size: float | None = None
    visibility: float = 0.0
    remainder: tuple[Concealed, ...] = ()
    not_false: tuple[str, ...] = ()

    def truth(self) -> dict[str, Any]:
        """What is concealed, as plain numbers and strings."""
        return {
            "case": self.name,
            "structure": self.nominal["structure"],
            "kind": self.kind,
            "truth": [effect.name for effect in self.effects],
            "blocks": [self._block(effect) for effect in self.effects],
            "families": [LAWS[effect.name].family for effect in self.effects if LAWS[effect.name].family],
            "parameters": [dict(effect.parameters) for effect in self.effects],
            "base": dict(self.base),
            "nominal_is_exact": all(
                value in (0.0, self.base.get(name)) for name, value in self.nominal["parameters"].items()
            ),
            "size": self.size,
            "visibility": float(f"{self.visibility:.3g}"),
            "noise": self.session.noise,
            "motion": "rich",  # as all are
            "remainder": [law.name for law in self.remainder],
            "not_false": list(self.not_false),
        }

    def _block(self, effect: Concealed) -> str:
        """Where an effect acts: on a flexible box as the trial's laws say, elsewhere as the library does."""
        structure = self.nominal["structure"]
        on_a_box = structure == "flexible_box" or effect.name not in LIBRARY
        return effect.block if on_a_box else LIBRARY[effect.name].place_in(structure)[1]

    def recording(self) -> Recording:
        """What the session gives."""
        return self.session.record(self.base, (*self.effects, *self.remainder))


def draw_single(rng: np.random.Generator, name: str, effect: str, size: float, plant: Plant = OWN) -> Case:
    """A case with one effect, in an object that it does not make unstable.

    Args:
        rng: for all that is left open.
        name: of the case.
        effect: in `LAWS`.
        size: 0 (barely visible) to 1 (plain).
        plant: what simulates the object.
    """
    while True:
        base, session = draw_base(rng, (effect,)), draw_session(rng, plant)
        if effect in IN_TWO_DIRECTIONS:
            session = replace(session, plant=replace(plant, moves_x=1.0))
        effects = _conceal(rng, (effect,), base, session, size)
        visible = visibility(base, effects, session)
        if math.isfinite(visible):  # a spring that softens may give way altogether
            kind: Kind = "outside" if effect in OUTSIDE else "single"
            return Case(name, kind, effects, base, nominal_model(rng, base, effects), session, four(size), visible)


def draw_several(rng: np.random.Generator, name: str, count: int, plant: Plant = OWN) -> Case:
    """A case with two or three plain effects, of different blocks mostly; none stands in another's place.

    Args:
        rng: for all that is left open.
        name: of the case.
        count: 2 or 3.
        plant: what simulates the object.
    """
    kind: Kind = "pair" if count == 2 else "triple"
    inside = [effect for effect in INSIDE if effect in plant.effects and effect not in IN_TWO_DIRECTIONS]
    while True:
        some = tuple(str(effect) for effect in rng.choice(inside, count, replace=False))
        if any(len(set(some) & set(names)) > 1 for names in _EXCLUSIVE):
            continue
        if len({LAWS[effect].block for effect in some}) < count and rng.random() < 0.8:
            continue
        base, session, size = draw_base(rng, some), draw_session(rng, plant), float(rng.uniform(0.6, 1.0))
        effects = tuple(_plain(rng, effect, base, session, size) for effect in some)
        visible = visibility(base, effects, session)
        if math.isfinite(visible) and all(visibility(base, (effect,), session) > PLAIN for effect in effects):
            return Case(name, kind, effects, base, nominal_model(rng, base, effects), session, four(size), visible)


def _plain(
    rng: np.random.Generator, name: str, base: Mapping[str, float], session: ContactSession, size: float
) -> Concealed:
    """An effect of this size, or of full size where that is not plain."""
    (effect,) = _conceal(rng, (name,), base, session, size)
    if visibility(base, (effect,), session) < PLAIN:
        (effect,) = _conceal(rng, (name,), base, session, 1.0)
    return effect


def draw_plain(rng: np.random.Generator, name: str, *, wrong: bool, plant: Plant = OWN) -> Case:
    """A case with nothing concealed, its parameters exact or `wrong`."""
    base, session = draw_base(rng, ()), draw_session(rng, plant)
    kind: Kind = "parameters" if wrong else "none"
    return Case(name, kind, (), base, nominal_model(rng, base, (), wrong=wrong), session)


def draw_base(rng: np.random.Generator, effects: tuple[str, ...]) -> dict[str, float]:
    """True parameters of an object that these effects can be concealed in; four digits each."""
    needs_Fc = any(effect in _ON_FC for effect in effects)
    base = {
        "m": rng.uniform(0.3, 1.2),
        "k1": rng.uniform(20.0, 200.0) if rng.random() < 0.3 else 0.0,
        "k2": rng.uniform(300.0, 900.0),
        "b1": rng.uniform(12.0, 50.0),
        "b2": rng.uniform(12.0, 50.0),
        "Fc": rng.uniform(0.15, 0.8) if rng.random() < 0.5 or needs_Fc else 0.0,
        "normal_k": rng.uniform(300.0, 600.0),
        "normal_b": rng.uniform(4.0, 12.0),
    }
    for effect in set(effects) & set(_ABSENT):
        base[_ABSENT[effect]] = 0.0
    if base["b1"] == 0.0:
        # The body must not ring for seconds, neither in contact nor, on a spring of its own, off contact.
        base["b2"], base["k1"] = max(base["b2"], 30.0), 0.0
        base["b1"] = 20.0 if any(effect in _ON_B1 for effect in effects) else 0.0
    return {name: four(value) for name, value in base.items()}


def nominal_model(
    rng: np.random.Generator, base: Mapping[str, float], effects: tuple[Concealed, ...], *, wrong: bool | None = None
) -> Nominal:
    """The model file that is handed in: the true structure without the effects.

    Args:
        rng: draws by how much parameters are wrong, up to 20 %.
        base: the true parameters.
        effects: what is left out. Where one replaces Fc, the model sometimes knows of no friction at all.
        wrong: whether parameters are off; by default in every other case.
    """
    given = dict(base)
    if rng.random() < 0.5 if wrong is None else wrong:
        given = {name: value * (1.0 + rng.uniform(-0.2, 0.2)) for name, value in given.items()}
    if any(effect.name in ("static_friction", "asymmetric_friction") for effect in effects) and rng.random() < 0.3:
        given["Fc"] = 0.0
    given = {name: four(value) for name, value in given.items()}
    normal = {"k": given.pop("normal_k"), "b": given.pop("normal_b")}
    return {"structure": "flexible_box", "parameters": given, "normal": normal}


def visibility(base: Mapping[str, float], effects: tuple[Concealed, ...], session: CaseMaker) -> float:
    """RMS of what effects change in the true output, over its noise; not finite where they make it run away."""
    change = session.true_reading(base, effects) - session.true_reading(base, ())
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(np.mean(change**2)) / session.noise)


def _conceal(
    rng: np.random.Generator, names: tuple[str, ...], base: Mapping[str, float], session: ContactSession, size: float
) -> tuple[Concealed, ...]:
    """Effects of this size; four digits each."""
    motion = session.motion
    force, body = session.without_effects(base)
    load = np.maximum(normal_force(linear_object(base), motion), 0.0)
    firm = load > 0.5 * np.median(load[motion.contact])
    scene = Baseline(rng, base, float(motion.time[-1]), force[firm], body[firm, 0], load[firm])
    numbers = {name: SIZES[name](scene, size).items() for name in names}
    without = session.plant.without
    return tuple(
        Concealed(name, {symbol: four(value) for symbol, value in values if symbol not in without})
        for name, values in numbers.items()
    )


def four(value: float) -> float:
    """Four digits: what a person would write into a file."""
    return float(f"{value:.4g}")
