"""Closed loops: the controller inside the simulation, held against closed forms and an integrator of its own."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mmt_drake.errors import BadInput
from mmt_drake.model.controller import Controller
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model_files import model_data, parse_model, with_effects
from mmt_drake.recording import Recording
from mmt_drake.replay import in_windows, replayed
from mmt_drake.simulation import simulate
from mmt_drake.windows import Windows

TIME = np.arange(0.0, 4.0, 2e-3)
LOOP = {"structure": "driven_body", "parameters": {"m": 1.0}}


def recorded(u, **columns):
    return Recording(TIME, {"input": u, "output": np.zeros(len(TIME)), **columns})


def test_a_proportional_loop_answers_a_step_as_a_second_order_lag_does():
    m, b, gain, kp = 0.5, 3.0, 2.0, 40.0
    model = DrivenBodyModel(m=m, b=b, gain=gain, controller=Controller("p", kp))
    w, z = np.sqrt(gain * kp / m), b / (2.0 * np.sqrt(gain * kp * m))
    wd = w * np.sqrt(1.0 - z**2)
    expected = 1.0 - np.exp(-z * w * TIME) * (np.cos(wd * TIME) + z * w / wd * np.sin(wd * TIME))
    assert replayed(model, recorded(np.ones(len(TIME))))["output"] == pytest.approx(expected, abs=2e-6)


def test_the_derivative_is_that_of_the_position_measured():
    damped = DrivenBodyModel(m=1.0, b=1.0 + 0.5 * 6.0, gain=0.5, controller=Controller("p", 80.0))
    derived = DrivenBodyModel(m=1.0, b=1.0, gain=0.5, controller=Controller("pd", 80.0, kd=6.0))
    goal = recorded(np.where(TIME > 1.0, 1.0, np.sin(3.0 * TIME)))
    assert replayed(derived, goal)["output"] == pytest.approx(replayed(damped, goal)["output"], abs=1e-6)


def test_limits_and_the_integral_that_waits_at_them_are_those_of_another_integrator():
    model = DrivenBodyModel(m=1.2, b=2.0, offset=-3.0, controller=Controller("pid", 60.0, 90.0, 5.0, -9.0, 8.0))

    def rates(t, y):
        x, v, q = y
        error = (1.0 if np.sin(1.5 * t) > 0.0 else -0.5) - x
        wanted = 60.0 * error + 90.0 * q - 5.0 * v
        u = min(max(wanted, -9.0), 8.0)
        return [v, (u - 3.0 - 2.0 * v) / 1.2, 0.0 if (wanted - u) * error > 0.0 else error]

    fine = np.arange(0.0, 3.0, 2e-4)
    goal = np.where(np.sin(1.5 * fine) > 0.0, 1.0, -0.5)
    found = replayed(model, Recording(fine, {"input": goal, "output": 0.0 * fine}))["output"]
    expected = solve_ivp(rates, (0.0, 3.0), [0.0, 0.0, 0.0], t_eval=fine, max_step=2e-3).y[0]
    assert found == pytest.approx(expected, abs=2e-3 * np.ptp(expected))
    assert np.ptp(expected) > 1.0


def test_what_rubs_in_proportion_to_the_load_feels_the_controller_s_force():
    model = with_effects(
        DrivenBodyModel(m=1.0, b=12.0, gain=2.0, controller=Controller("p", 10.0)),
        [{"name": "load_dependent_friction", "parameters": {"mu": 0.3}}],
        "model",
    )

    def rates(t, y):  # overdamped: it goes one way, towards the goal
        force = 20.0 * (1.0 - y[0])
        return [y[1], force - 12.0 * y[1] - 0.3 * abs(force)]

    expected = solve_ivp(rates, (0.0, 4.0), [0.0, 0.0], t_eval=TIME, rtol=1e-9, atol=1e-12).y[0]
    assert replayed(model, recorded(np.ones(len(TIME))))["output"] == pytest.approx(expected, abs=1e-6)


def test_coulomb_friction_holds_the_body_short_of_its_goal_and_an_integral_takes_it_there():
    stuck = DrivenBodyModel(m=1.0, b=20.0, Fc=5.0, controller=Controller("p", 100.0))
    taken = DrivenBodyModel(m=1.0, b=20.0, Fc=5.0, controller=Controller("pi", 100.0, ki=60.0))
    goal = recorded(np.full(len(TIME), 0.04))
    assert not replayed(stuck, goal)["output"].any()  # 4 N of 5 N
    output = replayed(taken, goal)["output"]
    # It lets go when 100 e + 60 e t, e = 0.04, has grown to 5 N.
    assert TIME[np.argmax(output > 0.0)] == pytest.approx((5.0 - 4.0) / (60.0 * 0.04), abs=0.01)


def test_drake_simulates_the_same_loop_and_takes_the_column_goal_as_its_input():
    model = DrivenBodyModel(m=1.0, b=2.0, Fc=0.5, controller=Controller("pid", 50.0, 20.0, 1.0, -8.0, 8.0))
    goal = np.sin(2.0 * TIME)
    known = recorded(goal)
    both = recorded(np.full(len(TIME), 7.0), goal=goal)
    expected = replayed(model, known)["output"]
    assert simulate(model, known)["output"] == pytest.approx(expected, abs=1e-12)
    assert np.array_equal(replayed(model, both)["output"], expected)
    assert np.array_equal(simulate(model, both)["input"], both["input"])


def test_the_command_that_is_told_is_the_one_that_moved_the_body():
    controller = Controller("pi", 50.0, ki=20.0, low=-6.0, high=6.0)
    model = DrivenBodyModel(m=1.0, b=2.0, controller=controller)
    goal = np.where(TIME > 0.5, 1.0, 0.0)
    found = replayed(model, recorded(goal))
    u = model.commanded(TIME, goal, found["output"], found["output_rate"])
    again = replayed(DrivenBodyModel(m=1.0, b=2.0), recorded(u))
    assert again["output"] == pytest.approx(found["output"], abs=0.02)
    assert np.abs(u).max() == 6.0


def test_windows_of_a_loop_without_memory_begin_in_fitted_states():
    model = DrivenBodyModel(m=1.0, b=2.0, controller=Controller("pd", 50.0, kd=1.0))
    true = recorded(np.sin(2.0 * TIME))
    true = recorded(true["input"], output=replayed(model, true)["output"])
    windows = Windows.of(TIME, true["output"], 0.5)
    found = in_windows(model, true, windows)[0]["output"]
    assert found[windows.scored] == pytest.approx(true["output"][windows.scored], abs=1e-4)


def test_a_model_file_tells_the_controller_and_reads_back():
    data = LOOP | {"controller": {"kind": "pi", "gains": {"kp": 3.0, "ki": 0.5}, "limits": [-1.0, 2.0]}}
    model = parse_model(data)
    assert model.controller == Controller("pi", 3.0, 0.5, low=-1.0, high=2.0)
    assert parse_model(model_data(model)) == model
    assert parse_model(LOOP | {"controller": {"kind": "p", "gains": {"kp": 3}, "limits": 5}}).controller.low == -5


REMEMBERING = {"hysteresis": {"alpha": 1.0, "beta": 9.0}, "viscoelastic_relaxation": {"k_maxwell": 9.0, "tau": 0.1}}
P = {"kind": "p", "gains": {"kp": 1.0}}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"controller": {"kind": "lqr", "gains": {}}}, "controller.kind: found 'lqr', expected p or pd or pi or pid"),
        ({"controller": {"kind": "pd", "gains": {"kp": 1.0}}}, "controller.gains: found kp, expected kd, kp of a pd"),
        ({"controller": P | {"gains": {"kp": -1.0}}}, "controller.kp: found -1.0, expected"),
        ({"controller": P | {"gains": {"kp": float("nan")}}}, "controller.kp: found nan, expected"),
        ({"controller": P | {"gain": 3}}, r"controller: found the key 'gain' \(did you mean 'gains'"),
        ({"controller": P | {"limits": [2.0, 1.0]}}, "controller.limits: found 2 to 1, expected low below high"),
        ({"controller": P | {"limits": [1.0]}}, r"controller.limits: found \[1.0\], expected \[low, high\]"),
        ({"controller": "p"}, "controller: found str, expected a mapping"),
        ({"controller": P, "parameters": {"m": 1.0, "gain": 0.0}}, "parameters.gain: found 0 behind a controller"),
        (
            {"controller": {"kind": "pi", "gains": {"kp": 1.0, "ki": 1.0}}, "window_s": 1.0},
            "controller: found window_s beside a pi",
        ),
        (
            {
                "controller": {"kind": "pi", "gains": {"kp": 1.0, "ki": 1.0}},
                "effects": [{"name": name, "parameters": values} for name, values in REMEMBERING.items()],
            },
            "effects: found 3 effects with a memory .* with the integral of its controller, expected 2 at most",
        ),
        ({"controller": P, "structure": "kelvin_voigt", "parameters": {"k": 1.0}}, "found the key 'controller'"),
    ],
)
def test_a_controller_that_is_none_is_refused_in_one_line(changes, message):
    with pytest.raises(BadInput, match=message) as caught:
        parse_model(LOOP | changes)
    assert "\n" not in str(caught.value)
