"""The estimator knows when its model does not explain the object, and when the object is another one."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.tick_by_tick import foreign_force, own_force
from mmt_drake.estimation.output_error.adequacy import Adequacy, ModelStatus
from mmt_drake.estimation.output_error.offline import OutputErrorTrace, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model_files import with_effects
from mmt_drake.motion.scripted import scripted_motion

STEP, SECONDS, CHANGE = 1e-3, 9.0, 5.0
TIME = np.arange(round(SECONDS / STEP)) * STEP
MOTION = np.hstack(scripted_motion("strokes", duration=SECONDS, lifts=0).sample(TIME))
CONTACT = (MOTION[:, 2] < 0.0).astype(float)
DEVIATION = np.repeat([1e-5, 5e-4, 0.02], 3)
OBJECT = FlexibleBoxModel(
    BoxParameters(1.5, 100.0, 800.0, 30.0, 25.0, 0.6), NormalContact(800.0, 25.0), in_plane="vector"
)


def force_of(first: FlexibleBoxModel, then: FlexibleBoxModel | None = None) -> np.ndarray:
    """Force (n, 3) of an object that is another one from CHANGE on."""
    return own_force(TIME, MOTION, first, None if then is None else (CHANGE, then))


def estimated(force: np.ndarray, seed: int = 0, motion: np.ndarray = MOTION) -> OutputErrorTrace:
    noise = DEVIATION * np.random.default_rng(seed).standard_normal((len(TIME), 9))
    contact = (motion[:, 2] < 0.0).astype(float)
    return estimate_output_error(np.hstack([motion, force]) + noise, contact, OutputErrorOptions(in_plane="vector"))


def error(trace: OutputErrorTrace, force: np.ndarray, begin: float, end: float) -> float:
    """Of the estimated force along x and y between two times, over the force."""
    part = slice(round(begin / STEP), round(end / STEP))
    left = (trace.estimated_force - force)[part, :2]
    return float(np.linalg.norm(left) / np.linalg.norm(force[part, :2]))


@pytest.mark.parametrize("seed", range(3))
def test_a_model_that_has_the_object_s_law_is_never_doubted(seed: int) -> None:
    trace = estimated(force_of(OBJECT), seed)
    assert not np.isin(trace.model_status, (ModelStatus.MISFIT, ModelStatus.CHANGED)).any()
    assert trace.model_status[-1] == ModelStatus.ADEQUATE and 0.2 < trace.residual_ratio[-1] < 2.0


def test_nor_on_a_plant_that_shares_no_physics_with_it() -> None:
    trace = estimated(foreign_force(TIME, MOTION, OBJECT))
    assert not np.isin(trace.model_status, (ModelStatus.MISFIT, ModelStatus.CHANGED)).any()


@pytest.mark.parametrize(
    ("effect", "parameters"),
    [
        ("hunt_crossley_damping", {"lambda": 300.0}),
        ("nonlinear_stiffness", {"k3": 3e6}),
        ("end_stop", {"position": 0.004, "stiffness": 3000.0}),
    ],
)
def test_an_object_that_does_what_the_model_cannot_is_a_misfit_soon(effect: str, parameters: dict[str, float]) -> None:
    odd = with_effects(OBJECT, [{"name": effect, "parameters": parameters}], "test")
    trace = estimated(force_of(odd))
    doubted = np.flatnonzero(trace.model_status == ModelStatus.MISFIT)
    # Half a second of grace at first, then what is too much has to last.
    exceeds = np.flatnonzero((trace.residual_ratio > 3.0) & (np.cumsum(CONTACT) * STEP > 0.5))
    assert doubted.size and np.sum(CONTACT[exceeds[0] : doubted[0]]) * STEP < 1.0


@pytest.mark.parametrize("change", [{"m": 3.0}, {"k2": 1200.0, "b2": 40.0}])
def test_an_object_that_changes_is_noticed_forgotten_and_learned_anew(change: dict[str, float]) -> None:
    force = force_of(OBJECT, replace(OBJECT, parameters=replace(OBJECT.parameters, **change)))
    trace = estimated(force)
    before = trace.model_status[: round(CHANGE / STEP)]
    assert not np.isin(before, (ModelStatus.MISFIT, ModelStatus.CHANGED)).any()
    noticed = TIME[np.isin(trace.model_status, (ModelStatus.MISFIT, ModelStatus.CHANGED))]
    changed = TIME[trace.model_status == ModelStatus.CHANGED]
    assert noticed[0] < CHANGE + 1.2 and changed.size and changed[0] < CHANGE + 2.5
    assert error(trace, force, CHANGE + 0.2, CHANGE + 0.8) > 0.05
    assert error(trace, force, changed[0] + 0.5, SECONDS - 0.5) < 0.05


def test_pressing_at_rest_leaves_numbers_unexcited_and_says_so() -> None:
    still = np.zeros((len(TIME), 6))
    still[:, 2] = np.where(TIME < 0.3, 0.002, -0.004)
    trace = estimated(np.outer(still[:, 2] < 0.0, [0.0, 0.0, 3.2]), motion=still)
    assert (trace.model_status[TIME > 1.0] == ModelStatus.UNEXCITED).all()


def test_too_much_has_to_last_and_a_change_needs_an_object_known_before() -> None:
    known = Adequacy().after(1.0, 2.0, False)
    assert known.status == ModelStatus.ADEQUATE
    once = known.after(9.0, 0.3, False)
    assert once.status == ModelStatus.ADEQUATE and not once.may_have_changed
    twice = once.after(9.0, 0.3, False)
    assert twice.status == ModelStatus.MISFIT and not twice.may_have_changed  # so little says nothing
    assert twice.after(9.0, 0.3, False).may_have_changed
    assert twice.after(1.0, 0.1, True).status == ModelStatus.UNEXCITED
    never_known = Adequacy().after(9.0, 1.0, False).after(9.0, 1.0, False)
    assert never_known.status == ModelStatus.MISFIT and not never_known.may_have_changed
