"""The experiment on a force that is measured late."""

import numpy as np
from scipy.signal import TransferFunction, lsim

from mmt_drake.diagrams.proof.experiments.late import CASES, LATENESS, SECONDS, STEP, LateCase, late_table, run_case
from mmt_drake.diagrams.proof.experiments.tick_by_tick import behind_sensor


def test_an_object_of_foreign_physics_is_rendered_and_its_force_s_lateness_found() -> None:
    case = run_case(2, "strokes", "foreign", (0.01, 0.004), 0)
    assert case.off < 5e-4 and case.error < 0.03


def test_a_force_is_made_late_by_a_low_pass_and_a_delay() -> None:
    time = np.arange(500) * STEP
    force = np.sin(20.0 * time)[:, np.newaxis] * np.ones(3)
    _, passed, _ = lsim(TransferFunction([1.0], [0.008, 1.0]), force[:, 0], time)
    made = behind_sensor(time, force, 0.004, 0.008)
    np.testing.assert_allclose(made[4:, 1], passed[:-4], atol=1e-9)
    assert not made[:4].any()


def test_the_worst_of_each_motion_counts() -> None:
    cases = tuple(
        LateCase(0, motion, plant, *lateness, [0.0, 0.0, sum(lateness) + off, 0.0, 0.0, 0.0], 10.0 * off)
        for motion in SECONDS
        for plant, off in (("own", 1e-4), ("foreign", 1e-3))
        for lateness in LATENESS
    )
    by, error = CASES.report(cases).reached[:2]
    assert by.value is not None and abs(by.value - 1e-3) < 1e-9 and not by.reached
    assert error.value == 0.01 and error.reached
    assert len(late_table(cases).rows) == len(SECONDS) * len(LATENESS)
