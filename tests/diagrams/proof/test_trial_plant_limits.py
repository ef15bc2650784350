"""The trial's engine in its limits: laws that vanish, energy, finer steps, the model that it shares no code with."""

import numpy as np
import pytest
from trial_plant_samples import BASE, VANISHED, run, sine

from mmt_drake.diagrams.proof.trial.laws import LAWS, Concealed, linear_object, with_effects
from mmt_drake.diagrams.proof.trial.motions import draw_motion
from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.diagrams.proof.trial.plant import STEP_S
from mmt_drake.diagrams.proof.trial.sensor import Sensor
from mmt_drake.diagrams.proof.trial.session import tangential_readings
from mmt_drake.model_files import parse_model
from mmt_drake.recording import Recording
from mmt_drake.simulation import simulate

OF_OTHER_OBJECTS = ("surface_shape", "stiffness_map", "tool_offset", "hardening_relaxation", "input_lag")
"""What only maps, materials and driven bodies have concealed; their laws are tested beside their objects."""
OF_A_BOX = [
    name
    for name, law in LAWS.items()
    if law.block != "drive"
    and name not in (*OF_OTHER_OBJECTS, "presliding_friction")  # this one vanishes as it stiffens
]


@pytest.mark.parametrize("name", OF_A_BOX)
def test_an_effect_at_its_vanishing_value_changes_nothing(name: str) -> None:
    motion = draw_motion(np.random.default_rng(3), duration=10.0)
    without, _ = run(motion, Fc=0.3)
    force, _ = run(motion, Concealed(name, VANISHED[name]), Fc=0.3)
    assert np.array_equal(force, without)


def test_stiff_bristles_are_coulomb_friction() -> None:
    motion = draw_motion(np.random.default_rng(3), duration=10.0)
    coulomb, _ = run(motion, Fc=0.3)
    bristles, _ = run(motion, Concealed("presliding_friction", {"sigma0": 1e6}), Fc=0.3)
    assert np.sqrt(np.mean((bristles - coulomb) ** 2)) < 5e-3 * np.std(coulomb)


PASSIVE = {
    "static_friction": {"Fs": 0.9, "Fd": 0.3, "v_d": 0.005},
    "presliding_friction": {"sigma0": 2e3},
    "viscoelastic_relaxation": {"k_maxwell": 300.0, "tau": 0.1},
    "hysteresis": {"alpha": 300.0, "beta": 100.0},
    "contact_gap": {"gap": 0.003},
    "second_mode": {"m2": 0.3, "k": 100.0, "b": 1.0},
    "end_stop": {"position": 0.005, "stiffness": 900.0, "side": 1.0},
    "hunt_crossley_damping": {"lambda": 100.0},
    "loose_mass": {"m": 0.2, "clearance": 0.005, "restitution": 0.5},
    "probe_slip": {"mu": 0.4},
    "rough_patch": {"F": 0.8, "from": -0.01, "to": 0.01},
}


@pytest.mark.parametrize("name", PASSIVE)
def test_a_passive_object_never_gives_back_more_energy_than_it_was_given(name: str) -> None:
    motion = sine(0.03, 0.9, 6.0)
    force, _ = run(motion, Concealed(name, PASSIVE[name]), Fc=0.1, b1=2.0)
    absorbed = np.cumsum(-force * motion.velocity[:, 1]) * 1e-3
    assert np.min(absorbed) > -1e-3 * absorbed[-1]


NOMINAL = [({"k1": 120.0}, []), ({"Fc": 0.4}, []), ({}, [("static_friction", {"Fs": 0.9, "Fd": 0.4, "v_d": 0.004})])]


@pytest.mark.parametrize(("changes", "effects"), NOMINAL)
def test_it_agrees_with_the_model_that_it_shares_no_code_with(
    changes: dict[str, float], effects: list[tuple[str, dict[str, float]]]
) -> None:
    motion = draw_motion(np.random.default_rng(11), duration=10.0)
    base = {**BASE, **changes}
    force, _ = run(motion, *(Concealed(*effect) for effect in effects), **changes)
    model = parse_model(
        {
            "structure": "flexible_box",
            "parameters": {name: base[name] for name in ("m", "k1", "k2", "b1", "b2", "Fc")},
            "normal": {"k": base["normal_k"], "b": base["normal_b"]},
            "effects": [{"name": name, "parameters": values} for name, values in effects],
        }
    )
    columns = {f"position_{axis}": motion.position[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"velocity_{axis}": motion.velocity[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"force_{axis}": np.zeros(len(motion.time)) for axis in "xyz"}
    simulated = simulate(model, Recording(motion.time, columns))["force_y"]
    assert np.sqrt(np.mean((force - simulated) ** 2)) < 1e-4 * np.std(simulated)


def test_the_default_physics_is_the_linear_object_and_nothing_else() -> None:
    physics = linear_object({**BASE, "b1": 0.0})
    assert physics == Physics(m=0.5, k2=500.0, b2=25.0, normal_k=400.0, normal_b=8.0)


def test_finer_steps_change_a_recording_by_much_less_than_its_noise() -> None:
    """Stick and slip, and the edges of a clearance, are what a time-stepping scheme finds hardest."""
    motion = draw_motion(np.random.default_rng(2), duration=10.0)
    for effect in (
        Concealed("static_friction", {"Fs": 0.9566, "Fd": 0.1858, "v_d": 0.009}),
        Concealed("contact_gap", {"gap": 0.0014}),
    ):
        base = {**BASE, "k1": 166.6, "b1": 34.8, "b2": 39.69, "Fc": 0.1858}
        physics, sensor = with_effects(linear_object(base), Sensor(), (effect,))
        (force,), _ = tangential_readings(physics, sensor, motion)
        (finer,), _ = tangential_readings(physics, sensor, motion, step=STEP_S / 4.0)
        assert np.sqrt(np.mean((force - finer) ** 2)) < 3e-4
