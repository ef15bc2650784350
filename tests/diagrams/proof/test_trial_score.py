"""Scoring a diagnosis against the truth: the truth table, equal pairs, numbers, and the figures over all cases."""

import hashlib
import json
import math
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.diagrams.proof.trial import run
from mmt_drake.diagrams.proof.trial.cases import draw_plain, draw_single
from mmt_drake.diagrams.proof.trial.score import TrialScore, score
from mmt_drake.diagrams.proof.trial.sealing import seal
from mmt_drake.diagrams.proof.trial.summary import (
    confusion,
    confusion_picture,
    document,
    effects_table,
    rates_table,
    summarise,
)
from mmt_drake.errors import BadInput

PARAMETERS: dict[str, dict[str, float]] = {
    "coulomb_friction": {"Fc": 0.4},
    "constant_force": {"F": 0.2},
    "asymmetric_friction": {"Fc_plus": 0.5, "Fc_minus": 0.3},
    "time_delay": {"delay": 0.01},
    "static_friction": {"Fs": 0.9, "Fd": 0.4, "v_d": 0.005},
    "periodic_disturbance": {"amplitude": 0.3, "frequency": 2.0, "phase": 3.1},
    "table_vibration": {"amplitude": 0.3, "frequency": 2.0, "rate": 0.1},
    "ageing_friction": {"F": 0.6, "time": 0.2, "distance": 0.001},
}
BLOCKS = {
    "coulomb_friction": "friction",
    "constant_force": "body",
    "asymmetric_friction": "friction",
    "time_delay": "channel",
    "static_friction": "friction",
    "stribeck_friction": "friction",
    "periodic_disturbance": "force_sensor",
    "table_vibration": "body",
    "ageing_friction": "friction",
}


def truth(*names: str, kind: str | None = None, Fc: float = 0.4) -> dict[str, Any]:
    kinds = {0: "none", 1: "single", 2: "pair", 3: "triple"}
    return {
        "case": "case-0001",
        "structure": "flexible_box",
        "kind": kind or kinds[len(names)],
        "truth": list(names),
        "blocks": [BLOCKS[name] for name in names],
        "parameters": [PARAMETERS[name] for name in names],
        "base": {
            "m": 0.5,
            "k1": 0.0,
            "k2": 400.0,
            "b1": 20.0,
            "b2": 20.0,
            "Fc": Fc,
            "normal_k": 400.0,
            "normal_b": 8.0,
        },
        "size": 0.5 if names else None,
        "visibility": 20.0 if names else 0.0,
    }


def answer(
    verdict: str,
    *names: str,
    equal: tuple[str, ...] = (),
    other: tuple[str, ...] = (),
    blocks: tuple[str, ...] | None = None,
    values: dict[str, Any] | None = None,
    refit: float = 0.1,
    certain: str | None = "law",
) -> dict[str, Any]:
    """A diagnosis that leads with the blocks of its names unless told otherwise."""
    ranked = blocks if blocks is not None else tuple(dict.fromkeys(BLOCKS.get(name, "body") for name in names))
    listed = [{"name": name, "heldout_nrmse": 0.02, "indistinguishable": True} for name in equal]
    listed += [{"name": name, "heldout_nrmse": 0.03, "indistinguishable": False} for name in other]
    return {
        "verdict": verdict,
        "effects": [
            {"name": name, "block": BLOCKS.get(name, "any"), "certain": certain, "parameters": values or {}}
            for name in names
        ],
        "alternatives": listed,
        "parameters": {},
        "mismatch": {"blocks": [{"block": block, "share": 0.8 / 2**i} for i, block in enumerate(ranked)]},
        "fit": {"noise_floor": 0.016, "heldout_nrmse": {"nominal": 0.4, "refit": refit, "augmented": 0.017}},
    }


named, either = partial(answer, "missing_physics"), partial(answer, "ambiguous")
RIGHT, FALSE, MISSED = (True, False), (False, True), (False, False)  # correct, false name
STATIC, CONSTANT, ASYMMETRIC = (truth(name) for name in ("static_friction", "constant_force", "asymmetric_friction"))
PAIR, VIBRATION = truth("static_friction", "time_delay"), truth("table_vibration", kind="outside")
ABOVE = {**STATIC, "remainder": ["flicker_noise"], "not_false": ["force_bias"]}

