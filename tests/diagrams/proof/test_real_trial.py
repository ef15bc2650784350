"""The cases on public recordings: what is held out stays out, models lack what they conceal, known figures come out."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.tell.result import Alternative, Diagnosis, Fit, HeldoutNrmse, NamedEffect
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.diagrams.proof.trial.real import run
from mmt_drake.diagrams.proof.trial.real.case import HeldOut, Published, RealCase, RealPart
from mmt_drake.diagrams.proof.trial.real.data_sets import CASES, real_arms, real_cases, without_a_case
from mmt_drake.diagrams.proof.trial.real.further import FURTHER
from mmt_drake.diagrams.proof.trial.real.preparation import between, from_release, loaded_by_gravity
from mmt_drake.diagrams.proof.trial.real.run import Diagnosed, RealResult, diagnosed_table, held_out_error, run_real
from mmt_drake.errors import BadInput
from mmt_drake.model_files import parse_model
from mmt_drake.recording import Recording, save
from mmt_drake.recording.check import completed
from mmt_drake.simulation import simulate

GRAVITY = 9.81
NAMED = {case.name: case for case in CASES}
BAM_SERVO, EMPS, MR_DAMPER = (NAMED[name] for name in ("bam_servo", "emps", "mr_damper"))
LIGHT_BALL, HEAVY_BALL = (NAMED[f"falling_balls/{ball}"] for ball in ("orange_whiffle_ball", "baseball"))
BALLS = [case for case in CASES if case.folder == "falling_balls"]
KIND = {
    "driven_body": "driven_body",
    "transmission": "driven_body",
    "kelvin_voigt": "single_axis",
    "surface_contact": "contact",
}


def overlap(one: RealPart, other: RealPart) -> bool:
    if (one.file, one.number) != (other.file, other.number):
        return False
    (a, b), (c, d) = one.seconds or (-np.inf, np.inf), other.seconds or (-np.inf, np.inf)
    return max(a, c) < min(b, d)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_nothing_that_is_held_out_is_fitted(case: RealCase) -> None:
    held_out = [part for test in case.held_out for part in test.parts]
    assert case.fitted
    assert not [pair for pair in product(case.fitted, held_out) if overlap(*pair)]


@pytest.mark.parametrize("case", [*CASES, *FURTHER], ids=lambda case: case.name)
def test_every_case_loads_in_the_kind_that_its_model_wants(case: RealCase, recordings: Path) -> None:
    read = [*case.load_fitted(recordings), *(r for test in case.load_held_out(recordings).values() for r in test)]
    assert {recording.kind for recording in read} == {KIND[case.model["structure"]]}
    assert all(len(recording) > 30 and recording.time[-1] - recording.time[0] > 0.1 for recording in read)
    columns = [values for recording in read for values in recording.columns.values()]
    assert all(np.isfinite(values).all() for values in columns)


@pytest.mark.parametrize("case", [*CASES, *FURTHER], ids=lambda case: case.name)
def test_a_nominal_model_is_a_model_file_without_effects(case: RealCase) -> None:
    assert "effects" not in case.model
    assert set(case.model) <= {"structure", "parameters", "gravity", "units"}
    parse_model(dict(case.model), case.name)


def test_the_physics_that_is_known_is_not_in_the_models() -> None:
    assert set(EMPS.model["parameters"]) == {"m", "b"}
    assert set(NAMED["silverbox"].model["parameters"]) == {"m", "b", "k"}
    assert set(MR_DAMPER.model["parameters"]) == {"k", "b"}
    assert all(set(ball.model["parameters"]) == {"m"} for ball in BALLS)


def test_a_data_set_has_cases_or_is_told_to_have_none(recordings: Path) -> None:
    cases = [*real_cases(recordings), *real_arms(recordings)]
    tried, untried = {case.folder for case in cases}, without_a_case(recordings)
    assert tried.isdisjoint(untried) and "panda_comanipulation" in untried  # the operator's motion alone
    assert tried.union(untried) == {path.name for path in recordings.iterdir() if path.is_dir()}


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    for case in CASES[:-1]:
        (tmp_path / case.folder).mkdir(exist_ok=True)
    (tmp_path / "mr_damper").rmdir()
    with pytest.raises(BadInput, match=r"mr_damper: found no such folder, expected the recordings of mr_damper"):
        real_cases(tmp_path)
    balls = real_cases(tmp_path, ["falling_balls", "emps"])
    assert [case.folder for case in balls] == ["emps", *("falling_balls" for _ in BALLS)]
    with pytest.raises(BadInput, match="--only: found 'ball', expected one of bam_servo, "):
        real_cases(tmp_path, ["ball"])


def test_a_missing_file_or_recording_is_named(tmp_path: Path) -> None:
    (tmp_path / "emps").mkdir()
    with pytest.raises(BadInput, match=r"train\.npz: found no such file"):
        EMPS.load_fitted(tmp_path)
    drop = completed(np.linspace(0.0, 2.0, 20), {"input": np.zeros(20), "output": np.zeros(20)}, "drop")
    save(drop, tmp_path / "emps" / "drop.npz")
    with pytest.raises(BadInput, match="found 1 recordings, expected at least 2"):
        RealPart("drop.npz", number=1).load(tmp_path / "emps")


def test_a_linear_spring_and_damper_leave_478_newtons_of_the_damper_s_force(recordings: Path) -> None:
    # The recordings' own account gives this figure for a linear fit at 10 mm, 1 Hz, 1 A tested at 25 mm, 0.5 Hz.
    (test,) = MR_DAMPER.load_held_out(recordings).values()
    rmse, nrmse = held_out_error(parse_model(dict(MR_DAMPER.model)), test)
    assert rmse == pytest.approx(478.0, abs=0.5)
    assert nrmse == pytest.approx(478.0 / np.std(test[0]["force"]), rel=1e-3)


def test_without_drag_a_ball_follows_the_parabola_from_its_release(recordings: Path) -> None:
    (drop,) = LIGHT_BALL.load_fitted(recordings)
    since = drop.time - drop.time[0]
    parabola = drop["output"][0] - 0.5 * GRAVITY * since**2
    rmse, _ = held_out_error(parse_model(dict(LIGHT_BALL.model)), [drop])
    assert rmse == pytest.approx(np.sqrt(np.mean((drop["output"] - parabola) ** 2)), rel=1e-9)
    assert rmse > 5.0  # metres: a perforated ball is far from free fall, which the heavy one is not
    assert held_out_error(parse_model(dict(HEAVY_BALL.model)), HEAVY_BALL.load_fitted(recordings))[0] < 0.3


def test_the_stretches_of_the_multisine_begin_where_the_circuit_is_at_rest(recordings: Path) -> None:
    (fitted,) = NAMED["silverbox"].load_fitted(recordings)
    stretches = [fitted, *NAMED["silverbox"].load_held_out(recordings)["multisines"]]
    for stretch in stretches:
        first, second = stretch["output"][:2] / stretch["output"].std()
        assert abs(first) < 0.06 and abs(second - first) < 0.03
    assert len(fitted) == pytest.approx(4 * 8692, rel=1e-3)  # four of the ten realisations, 14.24 s each
    assert len(stretches[1]) == pytest.approx(6 * 8692, rel=2e-3)


def test_the_growing_amplitude_is_the_first_40_000_samples(recordings: Path) -> None:
    (growing,) = NAMED["silverbox"].load_held_out(recordings)["growing amplitude"]
    assert len(growing) == 40_000 and growing.time[0] == 0.0


def falling(release: float, drag: float, noise: float, first: float) -> Recording:
    """Linear drag has a closed form: h = h0 - (g/b) (t - (1 - exp(-b t)) / b)."""
    time = np.arange(first, 3.4, 1.0 / 15.0)
    fall = np.maximum(time - release, 0.0)
    height = 47.0 - GRAVITY / drag * (fall - (1.0 - np.exp(-drag * fall)) / drag)
    height += noise * np.random.default_rng(3).standard_normal(len(time))
    return completed(time, {"input": np.zeros(len(time)), "output": height}, "ball")


@pytest.mark.parametrize("release", [-0.12, -0.03, 0.05, 0.14])
@pytest.mark.parametrize("drag", [0.05, 0.6])
def test_a_release_is_found_before_or_after_the_first_sample(release: float, drag: float) -> None:
    exact, noisy = (from_release(falling(release, drag, noise, first=0.0)) for noise in (0.0, 0.03))
    assert exact.time[0] == pytest.approx(release, abs=0.012)
    assert noisy.time[0] == pytest.approx(release, abs=0.04)
    assert exact["output"][0] == pytest.approx(47.0, abs=0.05)
    assert (exact["input"] == 0.0).all() and (np.diff(exact.time) > 0.0).all()


def test_samples_before_the_release_are_left_out() -> None:
    whole = falling(0.14, 0.6, 0.0, first=0.0)
    released = from_release(whole)
    assert len(released) == 1 + np.sum(whole.time > released.time[0])
    assert released.time[1] > 0.13


def test_a_pendulum_s_gears_carry_the_torque_of_gravity(recordings: Path) -> None:
    servo = BAM_SERVO.load_fitted(recordings)[0]
    angle = servo["output"]
    assert servo["load"] == pytest.approx(0.49 * GRAVITY * 0.1 * np.abs(np.sin(angle)), abs=1e-12)
    assert BAM_SERVO.model["gravity"]["value"] == pytest.approx(0.49 * GRAVITY * 0.1, rel=1e-4)
    with pytest.raises(BadInput, match="ball: found no constants, expected a constant mass_kg"):
        loaded_by_gravity(falling(0.0, 0.6, 0.0, first=0.0))


def test_a_stretch_beyond_the_recording_is_refused() -> None:
    drop = falling(0.0, 0.6, 0.0, first=0.0)
    assert between(drop, 1.0, 2.0).time[0] >= 1.0
    with pytest.raises(BadInput, match=r"ball: time: found 0 to 3\.\d+ s, expected at least 10 samples from 5 to 6 s"):
        between(drop, 5.0, 6.0)


NOMINAL = {"structure": "driven_body", "parameters": {"m": 1.0, "b": 0.5}}
TRUTH = {"structure": "driven_body", "parameters": {"m": 1.0, "b": 2.0, "k": 30.0}}


def driven(seed: int, start: float) -> Recording:
    time = np.arange(0.0, 3.0, 0.01)
    u = np.interp(time, np.linspace(0.0, 3.0, 25), np.random.default_rng(seed).normal(0.0, 5.0, 25))
    blank = completed(time, {"input": u, "output": np.full_like(time, start)}, "body")
    return simulate(parse_model(TRUTH), blank)


@pytest.fixture
def body(tmp_path: Path) -> RealCase:
    (tmp_path / "data" / "bodies").mkdir(parents=True)
    for seed in range(3):
        save(driven(seed, 0.01 * seed), tmp_path / "data" / "bodies" / f"{seed}.npz")
    return RealCase(
        name="bodies/one",
        fitted=(RealPart("0.npz"),),
        held_out=(
            HeldOut("both", (RealPart("1.npz"), RealPart("2.npz")), Published(0.1, "someone")),
            HeldOut("half", (RealPart("2.npz", seconds=(0.0, 1.5)),)),
        ),
        model=NOMINAL,
        concealed="a spring",
        families=("body_force",),
        unit="mm",
    )


def test_a_diagnosis_is_scored_on_what_it_did_not_see(body: RealCase, tmp_path: Path) -> None:
    seen: list[tuple[Sequence[Recording], Mapping[str, Any], Path]] = []

    def diagnose(recordings: Sequence[Recording], model: Mapping[str, Any], out: Path) -> Diagnosed:
        seen.append((recordings, model, out))
        effects = (
            NamedEffect("ground_spring", "body_force", "body", None, {}),
            NamedEffect("viscous_friction", "viscous", "friction", None, {}),
        )
        alternatives = (Alternative("end_stop", None, True),)
        said = Diagnosis("ambiguous", "a spring", effects=effects, alternatives=alternatives)
        return Diagnosed(said, refit={**NOMINAL, "parameters": {"m": 1.5, "b": 1.0}}, augmented=TRUTH)

    both, half = run_real(tmp_path / "data", diagnose, tmp_path / "out", cases=[body])
    ((recordings, model, out),) = seen
    assert [Path(recording.source).name for recording in recordings] == ["0.npz"]
    assert model == NOMINAL and out == tmp_path / "out" / "bodies-one"

    tests = [driven(seed, 0.01 * seed) for seed in (1, 2)]
    misses = [simulate(parse_model(NOMINAL), test)["output"] - test["output"] for test in tests]
    measured = np.concatenate([test["output"] for test in tests])
    rmse = np.sqrt(np.mean(np.concatenate(misses) ** 2))
    assert both.rmse.nominal == pytest.approx(1e3 * rmse, rel=1e-6)
    assert both.nrmse.nominal == pytest.approx(rmse / measured.std(), rel=1e-6)
    assert both.rmse.augmented == pytest.approx(0.0, abs=1e-6)
    assert both.rmse.refit is not None and both.rmse.refit > 1.0
    assert (both.said.verdict, both.document()["effects"]) == ("ambiguous", ["ground_spring", "viscous_friction"])
    assert both.document()["alternatives"] == ["end_stop"] and both.published == Published(0.1, "someone")
    assert half.document()["test"] == "half" and half.published is None and half.rmse.nominal != both.rmse.nominal


def test_where_nothing_was_fitted_the_table_has_dashes_and_json_null(
    body: RealCase, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def diagnose(recordings: Sequence[Recording], model: Mapping[str, Any], out: Path) -> Diagnosed:
        return Diagnosed(Diagnosis("insufficient_data", "too still"), refit=None, augmented=None)

    monkeypatch.setattr(run, "real_cases", lambda directory, only: [body])
    monkeypatch.setattr(run, "real_arms", lambda directory, only: [])
    report = run.real_study(str(tmp_path / "data"), diagnose).run(Asked(tmp_path / "out"), lambda done: None)
    _, table = report.tables
    assert [len(row) for row in table.texts()] == [len(table.headers)] * 2
    first = dict(zip(table.headers, table.texts()[0], strict=True))
    assert first["verdict"] == "insufficient_data" and first["effects"] == "none"
    assert first["refit"] == first["augmented"] == "–" and first["published"] == "0.1"
    document = json.loads(json.dumps(report.document, allow_nan=False))["real"][1]
    assert document["rmse"]["refit"] is None and document["published"] is None and document["unit"] == "mm"


def test_a_row_tells_what_is_known_and_what_was_said(body: RealCase, tmp_path: Path) -> None:
    said = Diagnosis(
        "missing_physics",
        "a spring",
        budget=(BudgetPart("ground_spring", 0.9), BudgetPart("nameless", 0.1)),
        effects=(NamedEffect("ground_spring", "body_force", "body", "family", {}),),
        fit=Fit((), ((1.0, 2.0),), 0.01, HeldoutNrmse(0.5, 0.4, 0.02), HeldoutNrmse(0.9, 0.8, 0.03), 0.5),
    )
    found = replace(body, held_out=(), simple=0.04)
    results = run_real(tmp_path / "data", lambda *_: Diagnosed(said, None, None), tmp_path / "out", cases=[found])
    table = diagnosed_table(results)
    (row,) = (dict(zip(table.headers, texts, strict=True)) for texts in table.texts())
    assert row["known"] == "a spring" and row["effects, as certain as"] == "ground_spring (family)"
    assert row["shares"] == "ground_spring 0.90, nameless 0.10"
    assert (row["windows"], row["free"], row["simple fit"]) == ("0.4 -> 0.02", "0.8 -> 0.03", "0.04")


@pytest.mark.parametrize(
    ("families", "named", "judged"),
    [
        (("viscous",), [("viscous", "law")], "right"),
        (("viscous", "timing"), [("viscous", "family"), ("body_force", "family")], "partly false"),
        (("viscous",), [("body_force", "law"), ("viscous", "block")], "false"),
        (("viscous",), [("body_force", "block"), ("viscous", None)], "open"),
        ((), [], "right"),
        ((), [("viscous", "family")], "false"),
    ],
)
def test_names_as_sure_as_a_family_are_judged_by_the_families_that_are_known(
    body: RealCase, families: tuple[str, ...], named: list[tuple[str, Any]], judged: str
) -> None:
    effects = tuple(NamedEffect("any", family, "friction", certain, {}) for family, certain in named)
    said = Diagnosis("partly_explained" if named else "unexplained", "", effects=effects)
    result = RealResult(replace(body, families=families), None, said, None, None, 1.0)
    assert result.judged == judged and result.document()["judged"] == judged


@pytest.mark.parametrize("case", FURTHER, ids=lambda case: case.name)
def test_a_further_recording_is_none_that_a_case_is_fitted_to(case: RealCase) -> None:
    fitted = [part for known in CASES if known.folder == case.folder for part in known.fitted]
    assert fitted and case.name not in NAMED
    assert not [pair for pair in product(case.fitted, fitted) if overlap(*pair)]


def test_recordings_of_three_axes_are_not_scored() -> None:
    time = np.arange(0.0, 1.0, 0.01)
    columns = {f"{name}_{axis}": np.zeros(100) for name in ("position", "force") for axis in "xyz"}
    with pytest.raises(BadInput, match="found a contact recording, expected a driven body or a single axis"):
        held_out_error(parse_model(TRUTH), [completed(time, columns, "probe")])


def test_arms_are_diagnosed_beside_the_others_and_told_joint_by_joint(recordings: Path, tmp_path: Path) -> None:
    def nobody(some: Sequence[Recording], model: Mapping[str, Any], out: Path) -> Diagnosed:
        raise AssertionError("no other case was asked for")

    report = run.real_study(str(recordings), nobody, ["kuka_kr300"]).run(Asked(tmp_path), lambda done: None)
    (arm,) = report.document["arms"]
    assert (arm["name"], arm["verdict"]) == ("KR300", "partly_explained")
    (table,) = report.tables
    rows = {row[1]: row for row in table.rows}
    assert list(rows) == [f"joint_{n}" for n in range(1, 7)]
    assert "joint elasticity (law)" in str(rows["joint_3"][3])
    _, _, _, _, handed_in, found, simple, _ = rows["joint_6"]
    assert found < simple < handed_in


def test_an_arm_without_its_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="ur10e_arm: found no such folder"):
        real_arms(tmp_path)
