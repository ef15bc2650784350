"""Laws of contact and sensor against closed forms, on a Kelvin-Voigt contact whose motion is given."""

import numpy as np
import pytest
from responses import applied

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model import kelvin_voigt
from mmt_drake.model.kelvin_voigt import KelvinVoigt

T = np.arange(2000) * 1e-3
K, B = 300.0, 20.0


def force(position, velocity, load=None, x0=0.0, k=K, b=B, **effects):
    """(n,) reading of the sensor."""
    model = KelvinVoigt(k=k, b=b, x0=x0)
    for name, values in effects.items():
        model = applied(model, name, values)
    out = np.empty(len(T))
    load = np.zeros(len(T)) if load is None else load
    kelvin_voigt.replay(T, position, velocity, load, model.kernel_vector(), out)
    return out


def wave(amplitude=0.02, omega=9.0):
    return amplitude * np.sin(omega * T), amplitude * omega * np.cos(omega * T)


def ramp(speed):
    return speed * T, np.full(len(T), speed)


@pytest.mark.parametrize(("tau", "accuracy"), [(0.3, 1e-9), (0.02, 1e-7), (1e-3, 1e-2)])
def test_a_maxwell_branch_answers_a_sine_as_its_differential_equation_says(tau, accuracy):
    x, v = wave()
    branch = -force(x, v, k=0, b=0, viscoelastic_relaxation={"k_maxwell": 200, "tau": tau})
    w, a = 9.0 * tau, 0.02
    q = a / (1 + w * w) * (np.sin(9 * T) - w * np.cos(9 * T) + w * np.exp(-T / tau))
    np.testing.assert_allclose(branch, 200 * (x - q), atol=accuracy * np.abs(branch).max())


def test_a_held_deflection_relaxes_exponentially():
    s = np.minimum(T / 0.2, 1.0)
    x, v = 0.01 * s * s * (3 - 2 * s), 0.01 * 6 * s * (1 - s) / 0.2
    extra = force(x, v) - force(x, v, viscoelastic_relaxation={"k_maxwell": 200, "tau": 0.15})
    np.testing.assert_allclose(extra[200:], extra[200] * np.exp(-(T[200:] - T[200]) / 0.15), rtol=1e-8)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("viscoelastic_relaxation", {"k_maxwell": 200, "tau": 0.15}),
        ("hardening_relaxation", {"k3_maxwell": 4e6, "tau": 0.15}),
    ],
)
def test_a_recording_that_begins_in_a_press_begins_relaxed(name, values):
    still = np.full(len(T), 0.02), np.zeros(len(T))
    np.testing.assert_allclose(force(*still, x0=0.005, **{name: values}), force(*still, x0=0.005), rtol=1e-12)


def test_of_a_hardening_branch_eight_times_as_much_relaxes_at_twice_the_depth():
    s = np.minimum(T / 0.2, 1.0)
    held = slice(200, None)
    left = []
    for depth in (0.01, 0.02):
        x, v = depth * s * s * (3 - 2 * s), depth * 6 * s * (1 - s) / 0.2
        extra = force(x, v) - force(x, v, hardening_relaxation={"k3_maxwell": 4e6, "tau": 0.15})
        np.testing.assert_allclose(extra[held], extra[200] * np.exp(-(T[held] - T[200]) / 0.15), rtol=1e-8)
        left.append(extra[200])
    assert left[1] == pytest.approx(8.0 * left[0], rel=1e-9)


def test_a_hardening_branch_pressed_at_one_speed_is_what_its_differential_equation_says():
    x, v = ramp(0.05)  # d = u t: d^3 - q = 3 u^3 (tau t^2 - 2 tau^2 t + 2 tau^3 (1 - exp(-t/tau)))
    branch = -force(x, v, k=0, b=0, hardening_relaxation={"k3_maxwell": 4e6, "tau": 0.15})
    tau, u = 0.15, 0.05
    stretch = 3 * u**3 * (tau * T**2 - 2 * tau**2 * T + 2 * tau**3 * (1 - np.exp(-T / tau)))
    np.testing.assert_allclose(branch, 4e6 * stretch, atol=1e-6 * np.abs(branch).max())


