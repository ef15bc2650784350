"""Contacts of experiment 2: a simulated arm that slides an object over a table, and recordings of a real one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import DiscreteTimeDelay, VectorLogSink

from mmt_drake.analysis.signals import on_even_clock
from mmt_drake.cloud import ProxySettings, plane
from mmt_drake.diagrams.stations.arm import TABLE, Arm, missing_arm, simulated_arm
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.nets import Nets, shown_first
from mmt_drake.effects import LIBRARY
from mmt_drake.estimation.probe import ProbeOptions
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.recording import Recording, load
from mmt_drake.recording.check import completed
from mmt_drake.recording.public import public_recordings
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.probe_compensation import ProbeCompensation
from mmt_drake.systems.scripted_operator import ScriptedOperator

STEP: Final = 1e-3
_GRAVITY: Final = 9.81
_MASS: Final = 0.459
"""Of the thesis's test object [kg]."""
_MU: Final = 0.3  # of it on the table
_WEIGHT_TAKEN: Final = 0.9  # of the probe's true weight: what is wrong is left to the zero in free space

OBJECT: Final = FlexibleBoxModel(
    BoxParameters(m=_MASS, k1=0.0, k2=600.0, b1=2.0, b2=8.0, Fc=_MU * _MASS * _GRAVITY),
    NormalContact(k=800.0, b=10.0),
    Friction(Fs=1.1 * _MU * _MASS * _GRAVITY, Fd=_MU * _MASS * _GRAVITY, v_d=0.002),
)
"""The thesis's test object with a soft top, on the table under its own weight."""

_FLAGS: Final = ("detected_contact", "in_contact")
_LOGGED: Final = (
    *("position", "velocity", "force", "detected_contact"),
    *("master_position", "master_velocity", "true_force", "in_contact"),
)
"""Columns of a recording, in the order of `slide`'s signals."""


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
        if seconds is None:
            return recording
        kept = recording.time - recording.time[0] <= seconds
        columns = {name: values[kept] for name, values in recording.columns.items()}
        return replace(recording, time=recording.time[kept], columns=columns, clouds=())

    return Contact(f"palpation_{file.stem}", f"recorded palpation, {file.stem}", {}, take)


def slide(model: FlexibleBoxModel, seconds: float | None, seed: int) -> Recording:
    """An arm under impedance control slides an object over a table; its wrist's force, cleared of the probe.

    Args:
        model: the object.
        seconds: how long; 60 s by default.
        seed: of the noise.

    Raises:
        MissingDependency: the arm's model is not installed.
    """
    arm = Arm()
    arm = replace(arm, sensor=replace(arm.sensor, noise=replace(arm.sensor.noise, seed=seed)))
    length = seconds or 60.0
    motion = scripted_motion(Scripted().motion, duration=max(length, 12.0))
    hand = ScriptedOperator(motion)
    weight = TABLE.rotation().inverse() @ np.array([0.0, 0.0, -_WEIGHT_TAKEN * arm.probe_mass * _GRAVITY])
    probe = ProbeOptions(arm.probe_mass, (weight[0], weight[1], weight[2]), STEP)
    late = probe.ticks_late
    parts = {
        "operator": hand,
        "arm": simulated_arm(arm, shown_first(hand, "motion")[:3], STEP),
        "environment": FlexibleBox(model, period=STEP, surface=plane(30_000, (0.3, 0.3))),
        "detector": ContactDetector(ProxySettings(period=STEP)),
        "compensation": ProbeCompensation(probe),
        # It shows at a tick, before that tick's update, what came in one tick more ago than it is set.
        "beside": DiscreteTimeDelay(STEP, late - 1, 10),
        "log": VectorLogSink(20, STEP),
    }
    reads = {
        "arm.commanded": "operator.motion",
        "arm.force": "environment.force",
        "environment.motion": "arm.motion",
        "detector.position": "arm.motion[0:3]",
        "detector.point_cloud": "environment.point_cloud",
        "compensation.raw_measurement": "arm.raw_measurement",
        "compensation.in_contact": "detector.in_contact",
        "compensation.clearance": "detector.clearance",
        "beside.u": "operator.motion + environment.force + environment.in_contact",
        "log.data": "compensation.measurement + compensation.in_contact + beside.delayed_u",
    }
    builder = DiagramBuilder()
    for name, system in parts.items():
        builder.AddNamedSystem(name, system)
    Nets(parts).connect(builder, reads)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(length)
    logged = parts["log"].FindLog(simulator.get_context())
    rows = iter(logged.data()[:, late:])
    columns = {}
    for name in _LOGGED:
        for axis in ("",) if name in _FLAGS else ("_x", "_y", "_z"):
            columns[name + axis] = next(rows)
    return completed(logged.sample_times()[late:], columns, "simulated arm")
