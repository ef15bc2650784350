"""Diagnoses of models with curves over what was recorded beside, and of closed loops."""

from functools import cache

import numpy as np
import pytest

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.report_tables import curve_table
from mmt_drake.diagnosis.tell.written import deliver
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import load_model, parse_model
from mmt_drake.over import with_knots
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed
from mmt_drake.simulation import simulate

TIME = np.arange(0.0, 10.0, 5e-3)
SOME = ("coulomb_friction", "quadratic_drag", "nonlinear_stiffness")
LEVELS = {0.0: 4.0, 0.5: 9.0, 1.0: 20.0}
DAMPING = {0.0: 40.0, 0.5: 55.0, 1.0: 90.0}


def library():
    return [LIBRARY[name] for name in SOME]


def damper(current, generator):
    """A damper whose damping and dry friction grow with a current, stroked at several frequencies."""
    x = 0.02 * np.sin(2.0 * np.pi * 0.7 * TIME) + 0.01 * np.sin(2.0 * np.pi * 1.9 * TIME + current)
    v = 2.0 * np.pi * (0.014 * np.cos(2.0 * np.pi * 0.7 * TIME) + 0.019 * np.cos(2.0 * np.pi * 1.9 * TIME + current))
    force = -300.0 * x - DAMPING[current] * v - LEVELS[current] * np.sign(v)
    columns = {"position": x, "velocity": v, "force": force + 0.05 * generator.standard_normal(len(TIME))}
    return Recording(TIME, columns, f"at {current:g} A.csv", constants={"current_A": current})


@cache
def of_dampers() -> Outcome:
    generator = np.random.default_rng(5)
    recordings = [damper(current, generator) for current in LEVELS]
    data = {"structure": "kelvin_voigt", "parameters": {"k": 250.0, "b": 60.0}}
    return diagnose(recordings, parse_model(data | {"over": {"b": "current", "Fc": "current"}}), library=library())


def test_concealed_friction_over_a_column_is_named_with_its_level_at_each_value():
    found = of_dampers().diagnosis
    assert [effect.name for effect in found.effects] == ["coulomb_friction"]
    numbers = found.effects[0].parameters
    for current, level in LEVELS.items():
        number = numbers[f"Fc(current={current:g})"]
        assert number.value == pytest.approx(level, rel=0.02)
        assert number.ci95[0] < number.value < number.ci95[1]


def test_the_numbers_that_are_curves_are_told_at_their_knots():
    found = of_dampers().diagnosis
    curves = {curve.number: curve for curve in found.curves}
    assert curves["b"].over == "current" and curves["b"].at == (0.0, 0.5, 1.0)
    assert curves["b"].value == pytest.approx([*DAMPING.values()], rel=0.02)
    assert curves["b"].nominal == (60.0, 60.0, 60.0)
    assert curves["coulomb_friction.Fc"].value == pytest.approx([*LEVELS.values()], rel=0.02)
    lows, highs = curves["b"].ci95
    assert all(low < value < high for low, value, high in zip(lows, curves["b"].value, highs, strict=True))
    assert found.parameters["b(current=1)"].value == pytest.approx(90.0, rel=0.02)
    rows = curve_table(found).rows
    assert [row[:3] for row in rows] == [(name, "current", at) for name in curves for at in DAMPING]


def test_the_delivered_file_simulates_the_same_figures_and_can_be_handed_in_again(tmp_path):
    outcome = of_dampers()
    model = load_model(deliver(outcome, tmp_path))  # which holds the file to the figures that were promised
    for recording in outcome.prepared.recordings:
        left = recording["force"] - simulate(model, recording)["force"]
        assert np.std(left) < 0.02 * np.std(recording["force"])
    again = with_knots(model, outcome.prepared.recordings)
    kept = {curve.number: curve.value for curve in again.over if curve.number in ("b", "coulomb_friction.Fc")}
    assert kept == {curve.number: curve.value for curve in outcome.diagnosis.curves}