def test_hysteresis_loads_exponentially_unloads_as_a_spring_and_saturates():
    x, v = wave(0.05, 4.0)  # up to 1.57 s / 4 it is loaded
    z = -force(x, v, k=0, b=0, hysteresis={"alpha": 100, "beta": 60}) / 100
    top = int(np.pi / 2 / 4.0 / 1e-3)
    np.testing.assert_allclose(z[:top], (1 - np.exp(-2 * 60 * x[:top])) / (2 * 60), atol=1e-8)
    back = slice(top + 1, top + 100)  # gamma = beta: z' = d' while z > 0
    np.testing.assert_allclose(z[back] - z[top + 1], x[back] - x[top + 1], atol=1e-8)
    x, v = ramp(0.3)
    z = -force(x, v, k=0, b=0, hysteresis={"alpha": 100, "beta": 3000, "gamma": 1000, "n": 2}) / 100
    assert z[-1] == pytest.approx(4000**-0.5, rel=1e-6)


def test_a_gap_kills_spring_and_damper_within_it_and_shortens_the_deflection_beyond():
    x, v = wave()
    d = x - 0.003
    beyond = np.abs(d) > 0.002
    expected = np.where(beyond, -K * (d - 0.002 * np.sign(d)) - B * v, 0.0)
    np.testing.assert_allclose(force(x, v, x0=0.003, contact_gap={"gap": 0.004}), expected, atol=1e-12)
    assert beyond.any() and not beyond.all()


def _passed(time: float) -> np.ndarray:
    """0 before and 1 after, by a cubic without slope at its ends within 1 ms before and after."""
    part = np.clip((T - time) / 2e-3 + 0.5, 0.0, 1.0)
    return part**2 * (3.0 - 2.0 * part)


def test_further_springs_and_dampers_are_their_formulas():
    x, v = wave()
    d = x - 0.003
    linear = force(x, v, x0=0.003)
    for name, values, expected in (
        ("nonlinear_stiffness", {"k3": -2e5}, 2e5 * d**3),
        ("hunt_crossley_damping", {"lambda": 30}, -B * v * 30 * np.abs(d)),
        ("stiffness_drift", {"rate": 0.2}, -K * 0.2 * T * d),
        ("stiffness_step", {"time": 0.5005, "loss": 0.4}, K * 0.4 * _passed(0.5005) * d),
    ):
        extra = force(x, v, x0=0.003, **{name: values}) - linear
        np.testing.assert_allclose(extra, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "values", "level"),
    [
        ("coulomb_friction", {"Fc": 0.4}, lambda v, n: 0.4 + 0 * v),
        ("asymmetric_friction", {"Fc_plus": 0.4, "Fc_minus": 0.2}, lambda v, n: np.where(v > 0, 0.4, 0.2)),
        ("static_friction", {"Fs": 0.6, "Fd": 0.4, "v_d": 0.0}, lambda v, n: 0.4 + 0 * v),
        ("stribeck_friction", {"Fs": 0.6, "v_s": 0.03}, lambda v, n: 0.6 * np.exp(-((v / 0.03) ** 2))),
        ("load_dependent_friction", {"mu": 0.3}, lambda v, n: 0.3 * n),
        ("quadratic_drag", {"c": 7.0}, lambda v, n: 7 * v * v),
        ("viscous_friction", {"b": 7.0}, lambda v, n: 7 * np.abs(v)),
    ],
)
def test_friction_under_a_told_velocity_opposes_it_with_its_level(name, values, level):
    x, v = wave()
    load = 2 + np.cos(3 * T)
    extra = force(x, v, load, **{name: values}) - force(x, v, load)
    np.testing.assert_allclose(extra, -np.sign(v) * level(v, load), atol=1e-12)


def test_asymmetric_viscous_friction_takes_the_place_of_the_damper():
    x, v = wave()
    expected = -K * x - np.where(v > 0, 12, 5) * v
    result = force(x, v, asymmetric_viscous_friction={"b_plus": 12, "b_minus": 5})
    np.testing.assert_allclose(result, expected, atol=1e-12)


def test_within_the_stick_band_the_direction_of_sliding_is_kept():
    x, v = wave()
    extra = force(x, v, static_friction={"Fs": 0.6, "Fd": 0.4, "v_d": 0.05}) - force(x, v)
    direction, expected = 0.0, []
    for rate in v:
        direction = np.sign(rate) if abs(rate) > 0.05 else direction
        expected.append(-0.4 * direction)
    np.testing.assert_allclose(extra, expected, atol=1e-12)


def test_bristles_are_a_spring_at_first_and_settle_at_the_level_of_sliding():
    speed, sigma0, sigma1 = 0.02, 800.0, 3.0
    model = applied(KelvinVoigt(), "coulomb_friction", {"Fc": 0.3})
    values = {"sigma0": sigma0, "sigma1": sigma1, "Fs": 0.5, "v_s": 0.04}
    out = np.empty(len(T))
    p = applied(model, "presliding_friction", values).kernel_vector()
    kelvin_voigt.replay(T, *ramp(speed), 0 * T, p, out)
    g = 0.3 + 0.2 * np.exp(-0.25)
    z = g / sigma0 * (1 - np.exp(-sigma0 * speed * T / g))
    np.testing.assert_allclose(out, -(sigma0 * z + sigma1 * (speed - sigma0 * speed / g * z)), atol=1e-6)
    assert out[-1] == pytest.approx(-g, rel=1e-9)


