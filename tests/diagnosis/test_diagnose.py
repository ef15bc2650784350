"""The whole diagnosis on recordings by another engine: the verdict, the name, the numbers, and silence where due."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from trial_samples import BASE, COULOMB, model, recorded

import mmt_drake.diagnosis.law_session as steps
import mmt_drake.diagnosis.search.polish as polish
import mmt_drake.diagnosis.tell.outcome as outcomes
from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import MaterialSession
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.recording import Recording

SECONDS = 15.0
SPRING = KelvinVoigt(k=500.0, b=20.0)
SOME = (
    "coulomb_friction",
    "stribeck_friction",
    "asymmetric_friction",
    "nonlinear_stiffness",
    "force_bias",
    "constant_force",
    "time_delay",
)


@cache
def diagnosed(
    *effects: tuple[str, tuple[tuple[str, float], ...]], library: tuple[str, ...] = SOME, **nominal: float
) -> Outcome:
    """What is said of these concealed effects by a model with these numbers wrong."""
    recording = recorded(*effects, seed=3, seconds=SECONDS)
    return diagnose([recording], model(**nominal), library=[LIBRARY[name] for name in library])


def of_a_spring(effect: str, **values: float) -> Recording:
    """A spring and damper with one effect more."""
    base = {"k": SPRING.k, "b": SPRING.b, "x0": 0.0, "F0": 0.0}
    return MaterialSession(seed=1).record(base, (Concealed(effect, values),))


def test_a_right_model_has_no_mismatch():
    found = diagnosed().diagnosis
    assert found.verdict == "no_mismatch"
    assert not found.effects and not found.parameters and found.tried == 0


def test_wrong_values_are_parameters_and_their_intervals_exclude_them():
    found = diagnosed(k2=0.85 * BASE["k2"], b1=1.15 * BASE["b1"]).diagnosis
    assert found.verdict == "parameters"
    assert {"k2", "b1"} <= set(found.parameters)
    assert found.parameters["k2"].value == pytest.approx(BASE["k2"], rel=0.05)
    assert found.parameters["b1"].value == pytest.approx(BASE["b1"], rel=0.01)


def test_concealed_friction_is_named_with_its_level():
    found = diagnosed(COULOMB, k2=0.9 * BASE["k2"], b2=1.1 * BASE["b2"]).diagnosis
    assert found.verdict == "missing_physics"
    assert [(effect.name, effect.certain) for effect in found.effects] == [("coulomb_friction", "law")]
    level = found.effects[0].parameters["Fc"]
    assert level.value == pytest.approx(0.4, rel=0.02)
    assert level.ci95 is not None and level.ci95[0] < level.ci95[1]
    assert found.mismatch.blocks[0].block == "friction"
    assert found.tried == len(SOME)  # each alone: the best leaves only noise


def test_a_name_that_is_unsure_for_want_of_time_asks_for_no_other_motion():
    library = [LIBRARY[name] for name in (*SOME, "hysteresis", "static_friction")]
    found = diagnose([recorded(COULOMB, seed=3, seconds=SECONDS)], model(), library=library, time_budget=1e-3).diagnosis
    # Which law of dry friction is tried first does not matter: what was not tried leaves the law unsure.
    assert [(e.family, e.block) for e in found.effects] == [(LIBRARY["coulomb_friction"].family, "friction")]
    assert found.untried and found.effects[0].certain != "law" and found.next_recording is None


def test_with_what_was_missing_held_out_data_are_predicted_to_the_noise():
    fit = diagnosed(COULOMB, k2=0.9 * BASE["k2"], b2=1.1 * BASE["b2"]).diagnosis.fit
    assert fit is not None and fit.noise_floor is not None
    error = fit.heldout_nrmse
    assert error.augmented < 1.3 * fit.noise_floor < min(error.refit, error.nominal)


def test_an_equal_set_is_listed_as_indistinguishable():
    unlike = ("asymmetric_friction", (("Fc_plus", 0.6), ("Fc_minus", 0.2)))
    found = diagnosed(unlike, library=("coulomb_friction", "asymmetric_friction", "constant_force")).diagnosis
    assert found.verdict in ("missing_physics", "ambiguous")
    sets = [{effect.name for effect in found.effects}]
    sets += [set(a.name.split(" + ")) for a in found.alternatives if a.indistinguishable]
    assert {"asymmetric_friction"} in sets
    assert {"constant_force", "coulomb_friction"} in sets


def test_physics_outside_the_library_gets_no_name():
    others = [LIBRARY[name] for name in ("nonlinear_stiffness", "force_bias", "time_delay")]
    found = diagnose([recorded(COULOMB, seed=3, seconds=SECONDS)], model(), library=others).diagnosis
    assert found.verdict == "unexplained"
    assert {effect.name for effect in found.effects} <= {"tabulated_force"}


def test_a_spring_that_is_stiffer_one_way_is_a_curve_and_no_offset_beside_one(monkeypatch):
    t, rng = np.arange(8000) / 400.0, np.random.default_rng(0)
    x, v, side, begin = np.zeros_like(t), np.zeros_like(t), 0.0, 0.4
    while begin < 19.0:  # from side to side, with rests: there the mean of its force is an offset
        takes, to = rng.uniform(0.25, 1.0), (-0.012 if side > 0.0 else 0.012) * rng.uniform(0.5, 1.0)
        s = np.clip((t - begin) / takes, 0.0, 1.0)
        x += (to - side) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        v += (to - side) * 30.0 * s**2 * (1.0 - s) ** 2 / takes
        side, begin = to, begin + takes + rng.uniform(0.1, 0.9)
    force = -np.where(x < 0.0, 0.6, 1.0) * SPRING.k * x - SPRING.b * v + rng.normal(0.0, 0.02, len(t))
    recording = Recording(t, {"position": x, "velocity": v, "force": force})
    library = [LIBRARY[name] for name in (*SOME, "tabulated_force")]
    found = diagnose([recording], SPRING, library=library).diagnosis
    assert (found.verdict, [effect.name for effect in found.effects]) == ("unexplained", ["tabulated_force"])
    assert found.effects[0].parameters["of"].value == "deflection"
    assert found.fit.heldout_nrmse.augmented < 0.1 * found.fit.heldout_nrmse.refit
    monkeypatch.setattr("mmt_drake.diagnosis.law_session.ALIKE", 0.0)
    beside = diagnose([recording], SPRING, library=library).diagnosis
    assert [effect.name for effect in beside.effects] == ["force_bias", "tabulated_force"]  # it would be named


def test_a_soft_force_sensor_is_a_curve_of_the_sensor_and_no_softening_spring():
    t, rng = np.arange(8000) / 400.0, np.random.default_rng(0)
    w, size = 2.0 * np.pi * np.array([0.6, 1.4, 2.3]), np.array([0.012, 0.008, 0.004])
    x, v = np.sin(w * t[:, None]) @ size, np.cos(w * t[:, None]) @ (w * size)
    true = -SPRING.k * x - 3.0 * SPRING.b * v
    limit = 1.1 * np.abs(true).max()
    force = limit * np.tanh(true / limit) + rng.normal(0.0, 0.02, len(t))
    recording = Recording(t, {"position": x, "velocity": v, "force": force})
    library = [LIBRARY[name] for name in ("nonlinear_stiffness", "power_law_stiffness", "tabulated_force")]
    found = diagnose([recording], replace(SPRING, b=3.0 * SPRING.b), library=library).diagnosis
    assert [effect.name for effect in found.effects] == ["tabulated_force"], found.summary
    assert found.effects[0].block == "force_sensor"


def wedged(seconds: float = 20.0) -> Recording:
    """A body on a spring in a wedge: its level of friction grows with the square of its position."""
    step, inner, rng = 4e-3, 20, np.random.default_rng(0)
    t = np.arange(0.0, seconds, step)
    w, phase = 2.0 * np.pi * rng.uniform(0.2, 2.0, 8), rng.uniform(0.0, 2.0 * np.pi, 8)
    u = 2.5 * np.sin(np.outer(t, w) + phase).sum(axis=1)
    x, v, h, y = 0.0, 0.0, step / inner, np.empty_like(t)
    for i, force in enumerate(u):
        y[i] = x
        for _ in range(inner):  # friction by its impulse: it stops a body that it would turn back
            v += h * (force - 6.0 * v - 50.0 * x) / 1.3
            v -= np.clip(v, -(most := h * (0.3 + 80.0 * x * x) / 1.3), most)
            x += h * v
    return Recording(t, {"input": u, "output": y + rng.normal(0.0, 2.5e-4, len(t))})


def test_a_law_that_a_curve_of_another_block_may_stand_for_has_no_name_where_much_is_left(monkeypatch):
    recording, body = wedged(), DrivenBodyModel(m=1.3, b=6.0, k=50.0, Fc=0.3)
    library = [LIBRARY[name] for name in ("hunt_crossley_damping", "nonlinear_stiffness", "tabulated_force")]
    found = diagnose([recording], body, library=library).diagnosis
    assert {effect.name for effect in found.effects} <= {"tabulated_force"}
    monkeypatch.setattr(steps, "ALIKE", 0.0)
    named = diagnose([recording], body, library=library).diagnosis
    assert found.verdict == "unexplained" != named.verdict  # of the contact, which has nothing to do with it


def test_a_still_hand_says_nothing():
    recording = recorded(seed=3, seconds=SECONDS)
    still = {name: np.full(len(recording), values[0]) for name, values in recording.columns.items()}
    found = diagnose([replace(recording, columns=still)], model()).diagnosis
    assert found.verdict == "insufficient_data"
    assert found.fit is None and found.model is None


def test_a_recording_of_another_structure_is_bad_input():
    recording = recorded(seed=3, seconds=SECONDS)
    columns = {"input": recording["force_y"], "output": recording["position_y"]}
    with pytest.raises(BadInput, match="structure"):
        diagnose([replace(recording, columns=columns)], model())


def test_workers_of_any_number_find_the_same():
    library = [LIBRARY[name] for name in ("coulomb_friction", "nonlinear_stiffness")]
    recording, answers = of_a_spring("nonlinear_stiffness", k3=2e4), []
    for jobs in (1, 2):
        with workers(jobs) as executor:
            found = diagnose([recording], SPRING, library=library, executor=executor).diagnosis
        answers.append(json.dumps(replace(found, seconds=None).to_json()))
    assert answers[0] == answers[1] and found.verdict == "missing_physics"


def test_no_candidate_is_taken_on_twice_or_simulated_twice(monkeypatch: pytest.MonkeyPatch):
    taken, simulated = [], []
    take_on, error = polish._taken_on, outcomes._error

    def counted(problem, fitted):
        taken.append((problem, fitted))
        return take_on(problem, fitted)

    def told(ruler, fitted):
        simulated.append(fitted)
        return error(ruler, fitted)

    monkeypatch.setattr(polish, "_taken_on", counted)
    monkeypatch.setattr(outcomes, "_error", told)
    monkeypatch.setattr(steps, "TRY_MORE", 0.1)  # so that the search itself looks at the fine clock
    library = [LIBRARY[name] for name in ("coulomb_friction", "nonlinear_stiffness")]
    found = diagnose([of_a_spring("nonlinear_stiffness", k3=2e4)], SPRING, library=library)
    assert len(taken) == len({(id(problem), id(fitted)) for problem, fitted in taken}) > 0
    assert len(simulated) == len(found.candidates) == len(found.diagnosis.candidates) > 1
    assert {a.heldout_nrmse for a in found.diagnosis.alternatives} <= {
        None,
        *(c.heldout_nrmse for c in found.diagnosis.candidates),
    }
