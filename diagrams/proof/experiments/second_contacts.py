"""Contacts of experiment 2: a simulated arm that slides an object over a table, and recordings of a real one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

from mmt_drake.analysis.signals import on_even_clock
from mmt_drake.diagrams.proof.trial.real.preparation import beginning
from mmt_drake.diagrams.stations.arm import missing_arm
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.run import run
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.effects import LIBRARY
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.recording import AXES, Recording, load
from mmt_drake.recording.check import completed
from mmt_drake.recording.public import public_recordings

_ARM: Final = "telerobot=!Panda {compensation: {mass: 0.15, weight: [0.0, 0.0, -1.32]}}"
"""In the place of what such an arm is at its tip; of its probe as much is known."""
_SETUP: Final = load_scenario("setup3", [_ARM, "estimator=!RlsOptions {}", "clouds=none"])
OBJECT: Final = _SETUP.environment.object
"""The thesis's test object with a soft top, on the table under its own weight."""
_MU: Final = 0.3  # of it on the table
_VECTORS: Final = ("position", "velocity", "force", "master_position", "master_velocity", "true_force")
_KEPT: Final = (*(f"{name}_{axis}" for name in _VECTORS for axis in AXES), "detected_contact", "in_contact")
"""Columns of a recording: what an estimator of the station has made of them is not among them."""


@dataclass(frozen=True)
class Contact:
    """One contact to estimate from.

    Attributes:
        name: of it, in names of files.
        title: what it is.
        truth: parameters of the object that are known, by their symbols.
        take: makes or reads it; None where it cannot be had.
        missing: why not.
    """

    name: str
    title: str
    truth: Mapping[str, float]
    take: Callable[[float | None, int], Recording] | None
    missing: str | None = None


def known_contacts() -> list[Contact]:
    """The arm on an object with even friction and with friction that grows with the load; then recordings."""
    reason = missing_arm()
    load_dependent = LIBRARY["load_dependent_friction"].apply(OBJECT, {"mu": _MU})
    truth = {name: OBJECT.parameter(name) for name in ("m", "k1", "k2", "b1", "b2", "Fc")}
    found = [
        Contact(name, title, truth, None if reason else partial(slide, model), reason)
        for name, title, model in (
            ("arm", "simulated Panda, 459 g, friction of its weight", OBJECT),
            ("arm_load", "simulated Panda, 459 g, friction of its weight and of the press", load_dependent),
        )
    ]
    folder = public_recordings() / "dvrk_palpation"
    files = [file for file in sorted(folder.glob("*.npz")) if not file.stem.startswith("probing")]
    if not files:
        found.append(Contact("palpation", "recorded palpation", {}, None, f"no recordings in {folder}"))
    return found + [_recorded(file) for file in files]


def _recorded(file: Path) -> Contact:
    def take(seconds: float | None, seed: int) -> Recording:
        recording = on_even_clock(load(file))
        return recording if seconds is None else beginning(recording, seconds)

    return Contact(f"palpation_{file.stem}", f"recorded palpation, {file.stem}", {}, take)


def slide(model: FlexibleBoxModel, seconds: float | None, seed: int) -> Recording:
    """Set-up 3 with a whole arm: it slides an object over a table; its wrist's force, cleared of the probe.

    Args:
        model: the object.
        seconds: how long; 60 s by default.
        seed: of the noise.

    Raises:
        MissingDependency: the arm's model is not installed.
    """
    length = seconds or 60.0
    hand = Scripted("strokes", {"duration": max(length, 12.0)})
    world = replace(_SETUP.single, object=model)
    recording = run(replace(_SETUP, seed=seed, duration=length, operator=hand, environment=world))
    return completed(recording.time, {name: recording[name] for name in _KEPT}, "simulated arm")
