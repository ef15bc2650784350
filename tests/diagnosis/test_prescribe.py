"""What is prescribed separates what was ambiguous, keeps within what a hand can do, and can be played."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_samples import FORCE_NOISE, MODEL, POSITION_NOISE, VELOCITY_NOISE
from outcome_samples import FRICTION, fitted
from trial_samples import beside

from mmt_drake.cli.main import main
from mmt_drake.diagnosis.fit.comparison import RULED_OUT
from mmt_drake.diagnosis.fit.prepare import Prepared, prepare
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.tell.motion_bank import INPUTS, Reach, motions
from mmt_drake.diagnosis.tell.motion_plans import Planner
from mmt_drake.diagnosis.tell.prescribe import INPUT_FILE, MOTION_FILE, Prescription, prescribe
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.controller import Controller
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.structure import Structure
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.recording import Recording, load
from mmt_drake.replay import replayed

DEPTH = 0.004


def at(prepared: Prepared, model: Structure, effects: dict[str, dict[str, float]]) -> Fitted:
    """A hypothesis with given numbers, not fitted."""
    hypothesis = beside(*effects, nominal=model, skew=prepared.skew)
    return prepared.problem.at(hypothesis, hypothesis.vector({}, effects))


def prescribed(rivals: list[Fitted], prepared: Prepared, late: bool = False) -> Prescription:
    with ThreadPoolExecutor(1) as executor:
        return prescribe(rivals, prepared, executor, lambda: late)


def recorded(motion: Recording, model: Structure, seed: int) -> Recording:
    """A motion as it would be recorded, with noise on every channel."""
    contact = {"in_contact": (motion["position_z"] < 0.0).astype(float)}
    columns = {name: motion[name] for kind in ("position", "velocity") for name in (f"{kind}_{a}" for a in "xyz")}
    columns |= replayed(model, Recording(motion.time, {**columns, **contact}, "new.csv"))
    levels = {"position": POSITION_NOISE, "velocity": VELOCITY_NOISE, "force": FORCE_NOISE}
    rng = np.random.default_rng(seed)
    noisy = {name: values + levels[name[:-2]] * rng.standard_normal(len(values)) for name, values in columns.items()}
    return Recording(motion.time, {**noisy, **contact}, "new.csv")


@pytest.fixture(scope="module")
def pressed() -> tuple[list[Fitted], Prepared, Prescription]:
    """Coulomb friction or friction in proportion to the load, after a motion that pressed equally deep throughout."""
    t = np.arange(20000) / 1000.0
    position, velocity = scripted_motion("sines", duration=20.0, depth=DEPTH).sample(t)
    columns = {f"position_{a}": position[:, i] for i, a in enumerate("xyz")}
    columns |= {f"velocity_{a}": velocity[:, i] for i, a in enumerate("xyz")}
    level = {"coulomb_friction": {"Fc": FRICTION}}
    model = LIBRARY["coulomb_friction"].apply(MODEL, level["coulomb_friction"])
    prepared = prepare([recorded(Recording(t, columns), model, seed=5)], MODEL)
    of_load = {"load_dependent_friction": {"mu": FRICTION / (MODEL.normal.k * DEPTH)}}
    rivals = [fitted(prepared, MODEL, level), fitted(prepared, MODEL, of_load)]
    return rivals, prepared, prescribed(rivals, prepared)


def test_pressing_differently_tells_friction_by_load_from_friction_without(
    pressed: tuple[list[Fitted], Prepared, Prescription],
) -> None:
    _, _, found = pressed
    assert found.best.plan.name == "presses of several depths"
    assert found.best.separation.settles
    assert found.best.separation.noises > 5.0 * found.now.noises
    assert found.best is found.tried[0]
    assert found.tried[0].separation.margin >= found.tried[-1].separation.margin
    for word in (MOTION_FILE, "presses of several depths", "load dependent friction", "times the noise"):
        assert word in found.text


def test_the_prescribed_motion_keeps_its_promise(pressed: tuple[list[Fitted], Prepared, Prescription]) -> None:
    """Recorded with noise of its own and read as any other recording, it rules the wrong explanation out."""
    (true, other), _, found = pressed
    problem = prepare([recorded(found.best.plan.recording, true.model, seed=11)], MODEL).problem
    right, wrong = problem.fit(true.hypothesis, true.x).cost, problem.fit(other.hypothesis, other.x).cost
    assert wrong - right > RULED_OUT
    left = math.sqrt((wrong - right) / problem.samples())
    assert left > 0.7 * found.best.separation.noises  # the worse of two truths was promised


def test_an_equal_pair_is_found_to_be_equal(tmp_path: Path) -> None:
    """A constant force with Coulomb friction and asymmetric Coulomb friction are one force, whatever the motion."""
    t = np.arange(8000) / 400.0
    u = 4.0 * np.sin(2 * np.pi * 0.7 * t) + 2.0 * np.sin(2 * np.pi * 0.31 * t + 1.0)
    body = DrivenBodyModel(m=1.0, b=5.0, k=20.0, Fc=1.0)
    recording = Recording(t, {"input": u, "output": np.zeros(len(t))}, "servo.csv")
    true = LIBRARY["constant_force"].apply(body, {"F": 0.3})
    output = replayed(true, recording)["output"] + 2e-5 * np.random.default_rng(1).standard_normal(len(t))
    prepared = prepare([replace(recording, columns={"input": u, "output": output})], body)
    pair = [
        at(prepared, body, {"constant_force": {"F": 0.3}}),
        at(prepared, body, {"asymmetric_friction": {"Fc_plus": 0.7, "Fc_minus": 1.3}}),
    ]
    assert len(prescribed(pair, prepared, late=True).tried) == 1
    found = prescribed(pair, prepared)
    assert len(found.tried) >= 3
    assert found.best is None
    assert found.tried[0].separation.noises < 0.2
    assert found.text.startswith("None of the")
    assert found.write(tmp_path) is None
    drag = at(prepared, body, {"quadratic_drag": {"c": 3.0}})
    other = prescribed([pair[0], drag], prepared)
    assert other.best.separation.settles
    assert other.write(tmp_path) == tmp_path / INPUT_FILE
    simulated = ["--operator", tmp_path / INPUT_FILE, "--out", tmp_path / "simulated.npz"]
    model = tmp_path / "model.yaml"
    model.write_text("structure: driven_body\nparameters: {m: 1.0, b: 5.0, k: 20.0, Fc: 1.0}\n")
    assert main(["simulate", "--model", str(model), *map(str, simulated)]) == 0
    # The body stays about where it was recorded, whichever explanation is right.
    reach = load(tmp_path / "simulated.npz")["output"]
    assert np.abs(reach).max() < 2.0 * np.abs(output).max()


def test_one_axis_alone_is_moved_and_neither_lifted_nor_pressed(tmp_path: Path) -> None:
    t = np.arange(10000) / 1000.0
    position, velocity = scripted_motion("sines", duration=10.0).sample(t)
    columns = {"position": position[:, 1], "velocity": velocity[:, 1]}
    empty = Recording(t, {**columns, "force": np.zeros(len(t))}, "one_axis.csv")
    rubbing = LIBRARY["coulomb_friction"].apply(MODEL, {"Fc": FRICTION})
    noise = FORCE_NOISE * np.random.default_rng(2).standard_normal(len(t))
    recording = replace(empty, columns={**columns, "force": replayed(rubbing, empty)["force"] + noise})
    prepared = prepare([recording], MODEL)
    level = {"coulomb_friction": {"Fc": FRICTION}}
    rivals = [at(prepared, MODEL, level), at(prepared, MODEL, {"quadratic_drag": {"c": 5.0}})]
    found = prescribed(rivals, prepared)
    assert found.best.separation.settles
    assert not {"presses of several depths", "touches with free space between"} & {t.plan.name for t in found.tried}
    motion = load(found.write(tmp_path))
    assert motion.kind == "single_axis"
    np.testing.assert_allclose(motion["force"], replayed(rivals[0].model, motion)["force"], atol=1e-9)
    assert np.abs(motion["position"] - position[:, 1].mean()).max() < 1.6 * np.abs(position[:, 1]).max()


def test_one_explanation_is_nothing_to_separate(pressed: tuple[list[Fitted], Prepared, Prescription]) -> None:
    rivals, prepared, _ = pressed
    with pytest.raises(BadInput, match="two or more"):
        prescribed(rivals[:1], prepared)
    with pytest.raises(BadInput, match="recording to fit"):
        prescribed(rivals, replace(prepared, problem=None))


@pytest.mark.parametrize(
    "reach",
    [
        Reach("y", amplitude=0.05, speed=0.25, depth=0.005, duration=30.0),
        Reach("x", amplitude=0.1, speed=0.8, depth=0.01, duration=40.0),
        Reach("y", amplitude=0.01, speed=0.1, depth=0.002, duration=20.0, top_hz=1.0),
    ],
)
def test_the_bank_keeps_within_reach(reach: Reach) -> None:
    for motion in motions(reach):
        time, position, velocity = motion.sample(500.0)
        along = position[:, reach.along]
        assert np.abs(along).max() < 1.51 * reach.amplitude, motion.name
        assert np.abs(velocity[:, reach.along]).max() < 1.51 * reach.speed, motion.name
        assert -position[:, 2].min() < 3.8 * reach.depth, motion.name
        assert position[:, 2].max() < 1.01 * reach.clearance + 1e-9, motion.name
        contact = np.mean(position[:, 2] < 0.0)
        assert 0.5 < contact < 1.0, motion.name
        # Between parts the hand is at rest, so velocity is the rate of position throughout.
        np.testing.assert_allclose(np.gradient(along, time)[2:-2], velocity[2:-2, reach.along], atol=0.01 * reach.speed)


def test_goals_are_about_where_the_loop_was_recorded() -> None:
    t = np.arange(4000) / 500.0
    goal = 5.0 + 0.1 * np.sin(3.0 * t)
    model = DrivenBodyModel(m=1.0, b=8.0, controller=Controller("pd", 80.0, kd=4.0))
    columns = {"input": goal, "output": np.full(len(t), 5.0)}
    columns["output"] = replayed(model, Recording(t, columns))["output"]
    prepared = prepare([Recording(t, columns, "loop.csv")], model)
    assert prepared.problem is not None
    plan = next(Planner([model], prepared.recordings[0], prepared.problem.tracks[0]).plans())
    assert np.abs(plan.recording["input"] - 5.0).max() < 0.2


def test_inputs_are_at_most_one_in_size() -> None:
    t = np.arange(6000) / 200.0
    for one in INPUTS:
        values = one.shape(t, 0.8)
        assert values.shape == t.shape
        assert 0.9 < np.abs(values).max() <= 1.0 + 1e-12, one.name
        assert "0.8" in one.text.format(top=0.8)
