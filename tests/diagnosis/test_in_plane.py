"""Concealed friction is found as it is, a vector in the plane or one for each axis, where the model does not say."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_samples import MODEL, Strokes

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.tell.written import augmented_model
from mmt_drake.effects import LIBRARY
from mmt_drake.recording.check import completed
from mmt_drake.simulation import simulate

TIME, LEVEL, NOISE = np.arange(6000) * 0.002, 0.4, 0.01
LIBRARY_HERE = [LIBRARY[name] for name in ("coulomb_friction", "nonlinear_stiffness", "force_bias")]


@pytest.mark.parametrize("friction", ["vector", "per_axis"])
def test_friction_is_delivered_as_what_it_is(friction):
    along, across, still = Strokes(1), Strokes(2), np.zeros_like(TIME)
    motion = {"position_x": along.y(TIME), "position_y": across.y(TIME), "position_z": still - 0.006}
    rate = {"velocity_x": along.y(TIME, 1), "velocity_y": across.y(TIME, 1), "velocity_z": still}
    truth = replace(MODEL, parameters=replace(MODEL.parameters, Fc=LEVEL), in_plane=friction)
    forces = simulate(truth, completed(TIME, {**motion, **rate}, "hand", forces=False))
    rng = np.random.default_rng(3)
    measured = {f"force_{axis}": forces[f"force_{axis}"] + rng.normal(0.0, NOISE, len(TIME)) for axis in "xyz"}
    recording = completed(TIME, {**motion, **rate, **measured}, "contact")
    outcome = diagnose([recording], replace(MODEL, in_plane=None), library=LIBRARY_HERE)
    (found,) = outcome.diagnosis.effects
    assert (outcome.diagnosis.verdict, found.name) == ("missing_physics", "coulomb_friction")
    assert found.parameters["Fc"].value == pytest.approx(LEVEL, rel=0.02)
    assert outcome.best is not None
    assert augmented_model(outcome.best)["friction"] == friction
