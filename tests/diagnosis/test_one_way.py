"""What a press tells that never turns: stiffness and relaxation, but not friction from an offset."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.tell.result import Diagnosis
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import parse_model
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.check import completed
from mmt_drake.simulation import simulate

TIME = np.arange(2000) * 0.01
PRESS = PchipInterpolator([0, 1, 4, 7, 9, 12, 15, 17, 20], [0, 0, 4e-3, 4e-3, 6e-3, 10e-3, 10e-3, 13e-3, 15e-3])
NOMINAL = {"structure": "kelvin_voigt", "parameters": {"k": 200.0, "b": 40.0}}
TRIED = (
    "coulomb_friction", "dahl_friction", "force_bias", "nonlinear_stiffness", "viscoelastic_relaxation",
    "periodic_disturbance", "force_drift",
)  # fmt: skip
COULOMB = {"name": "coulomb_friction", "parameters": {"Fc": 0.4}}
BIAS = {"name": "force_bias", "parameters": {"bias": 0.4}}
CUBIC = {"name": "nonlinear_stiffness", "parameters": {"k3": 1e6}}
RELAXATION = {"name": "viscoelastic_relaxation", "parameters": {"k_maxwell": 150.0, "tau": 1.5}}


def diagnosed(effects: Sequence[Mapping[str, Any]]) -> Diagnosis:
    rng = np.random.default_rng(3)
    still = completed(TIME, {"position": PRESS(TIME), "force": 0.0 * TIME}, "press")
    force = simulate(parse_model({**NOMINAL, "effects": effects}, "truth"), still)["force"]
    noisy = {"position": PRESS(TIME) + rng.normal(0.0, 2e-7, len(TIME)), "force": force + rng.normal(0.0, 0.01, 2000)}
    model = parse_model(dict(NOMINAL), "nominal")
    return diagnose([completed(TIME, noisy, "press")], model, library=[LIBRARY[name] for name in TRIED]).diagnosis


@pytest.mark.parametrize("effect", [COULOMB, BIAS], ids=["coulomb", "bias"])
def test_friction_and_an_offset_cannot_be_told_apart(effect: Mapping[str, Any]) -> None:
    found = diagnosed([effect])
    assert found.verdict == "ambiguous" and [e.certain for e in found.effects] == [None]
    named = {e.name for e in found.effects} | {a.name for a in found.alternatives if a.indistinguishable}
    assert {"coulomb_friction", "force_bias"} <= named


@pytest.mark.parametrize("effects", [[CUBIC], [RELAXATION], [CUBIC, RELAXATION]], ids=["cubic", "relaxation", "both"])
def test_stiffness_and_relaxation_need_no_turn(effects: Sequence[Mapping[str, Any]]) -> None:
    found = diagnosed(effects)
    assert {(e.name, e.certain) for e in found.effects} == {(e["name"], "law") for e in effects}


DROPPED, DROP = np.arange(45) / 15.0, -0.5 * 9.81 * (np.arange(45) / 15.0) ** 2
BALL = {"structure": "driven_body", "parameters": {"m": 0.5}, "gravity": {"kind": "constant", "value": 9.81}}


def dropped(height: Array, noise: float) -> Diagnosis:
    """What the whole library makes of one fall before a camera of 15 Hz."""
    seen = height + np.random.default_rng(1).normal(0.0, noise, len(height))
    return diagnose(
        [completed(DROPPED, {"input": 0.0 * DROPPED, "output": seen}, "drop")], parse_model(BALL, "")
    ).diagnosis


def test_what_falls_once_is_drag_though_laws_with_more_numbers_draw_it_too() -> None:
    rate = 0.4  # b/m [1/s]
    found = dropped(-9.81 / rate**2 * (rate * DROPPED - 1.0 + np.exp(-rate * DROPPED)), 0.03)
    assert [(e.name, e.certain) for e in found.effects] == [("viscous_friction", "law")]


def test_a_lens_that_bends_a_fall_is_no_law() -> None:
    """A force, and a mass that changes, would draw it: any curve with as many numbers does."""
    bent = DROP * (1.0 - 0.03 * DROP / DROP.min() + 0.05 * (DROP / DROP.min()) ** 2)
    assert dropped(bent, 0.01).verdict == "unexplained"


def test_drag_of_what_falls_is_known_beside_the_mass_that_was_handed_in() -> None:
    """Only b/m can be told; both free, the interval of b would go as far as the bounds of m."""
    rate, time = 0.9, np.arange(300) * 0.01  # b/m [1/s]
    fallen = 9.81 / rate**2 * (1.0 - np.exp(-rate * time) - rate * time)
    columns = {"input": 0.0 * time, "output": fallen + np.random.default_rng(1).normal(0.0, 0.002, len(time))}
    model = {"structure": "driven_body", "parameters": {"m": 0.05}, "gravity": {"kind": "constant", "value": 9.81}}
    tried = [LIBRARY[name] for name in ("viscous_friction", "quadratic_drag", "mass_change")]
    found = diagnose([completed(time, columns, "drop")], parse_model(model, "ball"), library=tried).diagnosis
    assert [(e.name, e.certain) for e in found.effects] == [("viscous_friction", "law")]
    low, high = found.effects[0].parameters["b"].ci95
    assert low < 0.05 * rate < high and high - low < 0.1 * 0.05 * rate
    assert not found.parameters
