"""`simulate`: a recording through a model, at the recording's own times."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model import driven_body
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.motion.delay import delayed_input
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed
from mmt_drake.simulation import simulate


def uneven_times(n, seed=0):
    return 100.0 + np.cumsum(np.random.default_rng(seed).uniform(0.5e-3, 1.5e-3, n))


def recording(time, position, velocity, **columns):
    data = {}
    for name, values in (("position", position), ("velocity", velocity), ("force", np.zeros_like(position))):
        data |= {f"{name}_{axis}": values[:, i] for i, axis in enumerate("xyz")}
    return Recording(time, data | columns)


def smooth(t):
    s = t - t[0]
    position = np.column_stack([0.02 * np.sin(11 * s), 0.03 * np.sin(20 * s), -0.003 + 0.001 * np.sin(3 * s)])
    velocity = np.column_stack([0.22 * np.cos(11 * s), 0.6 * np.cos(20 * s), 0.003 * np.cos(3 * s)])
    return position, velocity


def test_smooth_motion_on_an_uneven_clock_agrees_with_adaptive_integration_to_1e_6():
    t = uneven_times(3000)
    p = BoxParameters(m=0.7, k1=50, k2=600, b1=20, b2=30)
    result = simulate(FlexibleBoxModel(p), recording(t, *smooth(t)))

    def rhs(s, y):
        push = 600 * (0.03 * np.sin(20 * s) - y[0]) + 30 * (0.6 * np.cos(20 * s) - y[1])
        return [y[1], (push - 50 * y[0] - 20 * y[1]) / 0.7]

    s = t - t[0]
    y = solve_ivp(rhs, (0, s[-1]), [0, 0], t_eval=s, method="DOP853", rtol=1e-11, atol=1e-14).y
    expected = -(600 * (0.03 * np.sin(20 * s) - y[0]) + 30 * (0.6 * np.cos(20 * s) - y[1]))
    assert np.sqrt(np.mean((result["force_y"] - expected) ** 2)) < 1e-6 * np.sqrt(np.mean(expected**2))
    np.testing.assert_array_equal(result.time, t)


def test_columns_and_times_are_the_recordings_own():
    t = uneven_times(50)
    original = recording(t, *smooth(t), in_contact=np.ones(50), master_position_x=np.arange(50.0))
    result = simulate(FlexibleBoxModel(), original)
    assert list(result.columns) == list(original.columns)
    for name in original.columns:
        if not name.startswith("force"):
            np.testing.assert_array_equal(result[name], original[name])


def test_recorded_contact_decides_where_it_is_known():
    t = uneven_times(400)
    position, velocity = smooth(t)
    flag = (np.arange(400) >= 200).astype(float)
    force = simulate(FlexibleBoxModel(), recording(t, position, velocity, in_contact=flag)).vector("force")
    assert np.all(force[:200] == 0) and np.all(force[200:, 2] != 0)


def test_kelvin_voigt_is_its_closed_form():
    t = uneven_times(300)
    x, v = 0.01 * np.sin(t), 0.01 * np.cos(t)
    single = Recording(t, {"position": x, "force": np.zeros(300), "velocity": v})
    result = simulate(KelvinVoigt(k=300, b=20, x0=0.002, F0=0.3), single)
    np.testing.assert_allclose(result["force"], 0.3 - 300 * (x - 0.002) - 20 * v, rtol=1e-12)


def test_one_axis_drives_a_box_tangentially():
    t = uneven_times(300)
    position, velocity = smooth(t)
    three = simulate(FlexibleBoxModel(), recording(t, position, velocity, in_contact=np.ones(300)))
    single = Recording(t, {"position": position[:, 1], "force": np.zeros(300), "velocity": velocity[:, 1]})
    np.testing.assert_allclose(simulate(FlexibleBoxModel(), single)["force"], three["force_y"], atol=1e-12)


def test_a_driven_body_starts_where_the_recording_does_and_follows_its_input():
    t = uneven_times(400)
    s = t - t[0]
    driven = Recording(t, {"input": 3 * s, "output": 0.7 + 0 * s, "output_rate": 0 * s})
    result = simulate(DrivenBodyModel(m=0.5, gain=2), driven)
    np.testing.assert_allclose(result["output"], 0.7 + 2 * s**3, atol=1e-12)
    np.testing.assert_allclose(result["output_rate"], 6 * s**2, atol=1e-12)
    bare = Recording(t, {"input": 3 * s, "output": 0.7 + 0 * s})
    assert set(simulate(DrivenBodyModel(m=0.5), bare).columns) == {"input", "output"}


def test_a_model_that_does_not_fit_the_recording_is_refused():
    t = uneven_times(10)
    driven = Recording(t, {"input": np.zeros(10), "output": np.zeros(10)})
    with pytest.raises(BadInput, match="driven_body"):
        simulate(FlexibleBoxModel(), driven)
    with pytest.raises(BadInput, match="time, position, force"):
        simulate(KelvinVoigt(), recording(t, *smooth(t)))
    with pytest.raises(BadInput, match="time, input, output"):
        simulate(DrivenBodyModel(m=1), recording(t, *smooth(t)))


def with_effects(model, **effects):
    for name, values in effects.items():
        effect = LIBRARY[name]
        model = effect.apply(model, effect.checked(values, model, "test"))
    return model


REMEMBERING = {
    "viscoelastic_relaxation": {"k_maxwell": 200, "tau": 0.05},
    "load_dependent_friction": {"mu": 0.1},
    "time_delay": {"delay": 0.0123},
}


@pytest.mark.parametrize("recorded", [True, False])
def test_a_driven_body_with_effects_is_what_the_compiled_replay_gives_under_its_load_or_that_of_its_drive(recorded):
    t = uneven_times(1000)
    s = t - t[0]
    u = 5 * np.sin(8 * s)
    model = with_effects(DrivenBodyModel(m=0.5, b=1, k=20, Fc=0.2, gain=-1.5), **REMEMBERING)
    columns = {"input": u, "output": 0.1 + 0 * s, "output_rate": 0 * s}
    late_u = delayed_input(s, u, 0.0123)
    load = late_load = 1.5 * np.abs(late_u)
    if recorded:
        load = columns["load"] = 3 + 2 * np.sin(5 * s)
        late_load = delayed_input(s, load, 0.0123)
    output, rate, state = np.empty(len(t)), np.empty(len(t)), np.empty(driven_body.STATE_SIZE)
    driven_body.begin(state, 0.0, late_u[0], late_load[0], 0.1)
    driven_body.replay_part(0, len(t), s, late_u, late_load, model.kernel_vector(), state, output, rate)
    for result in (simulate(model, Recording(t, columns)).columns, replayed(model, Recording(t, columns))):
        np.testing.assert_allclose(result["output"], output, atol=1e-9)
        np.testing.assert_allclose(result["output_rate"], rate, atol=1e-9)


def test_a_delay_is_a_shift_of_the_response_and_rest_before_it():
    s = np.arange(800) * 1e-3
    position, velocity = smooth(s)
    position -= position[0] * [1, 1, 0]
    model = FlexibleBoxModel(BoxParameters(m=0.7, k2=600, b1=20, b2=30))
    prompt = simulate(model, recording(s, position, velocity))["force_y"]
    late = simulate(with_effects(model, time_delay={"delay": 0.04}), recording(s, position, velocity))["force_y"]
    np.testing.assert_allclose(late[:40], 0.0, atol=1e-12)
    np.testing.assert_allclose(late[41:], prompt[1:-40], atol=2e-3 * prompt.std())


@pytest.mark.parametrize(
    ("in_plane", "said"), [("per_axis", "decays more than"), ("vector", "laws that decay too fast")]
)
def test_what_cannot_be_integrated_is_refused_in_one_line(in_plane, said):
    t = uneven_times(50)
    model = with_effects(FlexibleBoxModel(in_plane=in_plane), viscoelastic_relaxation={"k_maxwell": 1e-6, "tau": 1e-5})
    model = with_effects(model, hysteresis={"alpha": 1e-6, "beta": 1e9})
    with pytest.raises(BadInput, match=said):
        simulate(model, recording(t, *smooth(t)))
