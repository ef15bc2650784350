"""A surface that nobody recorded, and friction of the tip on it: found where they are, and not where they are not."""

from dataclasses import replace

import numpy as np
import pytest
from palpation_samples import STIFFNESS, ball, palpation

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.place_tables import SHAPE
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.surface_fit import SurfaceFit
from mmt_drake.effects import LIBRARY
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.simulation import simulate

BELIEVED = SurfaceContact(k=400.0, b=0.5)
SEARCHED = [LIBRARY[name] for name in ("surface_shape", "probe_slip", "coulomb_friction")]
DOME, MU = 0.08, 0.3
MAP = "stiffness_map"


ANSWERS: list[str] = []


@pytest.fixture(scope="module")
def outcome():
    return diagnose([palpation(radius=DOME, mu=MU)], BELIEVED, library=SEARCHED, on_answer=ANSWERS.append)


def test_shape_and_slip_are_named_where_both_are_there(outcome):
    found = outcome.diagnosis
    assert found.verdict in ("missing_physics", "partly_explained")
    assert {e.name: e.certain for e in found.effects} == {"surface_shape": "law", "probe_slip": "law"}
    assert found.fit.axes == ("x", "y", "z")
    assert found.fit.heldout_nrmse.augmented < 0.2 * found.fit.heldout_nrmse.refit


def test_a_first_answer_that_has_the_shape_is_told_on_the_way(outcome):
    (answer,) = ANSWERS
    assert answer.startswith("so far ") and "surface_shape" in answer and "nothing" in answer


def test_the_learned_heights_are_those_of_the_dome_where_the_probe_was(outcome):
    shape = next(e for e in outcome.diagnosis.effects if e.name == "surface_shape").parameters
    x, y = np.meshgrid(shape["x"].value, shape["y"].value)
    inside = (np.abs(x) < 0.008) & (np.abs(y) < 0.012)
    off = np.reshape(shape["height"].value, x.shape) - ball(x, y, DOME)
    assert np.std(off[inside]) < 0.1 * np.ptp(ball(x, y, DOME)[inside])
    assert min(shape["deviation"].value) > 0.0


def test_friction_is_found_again_to_a_tenth(outcome):
    mu = next(e for e in outcome.diagnosis.effects if e.name == "probe_slip").parameters["mu"]
    assert mu.value == pytest.approx(MU, rel=0.1) and mu.ci95[0] < mu.value < mu.ci95[1]


def test_what_is_delivered_simulates_to_the_error_that_is_told(outcome):
    recording = outcome.prepared.recordings[0]
    simulated = simulate(outcome.best.model, recording)
    chosen = np.zeros(len(recording), dtype=bool)
    for start, end in outcome.diagnosis.fit.heldout_s:
        chosen |= (recording.time >= start) & (recording.time <= end)
    names = [f"force_{axis}" for axis in "xyz"]
    measured, own = (np.concatenate([r[name][chosen] for name in names]) for r in (recording, simulated))
    error = np.sqrt(np.mean((measured - own) ** 2)) / np.std(measured)
    assert error == pytest.approx(outcome.diagnosis.fit.heldout_nrmse.augmented, rel=1e-6)


def test_a_dome_on_which_the_tip_glides_freely_has_no_friction():
    found = diagnose([palpation(radius=DOME, seed=1)], BELIEVED, library=SEARCHED).diagnosis
    assert [(e.name, e.certain) for e in found.effects] == [("surface_shape", "law")]


def test_friction_on_a_level_surface_makes_no_shape():
    found = diagnose([palpation(mu=MU, seed=2)], BELIEVED, library=SEARCHED).diagnosis
    assert [(e.name, e.certain) for e in found.effects] == [("probe_slip", "law")]


@pytest.mark.parametrize(("k", "verdict"), [(STIFFNESS, "no_mismatch"), (400.0, "parameters")])
def test_a_level_surface_without_friction_lacks_nothing(k, verdict):
    found = diagnose([palpation(seed=3)], replace(BELIEVED, k=k, b=0.0), library=SEARCHED).diagnosis
    assert (found.verdict, found.effects) == (verdict, ())


def test_derivatives_after_heights_and_stiffness_are_those_of_the_force():
    problem = prepare([palpation(radius=DOME, seconds=20.0)], BELIEVED).problem
    surface = SurfaceFit(problem)
    x, y = surface.grid
    heights = 0.001 + np.asarray([ball(u, v, 0.1) for v in y for u in x])
    hypothesis = Hypothesis(BELIEVED).adding(LIBRARY["surface_shape"])
    tables = {SHAPE: heights, MAP: 400.0 + 50.0 * np.sin(np.arange(len(heights)))}
    hypothesis = hypothesis.adding(LIBRARY[MAP])
    model = surface.model(hypothesis, np.array([0.5]), tables)
    told, before = surface.derivatives(model, (SHAPE, MAP)).toarray(), surface.residual(model)
    for first, (name, step) in enumerate(((SHAPE, 1e-7), (MAP, 1e-2))):
        for node in (len(heights) // 3, len(heights) // 2):
            moved = tables[name].copy()
            moved[node] += step
            after = surface.residual(surface.model(hypothesis, np.array([0.5]), {**tables, name: moved}))
            own = (after - before) / step
            # What is simulated passes the filter that the measured force has passed; its derivatives do not.
            found = told[:, first * len(heights) + node]
            assert np.linalg.norm(own - found) < 0.2 * np.linalg.norm(own)


def test_what_no_law_explains_is_put_where_a_tip_on_a_surface_has_a_place():
    found = diagnose([palpation(radius=DOME, mu=MU, tool=(0.004, -0.003, 0.006))], BELIEVED, library=SEARCHED).diagnosis
    assert found.verdict in ("unexplained", "partly_explained")
    assert found.mismatch.blocks and {b.block for b in found.mismatch.blocks} <= set(SurfaceContact.BLOCKS)
