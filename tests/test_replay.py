"""The compiled replay gives what `simulate` gives in Drake: every structure, late, with memories, read by a sensor."""

import time as clock

import numpy as np
import pytest

from mmt_drake.analysis.nrmse import rms
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed
from mmt_drake.replay import replayed
from mmt_drake.simulation import replay, simulate

BOX = FlexibleBoxModel(BoxParameters(m=0.8, k1=30.0, k2=400.0, b1=5.0, b2=20.0, Fc=0.3), NormalContact(600.0, 20.0))
SPRING = KelvinVoigt(k=300.0, b=20.0, x0=0.002, F0=0.3)
DRIVEN = DrivenBodyModel(m=0.5, b=1.0, k=20.0, Fc=0.2, gain=2.0, offset=0.1, gravity=Gravity("pendulum", 0.4))
DELAY = {"time_delay": {"delay": 0.0123}}
MEMORY = {"viscoelastic_relaxation": {"k_maxwell": 200.0, "tau": 0.05}, "hysteresis": {"alpha": 150.0, "beta": 80.0}}
SENSOR = {
    "force_lag": {"tau": 0.01},
    "force_crosstalk": {"gain": 0.2},
    "force_bias": {"bias": 0.3},
    "force_saturation": {"limit": 4.0},
    "tip_mass": {"m_tip": 0.2},
}
FRICTION = {"load_dependent_friction": {"mu": 0.1}, "static_friction": {"Fs": 0.6, "Fd": 0.3, "v_d": 0.004}}
BODY = {"mass_change": {"time": 0.7, "dm": 0.3}, "end_stop": {"position": 0.01, "stiffness": 500.0}}
CASES = {"plain": {}, "late": DELAY, "remembering": MEMORY, "sliding": FRICTION, "all": {**DELAY, **MEMORY, **FRICTION}}


def times(n=1200, seed=0):
    """An uneven clock that does not begin at 0."""
    return 50.0 + np.cumsum(np.random.default_rng(seed).uniform(0.5e-3, 1.5e-3, n))


def with_effects(model, effects):
    for name, values in effects.items():
        effect = LIBRARY[name]
        model = effect.apply(model, effect.checked(values, model, "test"))
    return model


def contact(**columns):
    """Strokes along x and y that touch, leave and touch again."""
    t = times()
    s = t - t[0]
    position = [0.02 * np.sin(11 * s), 0.03 * np.sin(20 * s), -0.002 + 0.004 * np.sin(9 * s)]
    velocity = [0.22 * np.cos(11 * s), 0.6 * np.cos(20 * s), 0.036 * np.cos(9 * s)]
    data = {f"position_{axis}": values for axis, values in zip("xyz", position, strict=True)}
    data |= {f"velocity_{axis}": values for axis, values in zip("xyz", velocity, strict=True)}
    data |= {f"force_{axis}": np.zeros_like(t) for axis in "xyz"}
    told = {name: values(s) for name, values in columns.items()}
    return Recording(t, data | told, derived=frozenset() if told else frozenset({"in_contact"}))


def single():
    t = times()
    s = t - t[0]
    return Recording(t, {"position": 0.03 * np.sin(20 * s), "velocity": 0.6 * np.cos(20 * s), "force": 0.0 * s})


def driven(load=True):
    t = times()
    s = t - t[0]
    columns = {"input": 3 * np.sin(8 * s), "output": 0.1 + 0 * s, "output_rate": 0 * s}
    return Recording(t, columns | ({"load": 3 + 2 * np.sin(5 * s)} if load else {}))


def check_equal(model, recording):
    """Every column that Drake simulates, to what the order of additions may change."""
    compiled, in_drake = replayed(model, recording), replay(model, recording)
    assert set(compiled) == set(in_drake)
    for name, values in in_drake.items():
        np.testing.assert_allclose(compiled[name], values, atol=1e-9, err_msg=name)
    return compiled


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("told", [False, True], ids=["by_geometry", "contact_told"])
def test_a_flexible_box(case, told):
    flag = {"in_contact": lambda s: (np.sin(5 * s) > -0.5).astype(float)} if told else {}
    model = with_effects(BOX, {**CASES[case], **SENSOR, **(BODY if case == "all" else {})})
    force = check_equal(model, contact(**flag))
    assert force["force_y"].std() > 0.5 and force["force_z"].std() > 0.5
    assert np.abs(force["force_y"]).max() <= 4.0  # what the sensor reads


@pytest.mark.parametrize("case", CASES)
def test_a_flexible_box_along_one_axis(case):
    force = check_equal(with_effects(BOX, {**CASES[case], **SENSOR}), single())
    assert set(force) == {"force"} and force["force"].std() > 0.5


@pytest.mark.parametrize("case", CASES)
def test_a_kelvin_voigt_contact(case):
    force = check_equal(with_effects(SPRING, {**CASES[case], **SENSOR}), single())
    assert force["force"].std() > 0.5


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("load", [False, True], ids=["no_load", "load"])
def test_a_driven_body(case, load):
    answer = check_equal(with_effects(DRIVEN, {**CASES[case], **(BODY if case == "all" else {})}), driven(load))
    assert answer["output"][0] == pytest.approx(0.1) and np.ptp(answer["output"]) > 0.05


