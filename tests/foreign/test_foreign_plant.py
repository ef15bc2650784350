"""The foreign object against closed forms, an adaptive integration of equations written down again, a finer step."""

import ast
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mmt_drake.errors import BadInput
from mmt_drake.foreign import plant
from mmt_drake.foreign.numbers import Numbers

Array = np.ndarray
LINEAR = Numbers(m=0.8, k1=0.0, k2=500.0, b1=20.0, b2=30.0, normal_k=400.0, normal_b=8.0)
DEPTH, SAMPLE = 0.008, 1e-4  # samples so near each other that the way between them is no matter


def times(duration: float) -> Array:
    return np.arange(round(duration / SAMPLE) + 1) * SAMPLE


def motion(t: Array, x: tuple[Array, Array], y: tuple[Array, Array]) -> Array:
    """(n, 6) of a probe at the depth `DEPTH`, from position and velocity along x and y."""
    still = np.zeros_like(t)
    return np.column_stack([x[0] + still, y[0] + still, still - DEPTH, x[1] + still, y[1] + still, still])


def sines(t: Array) -> Array:
    """Both axes at once, from rest to rest in neither."""
    return motion(
        t,
        (0.012 * np.sin(11.0 * t), 0.132 * np.cos(11.0 * t)),
        (0.02 * (1.0 - np.cos(7.0 * t)), 0.14 * np.sin(7.0 * t)),
    )


def run(t: Array, probe: Array, numbers: Numbers, step: float = plant.STEP_S) -> tuple[Array, Array]:
    """Force on the probe and the body's motion at the samples."""
    substeps = round((t[1] - t[0]) / step)
    forces, body = np.empty(((len(t) - 1) * substeps + 1, 3)), np.empty((len(t), 4))
    plant.run(t, probe, numbers.checked(step), substeps, forces, body)
    return forces[::substeps], body


def test_no_physics_is_shared_with_the_model_or_with_the_trial_s_own_plant(checkout: Path) -> None:
    for source in (checkout / "mmt_drake" / "foreign").glob("*.py"):
        tree = ast.parse(source.read_text())
        used = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        ours = {f"{name}".split(".")[1] for name in used if f"{name}".startswith("mmt_drake.")}
        assert ours <= {"errors", "foreign", "numeric", "quantities"}


@pytest.mark.parametrize("hertz", [0.5, 2.0, 5.0])
@pytest.mark.parametrize("k1", [0.0, 150.0])
def test_without_friction_it_answers_a_sine_as_its_transfer_function(hertz: float, k1: float) -> None:
    cycles = math.ceil(4.0 * hertz) / hertz
    t, w = times(1.5 * cycles), 2.0 * math.pi * hertz
    stroke = 0.02 * np.sin(w * t), 0.02 * w * np.cos(w * t)
    force, _ = run(t, motion(t, stroke, (0.5 * stroke[0], 0.5 * stroke[1])), LINEAR._replace(k1=k1))
    late = t >= cycles
    fitted = np.linalg.lstsq(np.column_stack([np.sin(w * t), np.cos(w * t)])[late], force[late, :2], rcond=None)[0]
    p, s = LINEAR, 1j * w
    exact = -0.02 * (p.m * s**2 + p.b1 * s + k1) * (p.k2 + p.b2 * s)
    exact /= p.m * s**2 + (p.b1 + p.b2) * s + k1 + p.k2
    assert fitted[0] + 1j * fitted[1] == pytest.approx([exact, 0.5 * exact], rel=2e-5)
    assert force[:, 2] == pytest.approx(LINEAR.normal_k * DEPTH)


def test_a_body_drawn_along_a_diagonal_resists_with_one_level_in_norm() -> None:
    t, speed = times(1.0), 0.05
    stroke = speed / math.sqrt(2.0) * t, speed / math.sqrt(2.0)
    force, _ = run(t, motion(t, stroke, stroke), LINEAR._replace(Fs=0.5, Fd=0.5))
    assert math.hypot(*force[-1, :2]) == pytest.approx(LINEAR.b1 * speed + 0.5, rel=1e-6)
    assert force[-1, 0] == pytest.approx(force[-1, 1], rel=1e-9)


def test_on_a_circle_friction_points_against_the_velocity_wherever_the_body_is() -> None:
    t, w = times(3.0), 2.0 * math.pi
    probe = motion(
        t, (0.03 * np.cos(w * t), -0.03 * w * np.sin(w * t)), (0.03 * np.sin(w * t), 0.03 * w * np.cos(w * t))
    )
    numbers = LINEAR._replace(Fs=0.6, Fd=0.6)
    force, body = run(t, probe, numbers)
    late = t > 2.0
    v = body[:, 2:]
    acceleration = np.gradient(v, SAMPLE, axis=0)
    friction = (-force[:, :2] - LINEAR.b1 * v - LINEAR.m * acceleration)[late]  # on the table
    along = v[late] / np.linalg.norm(v[late], axis=1, keepdims=True)
    assert friction == pytest.approx(0.6 * along, abs=1e-3)


