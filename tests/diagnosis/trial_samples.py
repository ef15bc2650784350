"""Short recordings by the trial's own engine, which shares no code with the model; the model of its object."""

from functools import cache

from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.recording import Recording

BASE = {"m": 0.5, "k1": 0.0, "k2": 450.0, "b1": 20.0, "b2": 25.0, "Fc": 0.0, "normal_k": 400.0, "normal_b": 8.0}
FORCE_NOISE = 0.015


def model(**changed: float) -> FlexibleBoxModel:
    """The linear object, exact but for what is changed."""
    values = {**BASE, **changed}
    normal = NormalContact(values.pop("normal_k"), values.pop("normal_b"))
    return FlexibleBoxModel(BoxParameters(**values), normal, in_plane="per_axis")  # as the plant of the trial rubs


@cache
def recorded(*effects: tuple[str, tuple[tuple[str, float], ...]], seed: int = 0, seconds: float = 12.0) -> Recording:
    """A hand's strokes on the object with these effects concealed, each a name and its parameters."""
    session = ContactSession(seed=seed, noise=FORCE_NOISE, duration=seconds)
    return session.record(BASE, tuple(Concealed(name, dict(values)) for name, values in effects))