TABLE = [
    # nothing concealed
    (truth(), answer("no_mismatch"), RIGHT),
    (truth(), answer("parameters"), MISSED),
    (truth(), named("static_friction"), FALSE),
    (truth(), either("static_friction", other=("stribeck_friction",)), FALSE),
    (truth(), answer("unexplained"), MISSED),
    (truth(), answer("insufficient_data"), MISSED),
    (truth(kind="parameters"), answer("parameters"), RIGHT),
    (truth(kind="parameters"), answer("no_mismatch"), MISSED),
    (truth(kind="parameters"), answer("parameters", "coulomb_friction"), FALSE),
    # one effect
    (STATIC, named("static_friction"), RIGHT),
    (STATIC, named("stribeck_friction"), FALSE),
    (STATIC, named("static_friction", "time_delay"), FALSE),
    (STATIC, named("stribeck_friction", equal=("static_friction",)), FALSE),
    (STATIC, either("static_friction", equal=("stribeck_friction",)), RIGHT),
    (STATIC, either("stribeck_friction", equal=("static_friction",)), MISSED),
    (STATIC, either("stribeck_friction", equal=("time_delay",)), FALSE),
    (STATIC, answer("parameters"), MISSED),
    (STATIC, answer("unexplained", "tabulated_force"), MISSED),
    (STATIC, answer("unexplained", "stribeck_friction"), FALSE),
    (STATIC, {"verdict": "crashed", "summary": "KeyError: 'x'"}, MISSED),
    # depths of a name
    (STATIC, named("stribeck_friction", certain="family"), MISSED),
    (STATIC, named("quadratic_drag", certain="family"), FALSE),
    (STATIC, named("quadratic_drag", certain="block"), MISSED),
    (STATIC, named("static_friction", certain="family"), MISSED),
    (STATIC, answer("partly_explained", "static_friction"), MISSED),
    (ABOVE, answer("partly_explained", "static_friction"), RIGHT),
    (ABOVE, named("static_friction", "force_bias"), RIGHT),
    (ABOVE, answer("partly_explained", "force_bias"), MISSED),
    (ABOVE, answer("partly_explained", "time_delay"), FALSE),
    # outside the library
    (VIBRATION, answer("unexplained", "end_stop", blocks=("body",)), FALSE),
    (VIBRATION, answer("partly_explained", "end_stop", blocks=("body",), certain="block"), RIGHT),
    (VIBRATION, answer("unexplained", blocks=("body",)), RIGHT),
    (VIBRATION, answer("unexplained", "tabulated_force", blocks=("body",)), RIGHT),
    (VIBRATION, answer("unexplained", blocks=("friction", "body")), MISSED),
    (VIBRATION, named("static_friction"), FALSE),
    (
        {**truth("ageing_friction", kind="outside"), "families": ["dry_friction"]},
        answer("partly_explained", "coulomb_friction", certain="family"),
        RIGHT,
    ),
    # two effects
    (PAIR, named("time_delay", "static_friction"), RIGHT),
    (PAIR, named("time_delay"), MISSED),
    (PAIR, named("time_delay", "coulomb_friction"), FALSE),
    # equal pairs: constant force and Coulomb friction are asymmetric friction
    (ASYMMETRIC, named("asymmetric_friction"), FALSE),
    (ASYMMETRIC, named("asymmetric_friction", other=("constant_force",)), FALSE),
    (ASYMMETRIC, named("asymmetric_friction", equal=("constant_force",)), RIGHT),
    (ASYMMETRIC, named("asymmetric_friction", equal=("constant_force + coulomb_friction",)), RIGHT),
    (ASYMMETRIC, named("constant_force", equal=("asymmetric_friction",)), RIGHT),
    (ASYMMETRIC, named("coulomb_friction", "constant_force", equal=("asymmetric_friction",)), RIGHT),
    (ASYMMETRIC, named("coulomb_friction", "constant_force"), FALSE),
    (ASYMMETRIC, either("constant_force", equal=("asymmetric_friction",)), RIGHT),
    (CONSTANT, named("constant_force"), FALSE),
    (CONSTANT, named("constant_force", equal=("asymmetric_friction",)), RIGHT),
    (CONSTANT, named("asymmetric_friction", equal=("constant_force",)), RIGHT),
    # above the friction level it is no asymmetric friction any more
    (truth("constant_force", Fc=0.1), named("constant_force"), RIGHT),
    (truth("constant_force", Fc=0.1), named("asymmetric_friction"), FALSE),
    (
        truth("constant_force", "time_delay"),
        named("time_delay", "asymmetric_friction", equal=("constant_force",)),
        RIGHT,
    ),
]


@pytest.mark.parametrize(("real", "told", "judged"), TABLE)
def test_the_truth_table(real: dict[str, Any], told: dict[str, Any], judged: tuple[bool, bool]) -> None:
    found = score(real, told, 1.0)
    assert (found.correct, found.false_name) == judged


