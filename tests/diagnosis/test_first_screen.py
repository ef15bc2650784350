"""The first screen of a report says the verdict, the shares, what to do next, and where all of it comes from."""

import hashlib
import re
from dataclasses import replace
from pathlib import Path

import pytest
from report_page import Page
from report_samples import diagnosis_of

import mmt_drake
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.first_screen import BUDGET, NEXT, SOURCES, lead, next_steps
from mmt_drake.diagnosis.tell.provenance import Provenance
from mmt_drake.diagnosis.tell.report import write_report
from mmt_drake.diagnosis.tell.wording import PERCENT

VERDICTS = ("no_mismatch", "parameters", "missing_physics", "partly_explained", "ambiguous", "unexplained")


def first_of(text: str) -> str:
    """What stands before the links to the sections."""
    return text[: text.index("<nav>")]


@pytest.fixture
def page(evidence: Evidence, tmp_path: Path) -> str:
    recording, model = tmp_path / "strokes.mcap", tmp_path / "model.yaml"
    recording.write_bytes(b"recorded")
    model.write_text("structure: flexible_box")
    source = Provenance.of([recording, recording], model, "mmt-drake diagnose strokes.mcap --model 'my model.yaml'")
    return write_report(diagnosis_of("partly_explained"), [evidence], tmp_path / "report.html", source).read_text()


def test_the_verdict_stands_first_in_a_sentence_with_errors_in_units(page: str) -> None:
    first = Page(first_of(page))
    assert first.of("h1") == ["The model leaves out static friction, and more that nobody has named"]
    (said,) = first.of("p")[:1]
    assert (
        "That it is dry friction is certain; that it is static friction and no other law of that family is not." in said
    )
    assert "the model handed in is off by 0.824 N, with static friction by 0.0344 N (RMS)" in said
    assert "noise alone would leave 0.0322 N." in said


def test_the_shares_are_told_with_where_and_when(page: str) -> None:
    first = Page(first_of(page))
    assert first.of("h2") == [BUDGET, NEXT, SOURCES]
    spans = [text.strip() for text in first.of("span") if text.strip()]
    for name, share, note in (
        ("Wrong parameters", "31 %", "k2 500 → 612 N/m, b1 60 → 57 N s/m; throughout."),
        ("Static friction", "55 %", "Where: friction, |v| < 0.005 m/s. When: most at 3.1 to 4 s and 9.5 to 10.2 s."),
        ("What nobody has named", "11 %", "When: most at "),
        ("Noise", "3 %", "Sensors, throughout: 0.0322 N RMS."),
    ):
        at = spans.index(name)
        assert spans[at + 1] == share and note in spans[at + 2], spans[at : at + 3]


def test_what_to_do_next_and_the_provenance_stand_beside_them(page: str, tmp_path: Path) -> None:
    first = Page(first_of(page))
    steps = " ".join(first.of("li"))
    assert (
        "Use augmented_model.yaml in the place of the model as far as it goes: 11 % is still without a name." in steps
    )
    assert "Keep in mind: the force reads 0.03 N in free space" in steps
    facts = dict(zip(first.of("dt"), first.of("dd"), strict=True))
    assert facts["Program"] == f"mmt_drake {mmt_drake.__version__}"
    assert re.fullmatch(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", facts["Date"])
    assert facts["Command"] == "mmt-drake diagnose strokes.mcap --model 'my model.yaml'"
    digest = hashlib.sha256(b"recorded").hexdigest()
    assert facts["Recording"] == f"{tmp_path / 'strokes.mcap'}, sha256 {digest[:16]}…"
    assert facts["Model"].startswith(f"{tmp_path / 'model.yaml'}, sha256 ") and "Recording 2" not in facts
    assert digest in Page(page).of("td")


def test_percent_is_defined_once_and_no_error_is_told_as_another_percent(page: str) -> None:
    text = " ".join(Page(page).text.split())
    assert text.count(PERCENT) == 1
    told = re.findall(r"([\w.]+) %(?! interval)", text.replace("95 % of a right model's", ""))
    assert sorted(told) == sorted(["31", "55", "11", "3", "11"]), "the shares, and the nameless one once more"
    numbers = re.findall(r"(?<![\w.])\d*\.\d+", re.sub(r"[0-9a-f]{16,}", "", text))
    assert numbers and all(len(number.replace(".", "").lstrip("0")) <= 3 for number in numbers), numbers


@pytest.mark.parametrize("verdict", VERDICTS)
def test_every_verdict_has_a_plain_lead_and_a_next_step(verdict: str) -> None:
    found = diagnosis_of(verdict)
    said, steps = lead(found), next_steps(found)
    assert "0.824 N" in said or verdict == "no_mismatch"
    assert steps and all(step.endswith((".", "space")) for step in steps)
    for sentence in re.split(r"(?<=[.;:]) ", " ".join([said, *steps])):
        assert len(sentence.split()) <= 30, sentence


def test_a_refused_recording_says_why_and_what_to_do_and_divides_no_error(tmp_path: Path) -> None:
    found = diagnosis_of("insufficient_data")
    first = Page(first_of(write_report(found, [], tmp_path / "report.html").read_text()))
    assert first.of("p")[0] == "No contact."
    assert [item for item in first.of("li")] == ["the probe is never below the surface", "Press down."]
    facts = dict(zip(first.of("dt"), first.of("dd"), strict=True))
    assert facts["Command"] == "from Python" and facts["Model"] == "handed in from Python"


def test_what_proves_nothing_and_what_was_not_tried_is_said_before_anything_else() -> None:
    found = replace(diagnosis_of("missing_physics"), at_bounds=("b1", "m"), untried=("end_stop", "time_delay"))
    said = lead(found)
    assert said.startswith("Without effects, fitting drives b1 and m out of all bounds: that fit proves nothing.")
    assert "2 explanations were not tried for lack of time" in said
    assert any("--time-budget" in step for step in next_steps(found))


def test_a_recording_that_is_no_file_has_no_hash(tmp_path: Path) -> None:
    source = Provenance.of([tmp_path / "gone.csv"])
    assert ("Recording", f"{tmp_path / 'gone.csv'} (no file)") in source.facts


def test_warnings_are_a_part_of_what_to_do() -> None:
    gaps = Finding("gaps", "warn", "No samples for 1 s in all.")
    assert next_steps(replace(diagnosis_of("no_mismatch"), preflight=(gaps,)))[-1] == f"Keep in mind: {gaps.text}"
