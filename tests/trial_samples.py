"""Short recordings by the trial's own engine, which shares no code with the model; its objects; ways to spoil them."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession, MaterialSession
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.effects import LIBRARY
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Structure
from mmt_drake.model_files import Model
from mmt_drake.numeric.least_squares import Minimum
from mmt_drake.recording import Recording

BASE = {"m": 0.5, "k1": 0.0, "k2": 450.0, "b1": 20.0, "b2": 25.0, "Fc": 0.0, "normal_k": 400.0, "normal_b": 8.0}
SPRING = {"k": 500.0, "b": 20.0, "x0": 0.01, "F0": 0.0}
CARRIAGE = {"m": 2.0, "b": 10.0, "k": 80.0, "Fc": 0.5, "offset": 0.0, "gravity": 0.0, "pendulum": 0.0}
FORCE_NOISE = 0.015
BOX_MODEL = """\
structure: flexible_box
parameters: {m: 0.5, k1: 0.0, k2: 450.0, b1: 20.0, b2: 25.0, Fc: 0.0}
normal: {k: 400.0, b: 8.0}
"""
SPRING_MODEL = "structure: kelvin_voigt\nparameters: {k: 450.0, b: 22.0, x0: 0.01}\n"
CARRIAGE_MODEL = "structure: driven_body\nparameters: {m: 1.8, b: 11.0, k: 80.0, Fc: 0.5}\n"

Effect = tuple[str, tuple[tuple[str, float], ...]]
COULOMB: Effect = ("coulomb_friction", (("Fc", 0.4),))


def model(**values: float) -> FlexibleBoxModel:
    """The linear object, exact but for these values."""
    values = {**BASE, **values}
    normal = NormalContact(values.pop("normal_k"), values.pop("normal_b"))
    return FlexibleBoxModel(BoxParameters(**values), normal, in_plane="per_axis")  # as the plant of the trial rubs


def beside(*names: str, nominal: Structure | None = None, skew: float = 0.0) -> Hypothesis:
    """That these effects are missing in a model; unless said the exact one."""
    hypothesis = Hypothesis(model() if nominal is None else nominal, skew)
    for name in names:
        hypothesis = hypothesis.adding(LIBRARY[name])
    return hypothesis


def named(*names: str) -> Fitted:
    """A fit with these effects, of which nothing but their names counts."""
    return Fitted(beside(*names), Minimum(np.zeros(0), np.zeros(0), np.zeros((0, 0)), True, 0))


def problem_of(recordings: Recording | list[Recording], believed: Model) -> Problem:
    """What a model is fitted to; the recordings are such as can be."""
    found = prepare(recordings if isinstance(recordings, list) else [recordings], believed)
    assert found.problem is not None, found.reason
    return found.problem


def _concealed(effects: tuple[Effect, ...]) -> tuple[Concealed, ...]:
    return tuple(Concealed(name, dict(values)) for name, values in effects)


@cache
def recorded(*effects: Effect, seed: int = 0, seconds: float = 12.0) -> Recording:
    """A hand's strokes on the object with these effects concealed, each a name and its parameters."""
    session = ContactSession(seed=seed, noise=FORCE_NOISE, duration=seconds)
    return session.record(BASE, _concealed(effects))


@cache
def spring(*effects: Effect, seed: int = 1, seconds: float = 10.0) -> Recording:
    """A probe that moves the spring and damper of SPRING about."""
    whole = MaterialSession(seed).record(SPRING, _concealed(effects))
    return cut(whole, whole.time < seconds)


@cache
def carriage(*effects: Effect, seed: int = 1, seconds: float = 15.0) -> Recording:
    """The driven body of CARRIAGE on the way that a hand gives it."""
    whole = DrivenSession(seed, noise=2e-5).record(CARRIAGE, _concealed(effects))
    return cut(whole, whole.time < seconds)


def changed(recording: Recording, **columns: np.ndarray) -> Recording:
    """The same with other columns."""
    return replace(recording, columns={**recording.columns, **columns})


def times(factor: float, *quantities: str) -> Callable[[Recording], Recording]:
    """With the columns of some quantities, as `force` of `force_x`, multiplied."""
    return lambda r: changed(r, **{n: factor * r[n] for n in r.columns if n.partition("_")[0] in quantities})


def late(seconds: float, *quantities: str) -> Callable[[Recording], Recording]:
    """With some quantities, or single columns, on a clock that is so much behind that of the rest."""

    def of(r: Recording) -> list[str]:
        return [name for name in r.columns if name in quantities or name.partition("_")[0] in quantities]

    return lambda r: changed(r, **{name: np.interp(r.time - seconds, r.time, r[name]) for name in of(r)})


def cut(recording: Recording, keep: np.ndarray | slice) -> Recording:
    """Some samples of it."""
    columns = {name: values[keep] for name, values in recording.columns.items()}
    return replace(recording, time=recording.time[keep], columns=columns)
