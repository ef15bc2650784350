"""Recordings by the trial's own engine and the models handed in with them, for tests of `diagnose`."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.motions import ProbeMotion
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession, MaterialSession
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.recording import Recording

BASE = {"m": 0.5, "k1": 0.0, "k2": 450.0, "b1": 20.0, "b2": 25.0, "Fc": 0.0, "normal_k": 400.0, "normal_b": 8.0}
MODEL = """\
structure: flexible_box
parameters: {m: 0.5, k1: 0.0, k2: 450.0, b1: 20.0, b2: 25.0, Fc: 0.0}
normal: {k: 400.0, b: 8.0}
"""
SPRING = {"k": 500.0, "b": 20.0, "x0": 0.01, "F0": 0.0}
SPRING_MODEL = "structure: kelvin_voigt\nparameters: {k: 450.0, b: 22.0, x0: 0.01}\n"
CARRIAGE = {"m": 2.0, "b": 10.0, "k": 80.0, "Fc": 0.5, "offset": 0.0, "gravity": 0.0, "pendulum": 0.0}
CARRIAGE_MODEL = "structure: driven_body\nparameters: {m: 1.8, b: 11.0, k: 80.0, Fc: 0.5}\n"

Effect = tuple[str, tuple[tuple[str, float], ...]]
COULOMB: Effect = ("coulomb_friction", (("Fc", 0.4),))


@dataclass(frozen=True)
class OneWay(ContactSession):
    """A hand that never turns round: it slides along y at a speed that varies."""

    @property
    def motion(self) -> ProbeMotion:
        usual = super().motion
        t = usual.time
        position, velocity = usual.position.copy(), usual.velocity.copy()
        position[:, :2] = np.column_stack([np.full_like(t, 0.1), 0.02 * t + 0.004 * np.sin(3.0 * t)])
        velocity[:, :2] = np.column_stack([np.zeros_like(t), 0.02 + 0.012 * np.cos(3.0 * t)])
        return replace(usual, position=position, velocity=velocity, moves_x=False)


@cache
def contact(*effects: Effect, seed: int = 0, seconds: float = 12.0, one_way: bool = False) -> Recording:
    """A hand's strokes on the object of BASE with these effects concealed."""
    session = (OneWay if one_way else ContactSession)(seed=seed, noise=0.015, duration=seconds)
    return session.record(BASE, tuple(Concealed(name, dict(values)) for name, values in effects))


@cache
def material(*effects: Effect, seed: int = 1, seconds: float = 10.0) -> Recording:
    """A probe that moves the spring and damper of SPRING about."""
    concealed = tuple(Concealed(name, dict(values)) for name, values in effects)
    return first(MaterialSession(seed).record(SPRING, concealed), seconds)


@cache
def carriage(seed: int = 1, seconds: float = 15.0) -> Recording:
    """The driven body of CARRIAGE on the way that a hand gives it."""
    return first(DrivenSession(seed, noise=2e-5).record(CARRIAGE, ()), seconds)


def changed(recording: Recording, **columns: np.ndarray) -> Recording:
    """The same with other columns."""
    return replace(recording, columns={**recording.columns, **columns})


def kept(recording: Recording, keep: np.ndarray) -> Recording:
    """Some samples of it."""
    columns = {name: values[keep] for name, values in recording.columns.items()}
    return replace(recording, time=recording.time[keep], columns=columns)


def first(recording: Recording, seconds: float) -> Recording:
    """Its beginning."""
    return kept(recording, recording.time < recording.time[0] + seconds)


def scaled(recording: Recording, factor: float, *quantities: str) -> Recording:
    """All columns of these quantities (force, position, velocity, input ...) times a factor."""
    names = [name for name in recording.columns if name.partition("_")[0] in quantities]
    return changed(recording, **{name: factor * recording[name] for name in names})


def later(recording: Recording, seconds: float, quantity: str) -> Recording:
    """One quantity on a clock that is so much behind that of the rest."""
    names = [name for name in recording.columns if name.partition("_")[0] == quantity]
    t = recording.time
    return changed(recording, **{name: np.interp(t - seconds, t, recording[name]) for name in names})