def test_the_blocks_that_lead_must_be_the_true_ones() -> None:
    one, two = truth("static_friction"), truth("static_friction", "time_delay")
    assert score(one, answer("unexplained", blocks=("friction", "body")), 1.0).block_correct is True
    assert score(one, answer("unexplained", blocks=("body", "friction")), 1.0).block_correct is False
    assert score(one, answer("unexplained", blocks=()), 1.0).block_correct is False
    assert score(two, answer("unexplained", blocks=("channel", "friction")), 1.0).block_correct is True
    assert score(two, answer("unexplained", blocks=("channel",)), 1.0).block_correct is False
    assert score(truth(), answer("no_mismatch"), 1.0).block_correct is None
    assert score(truth("asymmetric_friction"), answer("unexplained", blocks=("body",)), 1.0).block_correct is True


def test_numbers_are_compared_with_the_truth_and_their_intervals_with_it() -> None:
    values = {
        "Fs": {"value": 0.945, "unit": "N", "ci95": [0.89, 1.0]},
        "Fd": {"value": 0.42, "unit": "N", "ci95": [0.41, 0.43]},
        "v_d": {"value": 0.005, "unit": "m/s"},
    }
    told = answer("missing_physics", "static_friction", values=values)
    told["parameters"] = {
        "m": {"nominal": 0.6, "value": 0.49, "ci95": [0.48, 0.51]},
        "normal.k": {"nominal": 380.0, "value": 401.0, "ci95": [400.5, 401.5]},
    }
    found = score(truth("static_friction"), told, 1.0)
    assert [q.symbol for q in found.quantities] == ["static_friction.Fs", "static_friction.Fd", "static_friction.v_d"]
    assert [q.relative_error for q in found.quantities] == pytest.approx([0.05, 0.05, 0.0])
    assert [q.covered for q in found.quantities] == [True, False, None]
    assert [(q.symbol, q.covered) for q in found.base_quantities] == [("m", True), ("normal.k", False)]


def test_a_phase_is_compared_on_the_circle() -> None:
    told = 3.1 - 2.0 * math.pi + 0.02
    values = {"phase": {"value": told, "unit": "rad", "ci95": [told - 0.05, told + 0.05]}}
    found = score(truth("periodic_disturbance"), answer("missing_physics", "periodic_disturbance", values=values), 1.0)
    assert found.quantities[0].relative_error == pytest.approx(0.02 / (2.0 * math.pi))
    assert found.quantities[0].covered is True


def some_scores() -> list[TrialScore]:
    fs = {"Fs": {"value": 0.99, "unit": "N", "ci95": [0.95, 1.0]}}
    return [
        score(truth("static_friction"), answer("missing_physics", "static_friction", values=fs), 2.0),
        score(truth("static_friction") | {"size": 0.2}, answer("missing_physics", "stribeck_friction"), 4.0),
        score(truth("time_delay"), answer("no_mismatch", refit=0.02), 6.0),
        score(truth("static_friction", "time_delay"), answer("missing_physics", "time_delay", "static_friction"), 8.0),
        score(truth(), answer("no_mismatch", refit=0.017), 1.0),
        score(truth("table_vibration", kind="outside"), answer("unexplained", blocks=("body",)), 3.0),
    ]


def test_the_summary_counts_each_rate_over_the_cases_it_is_about() -> None:
    found = summarise(some_scores())
    assert found["cases"] == 6
    assert found["noticeable"] == 2  # the delay is below three times the noise
    assert found["right"] == 0.5
    assert found["right_visible"] == pytest.approx(1 / 3)
    assert found["right_pairs"] == found["right_outside"] == found["right_clean"] == 1.0
    assert found["right_parameters"] is None
    assert found["false_name_rate"] == pytest.approx(1 / 6)
    assert found["false_names_plain"] == 0
    assert found["counted"]["right"] == {"count": 1, "of": 2, "at_least": pytest.approx(1.0 - 0.95**0.5)}
    assert "right_parameters" not in found["counted"]
    assert found["sizes"]["outside"]["size"] == [0.5] * 3
    assert found["coverage"] == 0.0
    assert found["parameter_error"] == pytest.approx(0.1)
    assert found["improvement"] == pytest.approx(0.1 / 0.017)
    assert found["augmented_over_noise"] == pytest.approx(0.017 / 0.016)
    assert found["seconds"] == 3.5
    static = found["by_effect"]["static_friction"]
    assert static["right"] == 0.5
    assert static["smallest_found"]["size"] == 0.5
    assert static["largest_missed"]["size"] == 0.2
    assert found["by_effect"]["time_delay"]["smallest_found"] is None


