"""The document says what the contract says, in its order, and nothing that JSON does not have."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from report_samples import TABLE

from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.decide.block_replay import BlockReplay
from mmt_drake.diagnosis.decide.budget import BudgetPart
from mmt_drake.diagnosis.decide.mismatch import BlockShare, Dependence, Mismatch
from mmt_drake.diagnosis.tell.evidence import Evidence, Series
from mmt_drake.diagnosis.tell.result import (
    Alternative,
    Candidate,
    Diagnosis,
    EffectParameter,
    Fit,
    FittedParameter,
    HeldoutNrmse,
    NamedEffect,
)
from mmt_drake.diagnosis.tell.wording import PERCENT
from mmt_drake.diagnosis.tell.written import write_diagnosis
from mmt_drake.errors import BadInput

FS = EffectParameter(0.98, "N", (0.95, 1.01))

# The example of the contract, section 5.
CONTRACT = """
{"schema": "mmt_drake.diagnosis/2",
 "verdict": "missing_physics",
 "summary": "one paragraph a person can act on",
 "budget": [{"part": "parameters", "share": 0.31}, {"part": "static_friction", "share": 0.55, "unique": 0.49},
            {"part": "nameless", "share": 0.11}, {"part": "noise", "share": 0.03}],
 "effects": [{"name": "static_friction", "family": "dry_friction", "block": "friction", "certain": "law",
              "parameters": {"Fs": {"value": 0.98, "unit": "N", "ci95": [0.95, 1.01]}}}],
 "alternatives": [{"name": "stribeck_friction", "heldout_nrmse": 0.021, "indistinguishable": true}],
 "parameters": {"k2": {"nominal": 500.0, "value": 612.3, "unit": "N/m", "ci95": [608.0, 616.5]}},
 "mismatch": {"blocks": [{"block": "friction", "share": 0.93}], "intervals_s": [[3.1, 4.0]], "band_hz": [0.1, 3.6],
              "depends_on": [{"signal": "sliding_velocity", "score": 0.77, "where": "|v| < 0.005 m/s"}]},
 "fit": {"axes": ["y"], "heldout_s": [[12.0, 15.0]], "noise_floor": 0.016,
         "heldout_nrmse": {"nominal": 0.41, "refit": 0.12, "augmented": 0.017}},
 "next_recording": null,
 "model": "augmented_model.yaml"}
