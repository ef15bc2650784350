"""Signs, units and clocks: what the check before a diagnosis recognises in recordings of every kind, and what it bears.

Recordings by the trial's own engine, which shares no code with the model, and models whose values are off.
"""

from collections.abc import Callable

import numpy as np
import pytest
from trial_samples import BASE, COULOMB, carriage, changed, cut, late, model, recorded, spring, times

from mmt_drake.diagnosis.checks.preflight import Preflight, preflight
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model_files import Model
from mmt_drake.recording import Recording

OFF = {"k2": 400.0, "b1": 23.0, "b2": 22.0, "m": 0.6}


def contact() -> Recording:
    """Strokes along y with friction that the model lacks."""
    return recorded(COULOMB)


MODELS: dict[str, Model] = {
    "contact": model(**OFF),
    "spring": KelvinVoigt(k=450.0, b=23.0, x0=0.01),
    "carriage": DrivenBodyModel(m=1.7, b=12.0, k=80.0, Fc=0.4),
}
MADE: dict[str, Callable[[], Recording]] = {"contact": contact, "spring": spring, "carriage": carriage}


def told(kind: str, spoil: Callable[[Recording], Recording] = lambda r: r) -> Preflight:
    return preflight(spoil(MADE[kind]()), MODELS[kind])


@pytest.mark.parametrize("kind", MADE)
def test_as_it_is_nothing_is_refused(kind: str) -> None:
    assert told(kind).reason is None


REFUSED = [
    ("contact", late(-0.005, "force"), "misaligned", "before the motion that causes it"),
    ("contact", late(-0.1, "force"), "misaligned", "The force comes 100."),
    ("contact", late(0.4, "force"), "misaligned", "after the motion that causes it"),
    ("contact", times(-1.0, "force"), "swapped_sign", "change their sign"),
    ("contact", lambda r: changed(r, force_y=-r["force_y"]), "swapped_sign", "force_y"),
    (
        "contact",
        lambda r: changed(r, position_z=-r["position_z"], velocity_z=-r["velocity_z"]),
        "swapped_sign",
        "does z point down",
    ),
    ("contact", times(1e3, "position", "velocity"), "units", "are positions in mm"),
    ("contact", times(1.0 / 9.80665e-3, "force"), "units", "gram-force"),
    ("contact", times(1.0 / 9.80665, "force"), "units", "are forces in kilogram-force"),
    ("contact", times(1.0 / 4.4482, "force"), "units", "are forces in pound-force"),
    ("contact", times(1e-3, "force"), "units", "or forces in kN?"),
    ("spring", late(0.3, "force"), "misaligned", "The force comes 0.30 s after the motion"),
    ("spring", late(-0.05, "force"), "misaligned", "The force comes 0.05 s before the motion"),
    ("spring", late(1.0, "force"), "misaligned", "The force comes 1.00 s after the motion"),
    ("spring", times(-1.0, "force"), "swapped_sign", "a spring of -5"),
    ("spring", times(1e2, "position", "velocity"), "units", "are positions in cm?"),
    ("spring", times(1e3, "force"), "units", "are forces in mN"),
    ("carriage", late(0.3, "output"), "misaligned", "The output comes 0.30 s after the input"),
    ("carriage", late(-0.3, "output"), "misaligned", "The output comes 0.30 s before the input"),
    ("carriage", times(-1.0, "input"), "swapped_sign", "one of the two has the other sign"),
    ("carriage", times(0.0, "input"), "magnitude", "The input reads 0 throughout while the output moves"),
    ("carriage", times(1e3, "output"), "units", "is its unit that of the model?"),
    (
        "carriage",
        lambda r: changed(r, output=np.clip(r["output"], -0.005, 0.005)),
        "saturation",
        "output stands at exactly",
    ),
]


@pytest.mark.parametrize(("kind", "spoil", "code", "said"), REFUSED, ids=[f"{k}: {s}" for k, _, _, s in REFUSED])
def test_what_cannot_be_is_refused_by_its_cause_alone(
    kind: str, spoil: Callable[[Recording], Recording], code: str, said: str
) -> None:
    found = told(kind, spoil)
    assert [finding.code for finding in found.findings if finding.severity == "refuse"] == [code]
    assert found.reason is not None and said in found.reason


BORNE = [
    ("contact", late(0.04, "force")),
    ("contact", late(0.2, "force")),
    ("contact", times(2.5, "force")),
    ("contact", lambda r: cut(r, (r.time % 1.0) < 0.8)),
    ("spring", late(0.04, "force")),
    ("spring", times(2.5, "force")),
    ("carriage", late(0.04, "output")),
    ("carriage", times(2.0, "input")),
]


@pytest.mark.parametrize(("kind", "spoil"), BORNE)
def test_what_a_diagnosis_may_find_is_left_to_it(kind: str, spoil: Callable[[Recording], Recording]) -> None:
    assert told(kind, spoil).reason is None


MEMORY = {
    "viscoelastic_relaxation": {"k_maxwell": 500.0, "tau": 0.3},
    "hysteresis": {"alpha": 500.0, "beta": 200.0},
    "nonlinear_stiffness": {"k3": 2.0 * 500.0 / 0.02**2},
    "force_lag": {"tau": 0.03},
}


@pytest.mark.parametrize("name", MEMORY)
def test_physics_with_a_memory_is_not_taken_for_a_clock(name: str) -> None:
    found = preflight(spring((name, tuple(MEMORY[name].items()))), MODELS["spring"])
    assert found.reason is None


@pytest.mark.parametrize("factor", [20.0, 0.05])
def test_a_model_that_is_twenty_times_off_is_asked_about(factor: float) -> None:
    other = model(**{symbol: factor * BASE[symbol] for symbol in ("m", "k2", "b1", "b2")})
    found = preflight(recorded(), other)
    assert found.reason is not None
    assert f"is {1.0 / factor:.3g} times what the model answers" in found.reason
    assert "does the model belong to this object" in found.reason


def test_a_lift_whose_mass_is_a_little_off_is_no_other_unit() -> None:
    """Nothing holds it, so that its model falls away: a hundredth of its answer is no unit."""
    time, random = np.arange(0.0, 30.0, 1e-3), np.random.default_rng(0)
    w, size, m = np.array([0.05, 1.1, 5.3]), np.array([0.3, 0.06, 0.03]), 1.7
    angle = np.outer(time, w)
    x, v, a = np.sin(angle) @ size, np.cos(angle) @ (w * size), -np.sin(angle) @ (w**2 * size)
    force = m * (a + 9.81) + 4.0 * v
    lift = Recording(time, {"output": x + 1e-5 * random.standard_normal(len(x)), "input": force}, "lift")
    found = preflight(lift, DrivenBodyModel(m=0.72 * m, b=4.0, gravity=Gravity("constant", 9.81)))
    assert found.reason is None
    assert [finding.severity for finding in found.findings if finding.code in ("units", "magnitude")] == ["warn"]


def test_an_end_stop_is_no_clipped_sensor() -> None:
    """The body stands against it, and its sensor still reads noise."""
    stopped = carriage(("end_stop", (("position", 0.02), ("stiffness", 2000.0), ("side", 1.0))))
    assert not [f for f in preflight(stopped, MODELS["carriage"]).findings if f.code == "saturation"]
