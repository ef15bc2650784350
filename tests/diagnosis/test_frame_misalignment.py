"""A force sensor that is mounted askew: the angles are found, and nothing else is blamed for it."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from trial_samples import BASE, model

from mmt_drake.diagnosis.checks.alignment import normal_fit
from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.signals.smoother import smooth
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.plants import OWN
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.effects import LIBRARY
from mmt_drake.recording import Recording

OTHERS = ("force_crosstalk", "constant_force", "force_bias", "coulomb_friction", "time_delay")
DEGREES = {"rx": 1.0, "ry": -0.6, "rz": 1.4}


@cache
def turned(both_ways: bool = True, **degrees: float) -> Recording:
    """A hand that slides along x and y, or along y alone, and a sensor that is turned; by the trial's own engine."""
    plant = replace(OWN, moves_x=1.0 if both_ways else 0.0)
    session = ContactSession(seed=4, noise=0.015, duration=15.0, still_x_alive=True, plant=plant)
    angles = {angle: math.radians(degrees.get(angle, 0.0)) for angle in DEGREES}
    return session.record(BASE, (Concealed("frame_misalignment", angles),))


@cache
def diagnosed(library: tuple[str, ...], both_ways: bool = True, **degrees: float) -> Outcome:
    return diagnose([turned(both_ways, **degrees)], model(), library=[LIBRARY[name] for name in library])


def in_degrees(found: Outcome) -> Mapping[str, tuple[float, tuple[float, float]]]:
    (effect,) = found.diagnosis.effects
    return {
        angle: (math.degrees(number.value), tuple(map(math.degrees, number.ci95)))
        for angle, number in effect.parameters.items()
    }


@pytest.mark.parametrize("times", [0.5, 2.5])
def test_all_three_angles_are_found_within_a_tenth_of_a_degree_and_their_intervals_cover(times: float) -> None:
    truth = {angle: times * degrees for angle, degrees in DEGREES.items()}
    found = diagnosed(("frame_misalignment", *OTHERS), **truth)
    assert found.diagnosis.verdict == "missing_physics"
    assert [(e.name, e.block, e.certain) for e in found.diagnosis.effects] == [
        ("frame_misalignment", "geometry", "law")
    ]
    for angle, (value, (low, high)) in in_degrees(found).items():
        assert value == pytest.approx(truth[angle], abs=0.1)
        assert low <= truth[angle] <= high and high - low < 0.4
    assert "degrees" in found.diagnosis.summary and "rad" not in found.diagnosis.summary.split("Keep in mind")[0]
    assert not found.diagnosis.parameters


def test_a_turned_sensor_is_not_taken_for_a_force_that_comes_before_its_cause() -> None:
    for degrees in (-3.0, 3.0):
        fit = normal_fit(smooth(turned(rx=degrees)))
        assert fit is not None and abs(fit.offset) < 2e-3
        assert not diagnosed((), rx=degrees).prepared.reason


def test_where_only_y_says_so_a_turn_and_crosstalk_are_ambiguous() -> None:
    """The probe slides along y alone, and what a turn takes from z is lost in a noise of its own."""
    recording = turned(both_ways=False, rx=1.0)
    noise = 0.4 * np.random.default_rng(1).standard_normal(len(recording))
    noisy = replace(recording, columns={**recording.columns, "force_z": recording["force_z"] + noise})
    library = [LIBRARY[name] for name in ("frame_misalignment", "force_crosstalk")]
    found = diagnose([noisy], model(), library=library).diagnosis
    named = {e.name for e in found.effects}
    others = {a.name for a in found.alternatives if a.indistinguishable}
    assert found.verdict == "ambiguous" and named | others == {"frame_misalignment", "force_crosstalk"}
    assert found.next_recording is not None


def test_where_z_says_so_too_a_turn_is_no_crosstalk_though_the_probe_slides_along_y_alone() -> None:
    found = diagnosed(("frame_misalignment", "force_crosstalk"), both_ways=False, rx=1.0)
    assert found.diagnosis.verdict == "missing_physics"
    angles = in_degrees(found)
    assert set(angles) == {"rx"}, "the others would show along x, which is not compared"
    value, (low, high) = angles["rx"]
    assert value == pytest.approx(1.0, abs=0.1) and low < 1.0 < high
    assert found.best.model.additions.turn[1:] == (0.0, 0.0)


def test_the_near_equal_is_published_with_its_condition() -> None:
    assert "one axis" in LIBRARY["frame_misalignment"].near_equal["force_crosstalk"]


def test_without_a_normal_axis_to_compare_no_turn_is_tried() -> None:
    recording = turned(rx=1.0)
    dead = replace(recording, columns={**recording.columns, "force_z": np.zeros(len(recording))})
    found = diagnose([dead], model(), library=[LIBRARY["frame_misalignment"]]).diagnosis
    assert found.tried == 0 and not found.effects
