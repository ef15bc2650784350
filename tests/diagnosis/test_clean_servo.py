"""A servo that nothing holds and that lacks nothing: over short windows chance is as large as what is looked for."""

import numpy as np
import pytest

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagrams.proof.experiments.first_models import KINDS, drawn_recording
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.recording import Recording


def test_a_right_model_of_a_body_that_drifts_lacks_nothing():
    recording, true = drawn_recording(np.random.default_rng((0, 16, KINDS.index("servo"))), "servo")
    outcome = diagnose([recording], DrivenBodyModel(**true))
    assert outcome.prepared.window_s is not None
    assert (outcome.diagnosis.verdict, outcome.diagnosis.effects) == ("no_mismatch", ())


def test_a_right_model_of_a_cart_that_its_motor_pushes_from_the_first_sample_lacks_nothing():
    """By an integrator of its own: in steps of 10 us, friction a clip of the velocity, so that it sticks exactly."""
    m, b, Fc, fine = 2.0, 1.5, 0.9, 1e-5
    time = np.arange(0.0, 30.0, 5e-3)
    drive = 4.0 * np.sin(1.3 * time) + 3.0 * np.sin(3.1 * time + 0.4)
    every = round((time[1] - time[0]) / fine)
    forces = np.interp((np.arange(every * (len(time) - 1)) + 0.5) * fine, time, drive)
    positions, x, v = [0.0], 0.0, 0.0
    for force in forces.tolist():
        pushed, held = (v + fine / m * force) / (1.0 + fine * b / m), fine * Fc / m
        after = pushed - held if pushed > held else pushed + held if pushed < -held else 0.0
        x, v = x + 0.5 * fine * (v + after), after
        positions.append(x)
    output = np.array(positions[::every]) + np.random.default_rng(3).normal(0.0, 1e-4, len(time))
    recording = Recording(time, {"input": drive, "output": output}, "cart")
    found = diagnose([recording], DrivenBodyModel(m=m, b=b, Fc=Fc)).diagnosis
    assert (found.verdict, found.effects) == ("no_mismatch", ())
    without = diagnose([recording], DrivenBodyModel(m=m, b=b)).diagnosis
    assert [(e.name, e.certain) for e in without.effects] == [("coulomb_friction", "law")]
    assert without.effects[0].parameters["Fc"].value == pytest.approx(Fc, rel=2e-3)