@pytest.mark.parametrize("Fs", [0.5, 1.2])
def test_a_body_that_is_held_gives_less_than_a_micrometre_and_breaks_away_by_the_norm(Fs: float) -> None:
    t, speed = times(1.0), 0.005
    stroke = 0.6 * speed * t, 0.6 * speed
    force, body = run(t, motion(t, stroke, (stroke[0] / 0.75, stroke[1] / 0.75)), LINEAR._replace(Fs=Fs, Fd=0.4))
    pulled = np.linalg.norm(force[:, :2], axis=1)
    breaks = int(np.argmax(pulled > Fs - 2e-3))
    way = np.linalg.norm(body[:, :2], axis=1)
    assert np.max(pulled) == pytest.approx(Fs, abs=2e-3)
    assert way[breaks] < 1e-6 and way[breaks + 1000] > 1e-5


def test_off_contact_friction_stops_it_after_its_kinetic_energy() -> None:
    t = times(2.0)
    probe = motion(t, (0.06 * t, 0.06), (0.08 * t, 0.08))
    probe[t >= 1.0, 2] = 0.01
    force, body = run(t, probe, LINEAR._replace(b1=0.0, Fs=0.2, Fd=0.2))
    first = int(np.argmax(t >= 1.0))
    assert np.all(force[first:] == 0.0)
    assert np.linalg.norm(body[-1, 2:]) < 1e-6
    way = np.linalg.norm(body[-1, :2] - body[first, :2])
    assert way == pytest.approx(0.5 * LINEAR.m * np.linalg.norm(body[first, 2:]) ** 2 / 0.2, rel=1e-3)


def test_what_the_probe_puts_in_is_stored_or_dissipated_friction_taking_its_level_times_the_way() -> None:
    t = times(3.0)
    probe, p = sines(t), LINEAR._replace(k1=80.0, Fs=0.7, Fd=0.5)
    force, body = run(t, probe, p)
    v = body[:, 2:]
    apart = probe[:, :2] - probe[0, :2] - body[:, :2]
    rates = -np.sum(force[:, :2] * probe[:, 3:5], axis=1)
    rates -= p.b1 * np.sum(v**2, axis=1) + p.b2 * np.sum((probe[:, 3:5] - v) ** 2, axis=1)
    put_in = np.trapezoid(rates, t)
    stored = 0.5 * (p.m * v[-1] @ v[-1] + p.k1 * body[-1, :2] @ body[-1, :2] + p.k2 * apart[-1] @ apart[-1])
    by_friction = p.Fd * np.sum(np.linalg.norm(np.diff(body[:, :2], axis=0), axis=1))
    assert put_in - stored == pytest.approx(by_friction, rel=2e-3)


def test_the_step_is_short_enough_for_friction_that_sticks_and_slips_in_the_plane() -> None:
    t = times(1.0)
    probe, p = sines(t), LINEAR._replace(Fs=0.9, Fd=0.5)
    force, _ = run(t, probe, p)
    finer, _ = run(t, probe, p, plant.STEP_S / 10.0)
    assert np.sqrt(np.mean((force - finer) ** 2)) < 1e-3
    assert np.max(np.abs(force - finer)) < 0.02


def test_a_touch_starts_the_contact_spring_unstretched_below_the_surface_s_own_height() -> None:
    t = times(0.5)
    probe = motion(t, (0.05 * t, 0.05), (0.0 * t, 0.0))
    probe[:, 2], probe[:, 5] = 0.003 - 0.01 * t, -0.01
    force, _ = run(t, probe, LINEAR._replace(surface=-0.001, Fs=50.0, Fd=50.0))
    touches = t > 0.402  # until then the slider's spring rings
    assert np.all(force[t < 0.3999] == 0.0)
    spring = -LINEAR.k2 * 0.05 * (t - 0.4) - LINEAR.b2 * 0.05
    assert force[touches, 0] == pytest.approx(spring[touches], abs=1e-3)
    assert force[touches, 2] == pytest.approx(0.08 + LINEAR.normal_k * 0.01 * (t[touches] - 0.4), abs=1e-9)


