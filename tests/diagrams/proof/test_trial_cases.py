"""The trial's motions and cases: what they hold, that they are sealed, and that a seed gives them again."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.diagrams.proof.trial.cases import (
    _EXCLUSIVE,
    PLAIN,
    Case,
    draw_plain,
    draw_several,
    draw_single,
    visibility,
)
from mmt_drake.diagrams.proof.trial.laws import INSIDE, LAWS, OUTSIDE
from mmt_drake.diagrams.proof.trial.motions import draw_motion
from mmt_drake.diagrams.proof.trial.other_cases import DRIVEN, MATERIAL, TRANSMISSION, draw_driven, draw_material
from mmt_drake.diagrams.proof.trial.palpation import EFFECTS as PALPATED
from mmt_drake.diagrams.proof.trial.remainder import REMAINDERS
from mmt_drake.diagrams.proof.trial.run import MODEL, RECORDING, draw_trial, run_trial, write_case
from mmt_drake.diagrams.proof.trial.sealing import seal
from mmt_drake.diagrams.proof.trial.session import ContactSession
from mmt_drake.diagrams.proof.trial.sizes import SIZES
from mmt_drake.errors import BadInput, Interrupted
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model_files import load_model
from mmt_drake.recording import load


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.fixture(scope="module")
def trial() -> list[Case]:
    return draw_trial(seed=5, per_effect=1)


def test_an_operator_strokes_dwells_and_presses_two_or_three_times_within_what_a_hand_does() -> None:
    for seed in range(8):
        motion = draw_motion(rng(seed))
        touches = np.count_nonzero(np.diff(motion.contact.astype(int)) == 1)
        assert touches in (2, 3)
        assert not motion.contact[0]
        assert not motion.contact[-1]
        assert np.max(np.abs(motion.position[:, 1])) <= 0.1
        assert np.max(np.abs(motion.velocity)) < 0.6
        still = motion.contact & (np.abs(motion.velocity[:, 1]) < 1e-3)
        assert 0.02 < np.mean(still) < 0.6
        pressed = motion.position[motion.contact, 2]
        assert np.std(pressed) > 0.05 * np.abs(np.mean(pressed))


def test_a_motion_s_content_reaches_4_hz_and_ends_below_10() -> None:
    motion = draw_motion(rng(2))
    power = np.abs(np.fft.rfft(motion.velocity[:, 1] * np.hanning(len(motion.time)))) ** 2
    hertz = np.fft.rfftfreq(len(motion.time), motion.time[1])
    assert np.sum(power[(hertz > 2.5) & (hertz < 5.0)]) > 0.01 * np.sum(power)
    assert np.sum(power[hertz > 10.0]) < 1e-4 * np.sum(power)


def test_velocity_is_the_rate_of_position() -> None:
    motion = draw_motion(rng(4))
    central = (motion.position[2:] - motion.position[:-2]) / (motion.time[2] - motion.time[0])
    assert np.max(np.abs(central - motion.velocity[1:-1])) < 2e-3


def test_all_motions_differ_and_a_seed_gives_its_own_again() -> None:
    first, again, other = draw_motion(rng(1)), draw_motion(rng(1)), draw_motion(rng(2))
    assert np.array_equal(first.position, again.position)
    assert abs(np.corrcoef(first.velocity[:, 1], other.velocity[:, 1])[0, 1]) < 0.5


def test_a_motion_is_not_too_short() -> None:
    with pytest.raises(BadInput, match="duration"):
        draw_motion(rng(), duration=5.0)


def test_every_effect_has_a_law_and_a_size_and_there_are_enough_outside_the_library() -> None:
    # Those of other structures are in `test_trial_one_axis` and `test_trial_palpation`.
    of_others = {*DRIVEN, *MATERIAL, *TRANSMISSION, *PALPATED} - set(SIZES)
    assert set(LAWS) - set(REMAINDERS) - of_others == set(SIZES) == set(INSIDE) | set(OUTSIDE)
    assert len(OUTSIDE) >= 8
    assert {LAWS[name].block for name in OUTSIDE} == {"friction", "contact", "body", "force_sensor", "channel"}


@pytest.mark.parametrize("name", SIZES)
def test_a_plain_effect_is_seen_and_a_larger_one_is_seen_better(name: str) -> None:
    small, plain = (draw_single(rng(8), "x", name, size) for size in (0.05, 0.95))
    assert plain.visibility > 3.0
    assert plain.visibility > 1.5 * small.visibility


def test_the_nominal_model_has_the_true_structure_without_the_effect(tmp_path: Path) -> None:
    for name, left_out in (("coulomb_friction", "Fc"), ("viscous_friction", "b1"), ("ground_spring", "k1")):
        case = draw_single(rng(1), name, name, 0.8)
        model = load_model(write_case(case, tmp_path) / MODEL)
        assert isinstance(model, FlexibleBoxModel)
        assert getattr(model.parameters, left_out) == 0.0
        for symbol in ("m", "k2", "b2"):
            assert getattr(model.parameters, symbol) == pytest.approx(case.base[symbol], rel=0.2)


def test_a_clean_case_has_the_exact_model_and_a_wrong_one_has_not() -> None:
    clean, wrong = draw_plain(rng(1), "a", wrong=False), draw_plain(rng(1), "b", wrong=True)
    assert clean.truth()["nominal_is_exact"]
    assert not wrong.truth()["nominal_is_exact"]
    assert clean.truth()["truth"] == wrong.truth()["truth"] == []


@pytest.mark.parametrize(("kind", "count"), [("pair", 2), ("triple", 3)])
def test_several_effects_are_plain_each_and_none_stands_in_another_s_place(kind: str, count: int) -> None:
    case = draw_several(rng(3), kind, count)
    names = {effect.name for effect in case.effects}
    assert case.kind == kind and len(names) == count
    assert all(visibility(case.base, (effect,), case.session) > PLAIN for effect in case.effects)
    assert all(len(names & set(exclusive)) < 2 for exclusive in _EXCLUSIVE)


def test_a_recording_is_its_true_reading_and_white_noise_of_the_size_stated() -> None:
    base = draw_plain(rng(6), "x", wrong=False).base
    session = ContactSession(seed=9, noise=0.02, duration=10.0)
    recording, motion = session.record(base, ()), session.motion
    noise = recording["force_y"][motion.contact] - session.true_reading(base, ())
    assert np.std(noise) == pytest.approx(0.02, rel=0.05)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.05
    assert np.std(recording["position_y"] - motion.position[:, 1]) == pytest.approx(1e-5, rel=0.05)
    assert np.std(recording["velocity_y"] - motion.velocity[:, 1]) == pytest.approx(5e-4, rel=0.05)
    pressed = recording["force_z"] - np.where(
        motion.contact, -base["normal_k"] * motion.position[:, 2] - base["normal_b"] * motion.velocity[:, 2], 0.0
    )
    assert np.std(pressed) == pytest.approx(0.02, rel=0.05)


def test_columns_that_are_not_recorded_are_not_there() -> None:
    base = draw_plain(rng(6), "x", wrong=False).base
    session = ContactSession(seed=9, noise=0.02, duration=10.0, velocity=False, in_contact=False)
    assert {name.partition("_")[0] for name in session.record(base, ()).columns} == {"position", "force"}


def test_a_trial_holds_every_effect_and_all_other_kinds_of_cases(trial: list[Case]) -> None:
    singles = Counter(
        c.effects[0].name for c in trial if len(c.effects) == 1 and c.nominal["structure"] == "flexible_box"
    )
    assert singles == dict.fromkeys(SIZES, 1)
    kinds = Counter(case.kind for case in trial)
    assert min(kinds[kind] for kind in ("none", "parameters", "pair")) >= 5 and kinds["triple"] >= 3
    for structure, effects in (("driven_body", DRIVEN), ("transmission", TRANSMISSION)):
        assert {c.effects[0].name for c in trial if c.nominal["structure"] == structure and c.effects} == set(effects)


def test_names_of_sealed_cases_say_nothing(trial: list[Case]) -> None:
    assert [case.name for case in trial] == [f"case-{i:04d}" for i in range(1, len(trial) + 1)]
    order = [
        INSIDE.index(case.effects[0].name) for case in trial if case.kind == "single" and case.effects[0].name in INSIDE
    ]
    assert order != sorted(order)


def test_the_same_seed_gives_the_same_seal_and_another_seed_another() -> None:
    def some(seed: int) -> list[Case]:
        one = rng(seed)
        return [
            draw_single(one, "a", "end_stop", 0.5),
            draw_several(one, "b", 2),
            draw_plain(one, "c", wrong=True),
            draw_driven(one, "d", "stribeck_friction", 0.5, wrong=True),
            draw_material(one, "e", "hysteresis", 0.5, wrong=False),
        ]

    first, again = some(1), some(1)
    assert seal(first) == seal(again)
    assert seal(first[2:3]) != seal([draw_plain(rng(2), "c", wrong=True)])
    assert seal(first) != seal(first[:-1])
    for case, same in zip(first, again, strict=True):
        assert case.nominal == same.nominal
        made, made_again = case.recording(), same.recording()
        assert all(np.array_equal(made_again[name], values) for name, values in made.columns.items())


def test_a_case_s_folder_holds_a_recording_and_a_model_that_read_back_and_not_its_truth(
    trial: list[Case], tmp_path: Path
) -> None:
    for structure in ("flexible_box", "driven_body", "transmission", "kelvin_voigt"):
        case = next(c for c in trial if c.nominal["structure"] == structure and c.effects)
        folder = write_case(case, tmp_path)
        assert {path.name for path in folder.iterdir()} == {RECORDING, MODEL}
        assert case.effects[0].name not in (folder / MODEL).read_text()
        load_model(folder / MODEL)
        recording = load(folder / RECORDING)
        for name, values in case.recording().columns.items():
            assert np.array_equal(recording[name], values)


def test_no_concealed_spring_makes_its_object_unstable() -> None:
    # From this seed the first object drawn has a spring that softens until it pushes.
    case = draw_single(np.random.default_rng(10), "case", "nonlinear_stiffness", 0.9)
    assert np.isfinite(case.visibility)


def test_a_trial_refuses_no_cases_and_negative_seeds() -> None:
    with pytest.raises(BadInput, match="per-effect"):
        draw_trial(per_effect=0)
    with pytest.raises(BadInput, match="seed"):
        draw_trial(seed=-1)


def test_a_trial_that_is_interrupted_hands_over_its_diagnoses_and_keeps_the_truths_sealed(
    trial: list[Case], tmp_path: Path
) -> None:
    def diagnose(folder: Path) -> dict[str, str]:
        if folder.name == trial[2].name:
            raise KeyboardInterrupt
        return {"verdict": f"of {folder.name}"}

    with pytest.raises(Interrupted, match=f"2 of {len(trial)} diagnosed") as raised:
        run_trial(trial, tmp_path, diagnose, announce=lambda seal: None)
    done = {case.name: {"verdict": f"of {case.name}"} for case in trial[:2]}
    assert raised.value.known == {"of": len(trial), "diagnoses": done}
    assert [file.name for file in tmp_path.iterdir()] == ["cases"]