@pytest.mark.parametrize(("cases", "most"), [(196, 0.0152), (60, 0.0487)])
def test_no_false_name_in_n_cases_bounds_their_rate_by_about_three_over_n(cases: int, most: float) -> None:
    summary = summarise([score(truth(), answer("no_mismatch", refit=0.017), 1.0)] * cases)
    assert summary["counted"]["false_name_rate"] == {"count": 0, "of": cases, "at_most": pytest.approx(most, abs=5e-5)}
    assert summary["counted"]["false_name_rate"]["at_most"] == pytest.approx(1.0 - 0.05 ** (1.0 / cases))
    row = next(row for row in rates_table(summary).texts() if row[0] == "false name rate")
    assert row[2:4] == [f"0 of {cases}", f"<= {most:.2g}"]


def test_the_confusion_matrix_counts_every_case_once() -> None:
    rows, columns, counts = confusion(some_scores())
    assert counts.sum() == 6
    cell = {(r, c): int(counts[i, j]) for i, r in enumerate(rows) for j, c in enumerate(columns) if counts[i, j]}
    assert cell == {
        ("static_friction", "static_friction"): 1,
        ("static_friction", "stribeck_friction"): 1,
        ("time_delay", "no_mismatch"): 1,
        ("two effects", "all"): 1,
        ("outside: table_vibration", "unexplained"): 1,
        ("nothing", "no_mismatch"): 1,
    }


def test_three_effects_are_counted_by_themselves_and_right_if_all_three_are_named() -> None:
    names = "static_friction", "time_delay", "periodic_disturbance"
    scores = [score(truth(*names), answer("missing_physics", *said), 2.0) for said in (names, names[:2])]
    found = summarise(scores)
    assert found["right_triples"] == 0.5 and found["right_pairs"] is None and found["false_name_rate"] == 0.0
    assert set(found["sizes"]) == {"triples"}
    rows, columns, counts = confusion(scores)
    assert rows == ["three effects"] and dict(zip(columns, counts[0], strict=True)) == {"all": 1, "static_friction": 1}


def test_the_json_has_the_contract_s_keys_and_the_tables_a_row_per_figure_and_effect() -> None:
    scores = some_scores()
    whole = document("ab12", scores)
    assert json.loads(json.dumps(whole, allow_nan=False)) == whole
    assert set(whole) == {"seal_sha256", "cases", "summary"}
    contract = {"case", "truth", "verdict", "effects", "correct", "false_name", "block_correct", "seconds"}
    contract.add("heldout_nrmse")
    assert contract <= set(whole["cases"][0])
    assert {"right", "false_name_rate", "coverage", "by_effect"} <= set(whole["summary"])
    assert len(rates_table(whole["summary"]).texts()) == len(whole["summary"]) - 3
    assert [row[0] for row in effects_table(whole["summary"]).texts()] == list(whole["summary"]["by_effect"])


def test_the_picture_has_a_cell_for_every_kind_of_answer() -> None:
    figure = confusion_picture(some_scores())
    axes = figure.axes[0]
    assert sorted(text.get_text() for text in axes.texts) == ["1"] * 6
    with pytest.raises(BadInput, match="no case"):
        confusion_picture([])


def test_a_trial_seals_first_hands_over_folders_without_truths_and_survives_a_crash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(4)
    cases = [draw_single(rng, "case-0001", "coulomb_friction", 0.8), draw_plain(rng, "case-0002", wrong=False)]
    said: list[str] = []

    def diagnose(folder: Path) -> dict[str, Any]:
        assert said == [f"sealed 2 truths, sha256 {seal(cases)}"]
        assert not list(tmp_path.rglob("truth*"))
        if folder.name == "case-0002":
            raise KeyError("lost")
        return answer("missing_physics", "coulomb_friction")

    monkeypatch.setattr(run, "draw_trial", lambda seed, per_effect, remainder, plant: cases)
    study, done = run.sealed_study(1, 0.0, "foreign", diagnose, lambda: ThreadPoolExecutor(1)), list[float]()
    assert study.steps(Asked(tmp_path)) == 2
    report = study.run(Asked(tmp_path, say=said.append), done.append)
    whole = report.document
    assert done == [1, 2] and [len(table.rows) > 0 for table in report.tables] == [True, True]
    assert [(case["verdict"], case["correct"]) for case in whole["cases"]] == [
        ("missing_physics", True),
        ("crashed", False),
    ]
    assert whole["seal_sha256"] == seal(cases)
    assert whole["summary"]["crashed"] == 1
    assert report.tables[0].texts()[0][:2] == ["plant", "foreign"]
    assert json.loads((tmp_path / "trial.json").read_text()) == whole
    assert json.loads((tmp_path / "diagnoses.json").read_text())["case-0002"]["summary"] == "KeyError: 'lost'"
    opened = (tmp_path / "truths.json").read_bytes()
    assert hashlib.sha256(opened).hexdigest() == seal(cases)
    assert (tmp_path / "confusion.png").read_bytes().startswith(b"\x89PNG")