# Each law once more along the diagonal: one axis, written down from the contract, and an adaptive integration.
# rates(t, deflection, its rate, x, v, memory) -> force of the contact, force on the body, rates of the memory, mass.
Law = Callable[[float, float, float, float, float, Array], tuple[float, float, list[float], float]]
P = LINEAR
LAWS: dict[str, tuple[Numbers, int, Law]] = {
    "drag": (P._replace(c=40.0), 0, lambda t, d, u, x, v, q: (0.0, -40.0 * v * abs(v), [], P.m)),
    "cubic spring": (P._replace(k3=1e6), 0, lambda t, d, u, x, v, q: (1e6 * d**3, 0.0, [], P.m)),
    "Hunt-Crossley": (
        P._replace(hunt_crossley=300.0),
        0,
        lambda t, d, u, x, v, q: (P.b2 * 300.0 * abs(d) * u, 0.0, [], P.m),
    ),
    "Maxwell": (
        P._replace(k_maxwell=200.0, tau=0.1),
        1,
        lambda t, d, u, x, v, q: (200.0 * (d - q[0]), 0.0, [(d - q[0]) / 0.1], P.m),
    ),
    "Bouc-Wen": (
        P._replace(alpha=300.0, beta=500.0, gamma=400.0),
        1,
        lambda t, d, u, x, v, q: (300.0 * q[0], 0.0, [u - 500.0 * abs(u) * q[0] - 400.0 * u * abs(q[0])], P.m),
    ),
    "LuGre": (
        P._replace(sigma0=3e3, Fs=0.6, Fd=0.4, v_s=0.03),
        1,
        lambda t, d, u, x, v, q: (
            0.0,
            -3e3 * q[0],
            [v - 3e3 * abs(v) * q[0] / (0.4 + 0.2 * math.exp(-((v / 0.03) ** 2)))],
            P.m,
        ),
    ),
    "second mode": (
        P._replace(mode_m=0.5, mode_k=200.0, mode_b=2.0),
        2,
        lambda t, d, u, x, v, q: (
            0.0,
            200.0 * (q[0] - x) + 2.0 * (q[1] - v),
            [q[1], (200.0 * (x - q[0]) + 2.0 * (v - q[1])) / 0.5],
            P.m,
        ),
    ),
    "ground spring from a time on": (
        P._replace(ground_k=150.0, ground_time=0.6),
        0,
        lambda t, d, u, x, v, q: (0.0, -150.0 * x if t >= 0.6 else 0.0, [], P.m),
    ),
    "mass from a time on": (
        P._replace(dm=0.8, mass_time=0.6),
        0,
        lambda t, d, u, x, v, q: (0.0, 0.0, [], 1.6 if t >= 0.6 else 0.8),
    ),
    "k2 from a time on": (
        P._replace(step_loss=-0.3, step_time=0.6),
        0,
        lambda t, d, u, x, v, q: (0.3 * P.k2 * d if t >= 0.6 else 0.0, 0.0, [], P.m),
    ),
}


@pytest.mark.parametrize("name", LAWS)
def test_a_law_is_that_of_an_adaptive_integration(name: str) -> None:
    numbers, memories, law = LAWS[name]

    def probe(t: float) -> tuple[float, float]:
        return 0.02 * (1.0 - math.cos(9.0 * t)), 0.18 * math.sin(9.0 * t)

    def felt(t: float, state: Array) -> tuple[float, float, list[float], float]:
        (s, s_rate), (x, v), q = probe(t), state[:2], state[2:]
        more, on_body, rates, mass = law(t, s - x, s_rate - v, x, v, q)
        return P.k2 * (s - x) + P.b2 * (s_rate - v) + more, on_body, rates, mass

    def rates(t: float, state: Array) -> list[float]:
        contact, on_body, memory, mass = felt(t, state)
        return [state[1], (contact + on_body - P.b1 * state[1]) / mass, *memory]

    t = times(1.2)
    solution = solve_ivp(rates, (0.0, t[-1]), np.zeros(2 + memories), t_eval=t, rtol=1e-9, atol=1e-11, max_step=2e-3)
    expected = np.array([felt(at, state)[0] for at, state in zip(t, solution.y.T, strict=True)])
    along = np.array([probe(at) for at in t]).T / math.sqrt(2.0)
    force, body = run(t, motion(t, (along[0], along[1]), (along[0], along[1])), numbers)
    jump = np.abs(t - 0.6) < 2e-4
    assert -np.sum(force[~jump, :2], axis=1) / math.sqrt(2.0) == pytest.approx(expected[~jump], abs=2e-3)
    assert body[:, 0] == pytest.approx(solution.y[0] / math.sqrt(2.0), abs=2e-6)


def test_a_wall_stands_across_either_axis_by_itself() -> None:
    t = times(2.0)
    probe = motion(t, (0.02 * t, 0.02), (0.01 * t, 0.01))
    force, body = run(t, probe, LINEAR._replace(stop_position=0.015, stop_stiffness=1e5))
    x, y = body[-1, :2]
    assert x == pytest.approx(0.015, abs=2e-4) and y > 0.015 - 2e-4
    assert -force[-1, 0] == pytest.approx(1e5 * (x - 0.015) + LINEAR.b1 * body[-1, 2], rel=1e-2)


def test_a_body_too_light_for_the_step_is_refused() -> None:
    with pytest.raises(BadInput, match="m: found 1e-06 on springs of 500"):
        Numbers(m=1e-6).checked(plant.STEP_S)
