"""The trial's two plants: where one may stand for the other, two engines that share nothing agree."""

from collections import defaultdict

import numpy as np
import pytest

from mmt_drake.diagrams.proof.trial import run
from mmt_drake.diagrams.proof.trial.cases import draw_base, draw_single
from mmt_drake.diagrams.proof.trial.laws import INSIDE, LAWS, OUTSIDE, Concealed, linear_object, with_effects
from mmt_drake.diagrams.proof.trial.motions import draw_motion
from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.diagrams.proof.trial.plants import FOREIGN, NOT_IN_A_PLANE, OWN, foreign_numbers
from mmt_drake.diagrams.proof.trial.sensor import Sensor
from mmt_drake.diagrams.proof.trial.sizes import SIZES
from mmt_drake.errors import BadInput

MOTION = draw_motion(np.random.default_rng(2), duration=10.0, along_x=0.0)
STEPS = 50


def with_some(name: str) -> Physics:
    return LAWS[name].plant(Physics(), defaultdict(lambda: 0.3))


PLANTED = [name for name in FOREIGN.effects if with_some(name) != Physics()]


@pytest.mark.parametrize("name", PLANTED)
def test_the_foreign_plant_takes_on_what_an_effect_changes(name: str) -> None:
    assert foreign_numbers(with_some(name)) != foreign_numbers(Physics())


BENEATH = {
    "texture": {"F": 0.2, "length": 0.01},
    "wandering_friction": {"F": 0.2, "period": 6.0},
    "power_drag": {"c": 20.0},
}
# In newtons; a body that lets go at Fs does so by another rule, and a clearance has edges.
DIFFERENCE = defaultdict(lambda: 5e-3, static_friction=0.05, contact_gap=0.01)


@pytest.mark.parametrize("name", ["nothing", *PLANTED])
def test_along_one_axis_both_plants_give_the_same_force(name: str) -> None:
    rng = np.random.default_rng(4)
    base, effects = draw_base(rng, ()), tuple[Concealed, ...]()
    if name in SIZES:
        case = draw_single(rng, "x", name, 0.7)
        base, effects = dict(case.base), case.effects
    elif name in BENEATH:
        effects = (Concealed(name, BENEATH[name]),)
    physics = with_effects(linear_object(base), Sensor(), effects)[0]._replace(v_d=0.0)
    (own, _), (foreign, _) = (plant.forces(physics, MOTION, (1,), STEPS) for plant in (OWN, FOREIGN))
    assert np.sqrt(np.mean((own - foreign) ** 2)) < DIFFERENCE[name]
    assert np.std(own) > 0.1


def test_a_trial_by_the_foreign_plant_conceals_what_it_has_in_flexible_boxes(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []
    monkeypatch.setattr(run, "draw_single", lambda rng, name, effect, size, plant: drawn.append((effect, plant)))
    monkeypatch.setattr(run, "draw_several", lambda rng, name, count, plant: drawn.append((name, plant)))
    monkeypatch.setattr(run, "draw_plain", lambda rng, name, wrong, plant: drawn.append(("plain", plant)))
    list(run._ordered(np.random.default_rng(0), 1, FOREIGN))
    assert {plant for _, plant in drawn} == {FOREIGN}
    assert {name for name, _ in drawn} == {*INSIDE, *OUTSIDE, "pair", "triple", "plain"} - set(NOT_IN_A_PLANE)


def test_its_hands_move_along_both_axes_and_static_friction_has_no_band() -> None:
    case = draw_single(np.random.default_rng(1), "x", "static_friction", 0.8, FOREIGN)
    assert set(case.effects[0].parameters) == {"Fs", "Fd"}
    recording = case.recording()
    assert np.std(recording["position_x"]) > 0.002 and np.std(recording["force_x"]) > 0.1


def test_there_is_no_third_plant() -> None:
    with pytest.raises(BadInput, match="plant: found another, expected own or foreign"):
        run.draw_trial(plant="another")
