"""What happens along the surface normal is seen, named along it, and never hidden behind axes that are explained."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from trial_samples import BASE, FORCE_NOISE, model, recorded

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.effects import LIBRARY
from mmt_drake.model.parameters import NormalContact
from mmt_drake.recording import Recording

SECONDS, EXPONENT = 15.0, 1.5
STIFFNESS = BASE["normal_k"] * 0.006 ** (1.0 - EXPONENT)  # as stiff as the linear one 6 mm deep
OTHERS = ("coulomb_friction", "force_bias", "nonlinear_stiffness", "normal_hunt_crossley_damping")


def pressed(**changed: np.ndarray) -> Recording:
    recording = recorded(seed=3, seconds=SECONDS)
    return replace(recording, columns={**recording.columns, **changed})


@cache
def of_a_ball() -> Recording:
    """The normal force of a ball on something elastic, with the damper beside it: of formulas alone."""
    recording = recorded(seed=3, seconds=SECONDS)
    z, rate = recording["position_z"], np.gradient(recording["position_z"], recording.time)
    smooth = np.convolve(rate, np.ones(15) / 15.0, "same")
    force = STIFFNESS * np.maximum(-z, 0.0) ** EXPONENT - BASE["normal_b"] * smooth
    noise = FORCE_NOISE * np.random.default_rng(5).standard_normal(len(z))
    return pressed(force_z=np.where(recording["in_contact"] > 0.0, force, 0.0) + noise)


@cache
def diagnosed(*library: str) -> Outcome:
    return diagnose([of_a_ball()], model(), library=[LIBRARY[name] for name in library])


def test_a_power_law_along_the_normal_is_named_with_its_axis_and_exponent() -> None:
    found = diagnosed("power_law_stiffness", *OTHERS).diagnosis
    assert found.verdict == "missing_physics"
    assert [(e.name, e.axis, e.family) for e in found.effects] == [("power_law_stiffness", "z", "contact_stiffness")]
    exponent = found.effects[0].parameters["p"]
    assert exponent.value == pytest.approx(EXPONENT, abs=0.02)
    low, high = exponent.ci95
    assert low < EXPONENT < high < low + 0.1
    assert not set(found.parameters) & {"m", "k2", "b1", "b2"}
    assert "power law stiffness along z" in found.summary


def test_where_no_law_names_it_the_verdict_says_along_which_axis_the_mismatch_is() -> None:
    found = diagnosed(*OTHERS).diagnosis
    assert found.verdict in ("unexplained", "partly_explained")
    assert all(e.axis == "z" or e.name == "tabulated_force" for e in found.effects)
    assert found.mismatch.axes["z"] > 0.9
    assert found.mismatch.blocks[0].block == "contact"
    assert found.mismatch.depends_on[0].signal == "depth"
    assert "along z" in found.summary


def test_the_model_delivered_simulates_what_the_fit_has_and_each_axis_is_told() -> None:
    fit = diagnosed("power_law_stiffness", *OTHERS).diagnosis.fit
    assert fit is not None and fit.axes == ("x", "y", "z")
    told: Mapping[str, float] = {one.axis: one.heldout_nrmse.augmented / one.noise_floor for one in fit.by_axis}
    assert set(told) == {"x", "y", "z"} and max(told.values()) < 1.2
    before = {one.axis: one.heldout_nrmse.nominal / one.noise_floor for one in fit.by_axis}
    assert max(before["x"], before["y"]) < 1.2 and before["z"] > 3.0


def test_a_wrong_stiffness_along_the_normal_is_a_parameter_with_its_interval() -> None:
    wrong = replace(model(), normal=NormalContact(0.8 * BASE["normal_k"], BASE["normal_b"]))
    found = diagnose([pressed()], wrong, library=[]).diagnosis
    assert found.verdict == "parameters" and set(found.parameters) == {"normal.k"}
    low, high = found.parameters["normal.k"].ci95
    assert low < BASE["normal_k"] < high < 1.02 * low


def test_a_normal_axis_that_the_model_leaves_out_is_found_from_nothing() -> None:
    bare = replace(model(), normal=NormalContact(0.0, 0.0))
    found = diagnose([pressed()], bare, library=[]).diagnosis
    assert found.verdict == "parameters" and set(found.parameters) == {"normal.k", "normal.b"}
    assert found.parameters["normal.k"].value == pytest.approx(BASE["normal_k"], rel=0.01)
    assert found.parameters["normal.b"].value == pytest.approx(BASE["normal_b"], rel=0.1)
