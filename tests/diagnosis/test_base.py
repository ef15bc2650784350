"""The fit without effects: values that are far off are found, and nothing is sought far away without need."""

from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor

import numpy as np
import pytest
from threadpoolctl import threadpool_limits
from trial_samples import BASE, changed, cut, model, recorded

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.search import base
from mmt_drake.diagnosis.search.base import NOTHING_MISSING, fit_base
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession
from mmt_drake.effects import LIBRARY
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model_files import Model
from mmt_drake.recording import Recording

CARRIAGE = {"m": 2.0, "b": 10.0, "k": 80.0, "Fc": 0.5}
SPRING = {"k": 500.0, "b": 20.0}


@pytest.fixture
def executor() -> Iterator[Executor]:
    # As `diagnose` has it: sums that come out the same however busy the machine is.
    with threadpool_limits(limits=1, user_api="blas"), ThreadPoolExecutor(1) as threads:
        yield threads


def box() -> Recording:
    return recorded(seed=3, seconds=10.0)


def carriage(**changed: float) -> Recording:
    whole = DrivenSession(1).record({**CARRIAGE, "offset": 0.0, "gravity": 0.0, "pendulum": 0.0, **changed}, ())
    return cut(whole, whole.time < 10.0)


def spring() -> Recording:
    """A spring and a damper in closed form, with sensor noise."""
    t = np.arange(8000) / 1000.0
    w = 2.0 * np.pi * np.array([0.8, 1.7, 2.9])
    size = np.array([0.02, 0.01, 0.004])
    x, v = np.sin(w * t[:, None]) @ size, np.cos(w * t[:, None]) @ (w * size)
    noise = 0.02 * np.random.default_rng(0).standard_normal(len(t))
    return Recording(t, {"position": x, "velocity": v, "force": -SPRING["k"] * x - SPRING["b"] * v + noise})


def fitted(recording: Recording, believed: Model, executor: Executor) -> tuple[Problem, Fitted]:
    prepared = prepare([recording], believed)
    assert prepared.problem is not None, prepared.reason
    return prepared.problem, fit_base(prepared.problem, believed, prepared.skew, executor)[1]


FAR_OFF = {
    "mass of a box": (box, model(m=20.0 * BASE["m"]), {"m": BASE["m"], "b1": BASE["b1"]}),
    "contact spring and damper of a box": (box, model(k2=9000.0, b2=500.0), {"b1": BASE["b1"]}),
    "mass of a carriage": (carriage, DrivenBodyModel(**{**CARRIAGE, "m": 40.0}), CARRIAGE),
    "spring of a carriage": (carriage, DrivenBodyModel(**{**CARRIAGE, "k": 4.0}), CARRIAGE),
    "friction of a carriage": (carriage, DrivenBodyModel(**{**CARRIAGE, "Fc": 0.025}), CARRIAGE),
    "damper of a spring": (spring, KelvinVoigt(k=500.0, b=1.0), SPRING),
    "spring": (spring, KelvinVoigt(k=25.0, b=20.0), SPRING),
}


@pytest.mark.parametrize("which", FAR_OFF)
def test_a_value_twenty_times_off_is_found(which: str, executor: Executor) -> None:
    made, believed, true = FAR_OFF[which]
    problem, found = fitted(made(), believed, executor)
    assert found.cost <= NOTHING_MISSING**2 * problem.samples()
    assert not at_bounds(found)  # and there is room about it for what follows
    values = found.hypothesis.structure_values(found.x)
    for symbol, value in true.items():
        # Of a short recording of a box, m, k2 and b2 are known only together.
        assert values[symbol] == pytest.approx(value, rel=0.15 if symbol == "m" else 0.03), symbol


def test_a_wrong_moment_of_gravity_beside_missing_friction_is_no_spring() -> None:
    believed = DrivenBodyModel(**{**CARRIAGE, "k": 0.0, "Fc": 0.0}, gravity=Gravity("pendulum", 7.0))
    library = [LIBRARY[name] for name in ("coulomb_friction", "ground_spring", "nonlinear_stiffness")]
    found = diagnose([carriage(k=0.0, pendulum=8.6)], believed, library=library).diagnosis
    assert [(effect.name, effect.certain) for effect in found.effects] == [("coulomb_friction", "law")], found.summary
    assert found.parameters["pendulum"].value == pytest.approx(8.6, rel=0.01)
    assert found.effects[0].parameters["Fc"].value == pytest.approx(CARRIAGE["Fc"], rel=0.05)


def test_what_gravity_does_to_a_pendulum_is_a_parameter(executor: Executor) -> None:
    believed = DrivenBodyModel(**{**CARRIAGE, "k": 0.0}, gravity=Gravity("pendulum", 9.6))
    problem, found = fitted(carriage(k=0.0, pendulum=8.6), believed, executor)
    assert found.cost <= NOTHING_MISSING**2 * problem.samples()
    assert found.hypothesis.structure_values(found.x)["pendulum"] == pytest.approx(8.6, rel=0.01)


NEAR = {
    "right": (box, model()),
    "off by a fifth": (box, model(k2=0.8 * BASE["k2"], b1=1.2 * BASE["b1"])),
    "a carriage off by a fifth": (carriage, DrivenBodyModel(m=2.4, b=8.0, k=90.0, Fc=0.4)),
}


@pytest.mark.parametrize("which", NEAR)
def test_nothing_is_begun_far_away_where_no_bound_is_in_the_way(
    which: str, executor: Executor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(base, "_from_afar", lambda *_: pytest.fail("begun far away"))
    made, believed = NEAR[which]
    fitted(made(), believed, executor)


def test_a_bound_that_missing_physics_drives_a_parameter_to_gives_way(executor: Executor) -> None:
    """Without its friction, a heavy load of it, a body is taken for one with another mass and damper."""
    rubbing = recorded(("coulomb_friction", (("Fc", 2.0),)), seed=3, seconds=10.0)
    problem, found = fitted(rubbing, model(), executor)
    assert found.cost > NOTHING_MISSING**2 * problem.samples()
    low, high, _ = found.hypothesis.limits(found.x)
    assert (found.x >= low).all() and (found.x <= high).all() and found.hypothesis.nominal == model()
    assert at_bounds(found) <= found.hypothesis.widened and found.hypothesis.widened


def test_a_crude_model_is_mended_though_not_everything_is_explained(executor: Executor) -> None:
    """Values six and ten times off and a slow swing of the sensor that nobody names: no fit comes down to noise."""
    plain = recorded(seed=3, seconds=10.0)
    recording = changed(plain, force_y=plain["force_y"] + 0.1 * np.sin(2.0 * np.pi * 0.17 * plain.time))
    problem, found = fitted(recording, model(m=0.05, b1=20.0 / 6.0, b2=25.0 / 6.0), executor)
    assert found.cost > NOTHING_MISSING**2 * problem.samples() and not at_bounds(found)
    values = found.hypothesis.structure_values(found.x)
    assert values["b1"] == pytest.approx(BASE["b1"], rel=0.05)
    assert values["m"] == pytest.approx(BASE["m"], rel=0.3)  # the swing takes it along; it was handed in ten times off


def test_a_bound_gives_way_where_no_more_than_noise_is_left(executor: Executor) -> None:
    believed = KelvinVoigt(k=SPRING["k"], b=SPRING["b"] / 4.02)  # just beyond four times what is handed in
    problem, found = fitted(spring(), believed, executor)
    assert not at_bounds(found) and found.cost <= NOTHING_MISSING**2 * problem.samples()
    assert found.model.b == pytest.approx(SPRING["b"], rel=0.02)