@pytest.mark.parametrize("tau", [1e-6, 0.03, 1e300])
def test_a_lag_is_a_first_order_filter_that_has_settled_at_the_first_sample(tau):
    x, v = ramp(0.05)
    ideal = -B * 0.05 - K * 0.05 * T
    lagging = ideal[0] - K * 0.05 * (T + tau * np.expm1(-T / tau))
    np.testing.assert_allclose(force(x, v, force_lag={"tau": tau}), lagging, atol=1e-11)


@pytest.mark.parametrize(("every", "off"), [(1, 0.011), (2, 2e-4), (4, 5e-4)])
def test_a_mass_at_the_tip_takes_its_inertia_from_the_reading(every, off):
    # At 1 kHz the slope is that of 1.1 ms ago, at 500 and 250 Hz that of now.
    x, v = (np.ascontiguousarray(signal[::every]) for signal in wave())
    t, load, inertia = T[::every], np.zeros(len(x)), 0.3 * -(9.0**2) * x
    read = [np.empty(len(x)) for _ in range(2)]
    for mass, out in zip((0.0, 0.3), read, strict=True):
        p = applied(KelvinVoigt(k=K, b=B), "tip_mass", {"m_tip": mass}).kernel_vector()
        kelvin_voigt.replay(t, x, v, load, p, out)
    wrong = np.abs(read[1] - read[0] + inertia)[10:]
    assert wrong.max() < off * 0.3 * 9.0**2 * 0.02


def test_what_a_sensor_adds_comes_after_its_lag_and_before_its_range():
    x, v = wave()
    load = 2 + np.cos(3 * T)
    effects = {
        "force_saturation": {"limit": 2.0},
        "force_bias": {"bias": 0.3},
        "force_drift": {"rate": -0.1},
        "force_crosstalk": {"gain": 0.2},
        "periodic_disturbance": {"amplitude": 0.5, "frequency": 3.0, "phase": 0.7},
    }
    added = 0.3 - 0.1 * T + 0.2 * load + 0.5 * np.sin(2 * np.pi * 3 * T + 0.7)
    np.testing.assert_allclose(force(x, v, load, **effects), np.clip(force(x, v) + added, -2, 2), atol=1e-12)
    lagging = force(x, v, force_lag={"tau": 0.02})
    expected = np.clip(lagging + added, -2, 2)
    np.testing.assert_allclose(force(x, v, load, **effects, force_lag={"tau": 0.02}), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("of", "expected"),
    [
        ("sliding_velocity", lambda curve, x, v, n, f: -curve(v)),
        ("load", lambda curve, x, v, n, f: -np.sign(v) * curve(n)),
        ("deflection", lambda curve, x, v, n, f: -curve(x)),
        ("deflection_rate", lambda curve, x, v, n, f: -curve(v)),
        ("time", lambda curve, x, v, n, f: curve(T)),
        ("force", lambda curve, x, v, n, f: curve(f)),
        ("normal_force", lambda curve, x, v, n, f: curve(n)),
    ],
)
def test_a_table_is_read_linearly_and_held_at_its_ends(of, expected):
    signals = {"sliding_velocity": 0.18, "deflection": 0.02, "deflection_rate": 0.18, "time": 2, "force": 8}
    at = signals.get(of, 3.0) * np.array([-0.7, -0.2, 0.1, 0.3, 0.8])
    value = np.array([0.2, 0.4, 0.1, 0.9, 0.3])
    x, v = wave()
    load = 1.5 + 1.4 * np.cos(3 * T)
    plain = force(x, v, load)
    table = {"of": of, "at": list(at), "value": list(value)}
    extra = force(x, v, load, tabulated_force=table) - plain
    curve = lambda signal: np.interp(signal, at, value)  # noqa: E731
    np.testing.assert_allclose(extra, expected(curve, x, v, load, plain), atol=1e-12)


def test_only_a_spring_that_is_there_softens():
    softening = {"k3": -1e3}
    assert LIBRARY["nonlinear_stiffness"].checked(softening, KelvinVoigt(k=K, b=B), "") == softening
    with pytest.raises(BadInput, match="k3: found -1000, expected 0 or more"):
        LIBRARY["nonlinear_stiffness"].checked(softening, KelvinVoigt(b=B), "effects")