def test_two_memories_of_the_body_and_two_of_the_sensor_do_not_meet():
    both = with_effects(BOX, {**MEMORY, "force_lag": {"tau": 0.01}})
    check_equal(both, contact())
    lagged = replayed(both, contact())["force_y"]
    prompt = replayed(with_effects(BOX, MEMORY), contact())["force_y"]
    t = times()
    y = np.empty_like(prompt)  # the lag alone, step by step, on the force without it
    y[0] = prompt[0]
    for k in range(1, len(y)):
        h = t[k] - t[k - 1]
        left = np.exp(-h / 0.01)
        ramp = 1.0 - (1.0 - left) * 0.01 / h
        y[k] = left * y[k - 1] + (1.0 - left) * prompt[k - 1] + ramp * (prompt[k] - prompt[k - 1])
    np.testing.assert_allclose(lagged, y, atol=1e-9)


def test_simulated_columns_of_a_recording_are_the_replays():
    model, recording = with_effects(BOX, {**DELAY, **SENSOR}), contact()
    result = simulate(model, recording)
    for name, values in replayed(model, recording).items():
        np.testing.assert_allclose(result[name], values, atol=1e-9)


def test_it_is_many_times_faster():
    model, recording = with_effects(BOX, {**DELAY, **MEMORY, **SENSOR}), contact()
    seconds = []
    for answer in (replayed, replay):
        answer(model, recording)
        took = []
        for _ in range(3):
            began = clock.perf_counter()
            answer(model, recording)
            took.append(clock.perf_counter() - began)
        seconds.append(min(took))
    assert seconds[0] < 0.2 * seconds[1]


@pytest.mark.parametrize(
    ("model", "recording"), [(BOX, contact), (DRIVEN, driven)], ids=["flexible box", "driven body"]
)
def test_a_replay_in_many_parts_is_that_in_one(monkeypatch, model, recording):
    whole = replayed(model, recording())
    monkeypatch.setattr("mmt_drake.replay._STEPS_AT_ONCE", 37.0)
    for name, values in replayed(model, recording()).items():
        np.testing.assert_array_equal(values, whole[name])


@pytest.mark.parametrize("run", [replayed, replay])
def test_a_replay_that_would_take_minutes_is_refused(run):
    times = np.array([0.0, 0.5, 1e9])
    columns = {name: np.zeros(3) for name in ("time", "input", "output")}
    with pytest.raises(BadInput, match=r"time: found 1e\+09 s, in steps of .* expected at most 2e\+08 steps"):
        run(DRIVEN, Recording(times, {name: columns[name] for name in ("input", "output")}, "slow.csv"))


@pytest.mark.parametrize("run", [replayed, replay])
def test_two_samples_days_apart_are_refused(run):
    columns = {name: np.zeros(3) for name in ("input", "output")}
    with pytest.raises((BadInput, RuntimeError), match="two samples more than ten million integration steps apart"):
        run(DRIVEN, Recording(np.array([0.0, 0.5, 1e6]), columns, "gap.csv"))


def test_a_recording_of_another_kind_is_refused_in_one_line():
    with pytest.raises(BadInput, match="found a driven_body recording, expected the columns time, position_x"):
        replayed(BOX, driven())
    with pytest.raises(BadInput, match="expected the columns time, input, output"):
        replayed(DRIVEN, single())
    with pytest.raises(BadInput, match="found a contact recording, expected the columns time, position, force"):
        replayed(SPRING, contact())
    with pytest.raises(BadInput, match="found a driven_body recording"):
        replayed(SPRING, driven())


def on_an_encoder(count):
    """A slow stroke with dwells, as an encoder of such counts has it, and its true motion; no velocity recorded."""
    t = 1e-3 * np.arange(12000)
    s = np.clip(np.sin(1.5 * t) * 1.1, -1.0, 1.0)
    columns = {"position": count * np.round(0.5 * s / count), "force": np.zeros_like(t)}
    moves = 1.65 * np.cos(1.5 * t) * (np.abs(s) < 1.0)
    true = {"position": 0.5 * s, "velocity": 0.5 * moves, "force": np.zeros_like(t)}
    return completed(t, columns, "encoder"), Recording(t, true)


def test_friction_that_counts_way_does_not_count_the_steps_of_an_encoder():
    model = with_effects(KelvinVoigt(), {"dahl_friction": {"Fc": 0.04, "sigma": 4.0}})
    seen, true = (replayed(model, recording)["force"] for recording in on_an_encoder(8e-4))
    assert rms(seen - true) < 0.03 * rms(true)
    seen, diagram = replayed(model, on_an_encoder(8e-4)[0])["force"], replay(model, on_an_encoder(8e-4)[0])["force"]
    np.testing.assert_allclose(diagram, seen, atol=1e-12)