"""


@pytest.fixture
def diagnosis() -> Diagnosis:
    return Diagnosis(
        verdict="missing_physics",
        summary="one paragraph a person can act on",
        budget=(
            BudgetPart("parameters", 0.31),
            BudgetPart("static_friction", 0.55, 0.49),
            BudgetPart("nameless", 0.11),
            BudgetPart("noise", 0.03),
        ),
        effects=(NamedEffect("static_friction", "dry_friction", "friction", "law", {"Fs": FS}),),
        alternatives=(Alternative("stribeck_friction", 0.021, True),),
        parameters={"k2": FittedParameter(500.0, 612.3, "N/m", (608.0, 616.5))},
        mismatch=Mismatch(
            (BlockShare("friction", 0.93),),
            ((3.1, 4.0),),
            (0.1, 3.6),
            (Dependence("sliding_velocity", 0.77, "|v| < 0.005 m/s"),),
        ),
        fit=Fit(("y",), ((12.0, 15.0),), 0.016, HeldoutNrmse(0.41, 0.12, 0.017)),
        model="augmented_model.yaml",
    )


def keys(data: object) -> object:
    """The nested keys of a document in their order, values dropped."""
    if isinstance(data, dict):
        return [(key, keys(value)) for key, value in data.items()]
    return [keys(item) for item in data] if isinstance(data, list) else None


def cut_to(shape: object, data: object) -> object:
    """`data` without the keys that `shape` does not have."""
    if isinstance(shape, dict):
        return {key: cut_to(shape[key], value) for key, value in data.items() if key in shape}
    if isinstance(shape, list):
        return [cut_to(one, item) for one, item in zip(shape, data, strict=True)]
    return data


def test_the_contract_s_keys_come_first_in_its_order_with_its_values(diagnosis):
    contract, written = json.loads(CONTRACT), diagnosis.to_json()
    assert cut_to(contract, written) == contract
    assert keys(cut_to(contract, written)) == keys(contract)
    assert list(written)[: len(contract)] == list(contract)


def test_every_part_of_a_document_is_written(diagnosis, tmp_path):
    full = replace(
        diagnosis,
        verdict="unexplained",
        effects=(TABLE,),
        next_recording="slow strokes at three loads – 30 s",
        preflight=(Finding("gaps", "warn", "3 gaps, the longest 12 ms", {"count": 3, "longest_s": 0.012}),),
        candidates=(Candidate(("coulomb_friction", "contact_gap"), 0.1, 0.02, 0.3, "rejected", "no gain"),),
        tried=37,
        recordings=("a.mcap", "b.mcap"),
        replays=(BlockReplay("renderer", "rendered_force", 0.1, None, {"all": 0.1}, 0.0, True, "10 % off"),),
        seconds=12.5,
    )
    path = write_diagnosis(full, tmp_path / "out" / "diagnosis.json")
    text = path.read_text()
    assert json.loads(text) == full.to_json() and "three loads – 30 s" in text


def test_what_only_the_report_needs_is_not_in_the_document(diagnosis):
    told = replace(diagnosis, fit=replace(diagnosis.fit, spread=2.0, unit="N"), at_bounds=("m",))
    assert told.to_json() == diagnosis.to_json()
    assert told.fit.rms(0.41) == 0.82 and diagnosis.fit.rms(0.41) is None


def test_a_diagnosis_without_a_fit_is_a_document_too():
    refused = Diagnosis("insufficient_data", "The probe never touched the object.")
    written = refused.to_json()
    assert (written["fit"], written["model"], written["next_recording"]) == (None, None, None)
    assert written["mismatch"] == {"blocks": [], "intervals_s": [], "band_hz": None, "depends_on": []}


@pytest.mark.parametrize("number", [math.nan, math.inf, np.float64("nan")])
def test_a_number_that_json_does_not_have_is_not_written(diagnosis, number, tmp_path):
    wrong = replace(diagnosis, fit=replace(diagnosis.fit, noise_floor=number))
    with pytest.raises(BadInput, match=r"diagnosis: fit\.noise_floor: found .*(nan|inf)"):
        write_diagnosis(wrong, tmp_path / "diagnosis.json")
    assert not list(tmp_path.iterdir())


def test_numpy_s_numbers_are_written_as_plain_ones(diagnosis):
    written = replace(diagnosis, seconds=np.float64(1.5)).to_json()
    assert type(written["seconds"]) is float


@pytest.mark.parametrize("verdict", ["no_mismatch", "parameters", "insufficient_data", "unexplained"])
def test_no_verdict_but_the_naming_ones_carries_a_name(diagnosis, verdict):
    with pytest.raises(BadInput, match=f"effects: found static_friction, expected none.* for {verdict}"):
        replace(diagnosis, verdict=verdict)


def test_a_naming_verdict_needs_a_name_and_an_ambiguous_one_a_rival(diagnosis):
    with pytest.raises(BadInput, match="effects: found none, expected one or more for missing_physics"):
        replace(diagnosis, effects=())
    with pytest.raises(BadInput, match="alternatives: found none, expected one or more for ambiguous"):
        replace(diagnosis, verdict="ambiguous", alternatives=())


def test_evidence_of_unequal_lengths_is_refused():
    time, measured = np.arange(4.0), Series("force", "N", np.zeros(4))
    counted = np.ones(4, dtype=bool)
    with pytest.raises(BadInput, match=r"evidence: refit: found shape \(3,\), expected \(4,\)"):
        Evidence("a", "y", time, measured, counted, models={"refit": np.zeros(3)})
    with pytest.raises(BadInput, match=r"evidence: load: found shape \(5,\)"):
        Evidence("a", "y", time, measured, counted, states={"load": Series("load", "N", np.zeros(5))})


def test_residuals_are_measured_minus_simulated_and_held_out_blocks_include_their_ends():
    time, measured = np.arange(6.0), Series("force", "N", np.arange(6.0))
    counted = np.ones(6, dtype=bool)
    evidence = Evidence("a", "", time, measured, counted, ((1.0, 2.0), (5.0, 9.0)), {"augmented": np.ones(6)})
    assert list(evidence.residuals) == ["augmented"]
    np.testing.assert_array_equal(evidence.residuals["augmented"], np.arange(6.0) - 1.0)
    np.testing.assert_array_equal(np.flatnonzero(evidence.heldout), [1, 2, 5])


@pytest.mark.parametrize("shares", [(0.5, 0.4), (1.2, -0.2)])
def test_shares_of_a_budget_are_shares(diagnosis, shares):
    parts = tuple(BudgetPart(part, share) for part, share in zip(("nameless", "noise"), shares, strict=True))
    with pytest.raises(BadInput, match=r"budget: found .* expected shares of 0 or more that sum to 1"):
        replace(diagnosis, budget=parts)


def test_it_prints_in_a_line_and_a_notebook_shows_verdict_shares_and_numbers(diagnosis: Diagnosis) -> None:
    assert repr(diagnosis) == "Diagnosis(missing_physics: static_friction)"
    shown = replace(diagnosis, summary="F < 1 N", next_recording="press & slide")._repr_html_()
    for part in ("<b>missing physics</b>: F &lt; 1 N", "<td>static friction</td><td>55 %</td>", "press &amp; slide"):
        assert part in shown, shown
    assert "<td>Fs</td><td>0.98</td><td>0.95 to 1.01</td><td>N</td>" in shown
    assert "<td>k2</td><td>500</td><td>612</td><td>608 to 616</td><td>N/m</td>" in shown
    assert shown.count(PERCENT) == 1
    assert repr(Diagnosis("no_mismatch", "")) == "Diagnosis(no_mismatch)"