def test_a_level_that_follows_a_column_within_one_recording_is_found_at_its_knots():
    true = {"structure": "driven_body", "parameters": {"m": 0.5, "b": 1.5, "k": 20.0, "Fc": 1.0}}
    believed = {"structure": "driven_body", "parameters": {"m": 0.5, "b": 1.5, "k": 20.0, "Fc": 0.7}}
    curve = {"of": "temperature", "at": [20.0, 40.0], "value": [1.6, 0.4]}
    u = 4.0 * np.sin(2.0 * np.pi * 0.6 * TIME) + 2.0 * np.sin(2.0 * np.pi * 1.7 * TIME)
    warming = 40.0 - 20.0 * np.exp(-TIME / 4.0)
    columns = {"input": u, "output": 0.0 * u, "temperature": warming}
    output = replayed(parse_model(true | {"over": {"Fc": curve}}), Recording(TIME, columns))["output"]
    noise = 2e-5 * np.random.default_rng(1).standard_normal(len(TIME))
    recording = Recording(TIME, columns | {"output": output + noise})
    found = diagnose([recording], parse_model(believed | {"over": {"Fc": "temperature"}}), library=library()).diagnosis
    assert found.verdict == "parameters"
    (told,) = found.curves
    assert told.value == pytest.approx(np.interp(told.at, curve["at"], curve["value"]), abs=0.03)


def test_a_hypothesis_puts_the_numbers_of_curves_where_they_belong():
    data = {"structure": "kelvin_voigt", "parameters": {"k": 5.0, "b": 2.0}, "over": {"b": "recording"}}
    recordings = [Recording(TIME, {}, name) for name in ("a", "b")]
    hypothesis = Hypothesis.of(with_knots(parse_model(data), recordings)).adding(LIBRARY["coulomb_friction"])
    assert hypothesis.free == ("k", "b(recording=a)", "b(recording=b)")
    x = hypothesis.vector({"b(recording=b)": 6.0}, {"coulomb_friction": {"Fc": 0.5}})
    assert x.tolist() == [5.0, 2.0, 6.0, 0.5]
    model = hypothesis.model(x)
    assert (model.b, model.curve("b").value) == (4.0, (2.0, 6.0))
    assert hypothesis.effect_values(x) == {"coulomb_friction": {"Fc": 0.5}}


@cache
def of_a_loop() -> Outcome:
    loop = {"controller": {"kind": "pd", "gains": {"kp": 60.0, "kd": 1.0}, "limits": 30.0}}
    true = parse_model({"structure": "driven_body", "parameters": {"m": 0.8, "b": 3.0, "Fc": 1.2}} | loop)
    time = TIME[:1200]
    goal = 0.1 * np.sin(2.0 * np.pi * 0.4 * time) + 0.05 * np.sin(2.0 * np.pi * 1.3 * time)
    columns = {"input": goal, "output": 0.0 * goal}
    output = replayed(true, Recording(time, columns))["output"]
    noise = 2e-5 * np.random.default_rng(2).standard_normal(len(time))
    recording = Recording(time, columns | {"output": output + noise}, "loop.csv")
    believed = parse_model({"structure": "driven_body", "parameters": {"m": 0.7, "b": 3.5}} | loop)
    return diagnose([recording], believed, library=library())


def test_friction_concealed_in_a_closed_loop_is_found_from_its_goal():
    found = of_a_loop().diagnosis
    assert found.verdict == "missing_physics"
    assert [effect.name for effect in found.effects] == ["coulomb_friction"]
    assert found.effects[0].parameters["Fc"].value == pytest.approx(1.2, rel=0.02)
    assert of_a_loop().best.hypothesis.structure_values(of_a_loop().best.x)["m"] == pytest.approx(0.8, rel=0.05)


def test_a_closed_loop_is_held_against_whole_recordings_and_its_file_simulates_the_same(tmp_path):
    outcome = of_a_loop()
    fit = outcome.diagnosis.fit
    assert fit.window_s == pytest.approx(TIME[1199])
    assert fit.heldout_nrmse == fit.heldout_nrmse_free
    model = load_model(deliver(outcome, tmp_path))
    assert model.controller == outcome.nominal.controller
    (recording,) = outcome.prepared.recordings
    left = recording["output"] - simulate(model, recording)["output"]
    assert np.std(left) == pytest.approx(2e-5, rel=0.3)
