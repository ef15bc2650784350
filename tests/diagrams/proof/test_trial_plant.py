"""The trial's engine: closed forms, and an independent adaptive integration."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from trial_plant_samples import BASE, DEPTH, Array, ramp, run, sine

from mmt_drake.diagrams.proof.trial.laws import Concealed


@pytest.mark.parametrize("hertz", [0.5, 2.0, 5.0])
@pytest.mark.parametrize("k1", [0.0, 150.0])
def test_the_linear_object_answers_a_sine_as_its_transfer_function(hertz: float, k1: float) -> None:
    cycles = math.ceil(4.0 * hertz) / hertz
    motion = sine(0.02, hertz, 2.0 * cycles)
    force, _ = run(motion, k1=k1)
    late = motion.time >= cycles
    w, t = 2.0 * math.pi * hertz, motion.time[late]
    found = np.linalg.lstsq(np.column_stack([np.sin(w * t), np.cos(w * t)]), force[late], rcond=None)[0]
    m, k2, b1, b2, s = BASE["m"], BASE["k2"], BASE["b1"], BASE["b2"], 1j * w
    exact = -0.02 * (m * s**2 + b1 * s + k1) * (k2 + b2 * s) / (m * s**2 + (b1 + b2) * s + k1 + k2)
    assert found[0] + 1j * found[1] == pytest.approx(exact, rel=2e-5)


STEADY = [
    ("viscous_friction", {"b": 7.0}, lambda v: 27.0 * v + math.copysign(0.4, v)),
    (
        "asymmetric_viscous_friction",
        {"b_plus": 30.0, "b_minus": 10.0},
        lambda v: 30.0 * v + 0.4 if v > 0 else 10.0 * v - 0.4,
    ),
    ("coulomb_friction", {"Fc": 0.3}, lambda v: 20.0 * v + math.copysign(0.7, v)),
    ("asymmetric_friction", {"Fc_plus": 0.5, "Fc_minus": 0.2}, lambda v: 20.0 * v + (0.5 if v > 0 else -0.2)),
    ("static_friction", {"Fs": 0.9, "Fd": 0.3, "v_d": 0.004}, lambda v: 20.0 * v + math.copysign(0.3, v)),
    (
        "stribeck_friction",
        {"Fs": 0.9, "v_s": 0.03},
        lambda v: 20.0 * v + math.copysign(0.4 + 0.5 * math.exp(-((v / 0.03) ** 2)), v),
    ),
    (
        "presliding_friction",
        {"sigma0": 3e3, "Fs": 0.6, "v_s": 0.03},
        lambda v: 20.0 * v + math.copysign(0.4 + 0.2 * math.exp(-((v / 0.03) ** 2)), v),
    ),
    ("load_dependent_friction", {"mu": 0.1}, lambda v: 20.0 * v + math.copysign(0.4 + 0.1 * 400.0 * DEPTH, v)),
    ("quadratic_drag", {"c": 40.0}, lambda v: 20.0 * v + math.copysign(0.4, v) + 40.0 * v * abs(v)),
    ("constant_force", {"F": 0.3}, lambda v: 20.0 * v + math.copysign(0.4, v) - 0.3),
]


@pytest.mark.parametrize("speed", [0.04, -0.04])
@pytest.mark.parametrize(("name", "values", "resistance"), STEADY, ids=[row[0] for row in STEADY])
def test_a_body_drawn_at_constant_speed_resists_as_the_contract_says(
    name: str, values: dict[str, float], resistance: Callable[[float], float], speed: float
) -> None:
    force, body = run(ramp(speed, 2.0), Concealed(name, values), Fc=0.4)
    assert body[-1, 1] == pytest.approx(speed, rel=1e-6)
    assert force[-1] == pytest.approx(-resistance(speed), rel=1e-5)


def test_off_contact_the_body_keeps_its_velocity_and_coulomb_friction_stops_it_after_its_kinetic_energy() -> None:
    motion = ramp(0.1, 3.0)
    lifted = motion.time >= 1.5
    motion.position[lifted, 2] = 0.01
    force, body = run(motion, b1=0.0, Fc=0.2)
    first = int(np.argmax(lifted))
    x, v = body[first]
    assert v == pytest.approx(0.1, rel=5e-3)
    assert np.all(force[first:] == 0.0)
    assert body[-1, 1] == 0.0
    assert body[-1, 0] - x == pytest.approx(0.5 * BASE["m"] * v**2 / 0.2, rel=1e-3)


def test_a_body_that_friction_holds_gives_the_force_of_spring_and_damper_alone() -> None:
    motion = sine(0.001, 1.0, 2.0)
    force, body = run(motion, Fc=2.0)
    exact = -BASE["k2"] * motion.position[:, 1] - BASE["b2"] * motion.velocity[:, 1]
    assert np.all(body == 0.0)
    assert np.max(np.abs(force - exact)) < 1e-9


def test_static_friction_lets_go_at_its_break_away_level() -> None:
    speed = 0.005
    force, body = run(ramp(speed, 1.0), Concealed("static_friction", {"Fs": 1.2, "Fd": 0.4, "v_d": 0.002}))
    still = body[:, 1] == 0.0
    last = int(np.argmin(still)) - 1
    assert -force[last] == pytest.approx(1.2, abs=BASE["k2"] * speed * 2e-3)
    assert np.min(force) > -1.21


def test_touch_starts_the_contact_spring_unstretched_wherever_the_body_is() -> None:
    motion = ramp(0.05, 2.0)
    away = (motion.time > 0.8) & (motion.time < 1.2)
    motion.position[away, 2] = 0.01
    force, body = run(motion, b1=5.0)
    touch = int(np.flatnonzero(away)[-1]) + 1
    d_rate = 0.05 - body[touch, 1]
    assert abs(motion.position[touch, 1] - body[touch, 0]) > 1e-3
    assert -force[touch] == pytest.approx(BASE["b2"] * d_rate, abs=BASE["k2"] * 0.05 * 1e-3)


def test_a_touch_between_samples_is_located() -> None:
    """The height crosses zero in the middle of a sample: where the spring starts is where the probe was then."""
    motion = ramp(0.2, 0.1)
    z = 0.01 - 0.4 * (motion.time - 0.0005)
    motion.position[:, 2], motion.velocity[:, 2] = z, -0.4
    force, _ = run(motion, Fc=100.0, b2=0.0)
    crossing = 0.0005 + 0.01 / 0.4
    after = motion.time > crossing
    assert force[after] == pytest.approx(-BASE["k2"] * 0.2 * (motion.time[after] - crossing), abs=1e-6)


# What is smooth, integrated once more: scipy, adaptive, and equations written down from the contract.
Rates = Callable[[float, Array, float, float], tuple[float, float, list[float]]]


def _second_mode(t: float, y: Array, d: float, d_rate: float) -> tuple[float, float, list[float]]:
    pull = 80.0 * (y[2] - y[0]) + 2.0 * (y[3] - y[1])
    return 0.0, pull, [y[3], -pull / 0.3]


def _hysteresis(t: float, y: Array, d: float, d_rate: float) -> tuple[float, float, list[float]]:
    return 200.0 * y[2], 0.0, [d_rate - 100.0 * abs(d_rate) * y[2] - 100.0 * d_rate * abs(y[2])]


SMOOTH: list[tuple[str, dict[str, float], int, Rates]] = [
    ("nonlinear_stiffness", {"k3": 2e6}, 0, lambda t, y, d, r: (2e6 * d**3, 0.0, [])),
    ("hunt_crossley_damping", {"lambda": 80.0}, 0, lambda t, y, d, r: (25.0 * r * 80.0 * abs(d), 0.0, [])),
    ("viscoelastic_relaxation", {"k_maxwell": 300.0, "tau": 0.1}, 1,
     lambda t, y, d, r: (300.0 * (d - y[2]), 0.0, [(d - y[2]) / 0.1])),
    ("hysteresis", {"alpha": 200.0, "beta": 100.0}, 1, _hysteresis),
    ("stiffness_drift", {"rate": 0.2}, 0, lambda t, y, d, r: (500.0 * 0.2 * t * d, 0.0, [])),
    ("ground_spring", {"k": 90.0}, 0, lambda t, y, d, r: (0.0, -90.0 * y[0], [])),
    ("second_mode", {"m2": 0.3, "k": 80.0, "b": 2.0}, 2, _second_mode),
    ("end_stop", {"position": 0.01, "stiffness": 900.0, "side": 1.0}, 0,
     lambda t, y, d, r: (0.0, -900.0 * max(y[0] - 0.01, 0.0), [])),
    ("end_stop", {"position": -0.01, "stiffness": 900.0, "side": -1.0}, 0,
     lambda t, y, d, r: (0.0, 900.0 * max(-0.01 - y[0], 0.0), [])),
    ("contact_gap", {"gap": 0.004}, 0,
     lambda t, y, d, r: (-500.0 * math.copysign(0.002, d) if abs(d) > 0.002 else -500.0 * d - 25.0 * r, 0.0, [])),
    ("torque_ripple", {"amplitude": 0.6, "period": 0.02, "phase": 1.0}, 0,
     lambda t, y, d, r: (0.0, 0.6 * math.sin(2.0 * math.pi * y[0] / 0.02 + 1.0), [])),
    ("stiffness_step", {"loss": 0.3, "time": 0.7}, 0, lambda t, y, d, r: (-150.0 * d if t >= 0.7 else 0.0, 0.0, [])),
    ("frictional_heating", {"power": 0.05, "tau": 2.0}, 1,
     lambda t, y, d, r: (0.0, 20.0 * (1.0 - math.exp(-y[2])) * y[1],
                         [(20.0 * math.exp(-y[2]) * y[1] ** 2 / 0.05 - y[2]) / 2.0])),
    ("run_in_softening", {"loss": 0.5, "distance": 0.05}, 1,
     lambda t, y, d, r: (-250.0 * (1.0 - math.exp(-y[2] / 0.05)) * d, 0.0, [abs(y[1])])),
]  # fmt: skip


@pytest.mark.parametrize(("name", "values", "extra", "rates"), SMOOTH, ids=[f"{r[0]}{i}" for i, r in enumerate(SMOOTH)])
def test_a_smooth_effect_gives_what_an_adaptive_integration_of_the_contract_s_words_gives(
    name: str, values: dict[str, float], extra: int, rates: Rates
) -> None:
    motion = sine(0.03, 1.3, 1.5)
    force, body = run(motion, Concealed(name, values))
    w = 2.0 * math.pi * 1.3

    def deflection(t: float, y: Array) -> tuple[float, float]:
        return 0.03 * math.sin(w * t) - y[0], 0.03 * w * math.cos(w * t) - y[1]

    def rhs(t: float, y: Array) -> list[float]:
        d, d_rate = deflection(t, y)
        contact, on_body, memory = rates(t, y, d, d_rate)
        push = BASE["k2"] * d + BASE["b2"] * d_rate + contact
        return [y[1], (push - BASE["b1"] * y[1] + on_body) / BASE["m"], *memory]

    exact = solve_ivp(rhs, (0.0, 1.5), np.zeros(2 + extra), t_eval=motion.time, rtol=1e-7, atol=1e-10, max_step=5e-3)
    pushed = []
    for t, y in zip(exact.t, exact.y.T, strict=True):
        d, d_rate = deflection(t, y)
        pushed.append(BASE["k2"] * d + BASE["b2"] * d_rate + rates(t, y, d, d_rate)[0])
    assert np.sqrt(np.mean((body[:, 0] - exact.y[0]) ** 2)) < 2e-4 * np.std(body[:, 0])
    assert np.sqrt(np.mean((force + pushed) ** 2)) < 2e-3 * np.std(force)


def test_a_change_of_mass_changes_the_inertia_and_leaves_the_velocity_continuous() -> None:
    motion = sine(0.03, 2.0, 2.0)
    light, _ = run(motion)
    heavy, _ = run(motion, m=0.9)
    changed, body = run(motion, Concealed("mass_change", {"time": 1.0, "dm": 0.4}))
    before, late = motion.time < 1.0, motion.time > 1.8
    assert np.array_equal(changed[before], light[before])
    assert changed[late] == pytest.approx(heavy[late], abs=1e-3 * np.std(heavy))
    assert np.max(np.abs(np.diff(body[:, 1]))) < 1.2 * np.max(np.abs(np.diff(run(motion)[1][:, 1])))


# Outside the library.
def test_a_slipping_probe_feels_no_more_than_friction_at_its_tip_gives() -> None:
    force, _ = run(sine(0.02, 0.5, 4.0), Concealed("probe_slip", {"mu": 0.3}), Fc=100.0, b2=0.0)
    assert np.max(np.abs(force)) == pytest.approx(0.3 * 400.0 * DEPTH, rel=1e-6)


def test_a_loose_part_takes_momentum_and_no_more_energy_than_its_restitution_allows() -> None:
    effect = Concealed("loose_mass", {"m": 0.3, "clearance": 0.004, "restitution": 0.5})
    motion = ramp(0.1, 1.0)
    _, body = run(motion, effect, b1=0.0, b2=0.0, k2=0.0)
    assert np.all(body == 0.0)  # nothing pulls, nothing moves
    _, rattling = run(motion, effect)
    _, alone = run(motion)
    hit = int(np.argmax(np.abs(rattling[:, 1] - alone[:, 1]) > 1e-9))
    assert rattling[hit - 1, 0] == pytest.approx(0.004, abs=2e-4)
    drop = rattling[hit - 1, 1] - rattling[hit, 1]
    assert drop == pytest.approx(1.5 * 0.3 / 0.8 * rattling[hit - 1, 1], rel=0.1)


def test_the_longer_it_rests_the_harder_it_breaks_away() -> None:
    """From rest the age is 1 s and grows with time; friction is F ln(1 + age / time)."""
    effect = Concealed("ageing_friction", {"F": 0.2, "time": 0.02, "distance": 0.004})
    for speed in (0.002, 0.02):
        force, body = run(ramp(speed, 2.0), effect)
        last = int(np.argmin(body[:, 1] == 0.0)) - 1
        level = 0.2 * math.log(1.0 + (1.0 + last * 1e-3) / 0.02)
        assert -force[last] == pytest.approx(level, abs=BASE["k2"] * speed * 2e-3)


def test_a_shaking_table_carries_a_body_that_nothing_else_holds() -> None:
    effect = Concealed("table_vibration", {"amplitude": 1e-3, "frequency": 3.0, "rate": 0.0})
    motion = ramp(0.0, 2.0)
    _, body = run(motion, effect, k2=0.0, b2=0.0, Fc=50.0)
    w = 2.0 * math.pi * 3.0
    assert body[1:, 1] == pytest.approx(1e-3 * w * np.cos(w * motion.time[1:]), abs=2e-5)
