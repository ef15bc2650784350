"""Every verdict makes one page that stands alone, says what was found, and shows what it was found in."""

import re
from dataclasses import replace

import pytest
from report_page import Page
from report_samples import diagnosis_of

from mmt_drake.analysis.interactive import unpacked
from mmt_drake.diagnosis.decide.block_replay import BlockReplay
from mmt_drake.diagnosis.tell.first_screen import BUDGET, NEXT, SOURCES
from mmt_drake.diagnosis.tell.report import DETAILED, OVERVIEWS, write_report
from mmt_drake.diagnosis.tell.report_tables import candidate_table
from mmt_drake.diagnosis.tell.result import EffectParameter, HeldoutNrmse, NamedEffect
from mmt_drake.effects import LIBRARY

TITLES = {
    "no_mismatch": ("The model explains the recording to its noise", "No mismatch beyond noise", "good"),
    "parameters": ("The structure is right, parameter values are not", "Wrong parameter values", "fair"),
    "missing_physics": ("The model leaves out static friction", "Physics is missing", "bad"),
    "partly_explained": (
        "The model leaves out static friction, and more that nobody has named",
        "Physics is missing, a part of it without a name",
        "bad",
    ),
    "ambiguous": (
        "Static friction or Stribeck friction: this recording cannot tell",
        "Ambiguous: more than one explanation",
        "open",
    ),
    "unexplained": (
        "Something real is missing, and no known effect explains it",
        "Unexplained: no known effect fits",
        "bad",
    ),
    "insufficient_data": ("This recording cannot tell whether the model is right", "Not enough data to say", "neutral"),
}


ALWAYS = ["State of the recording", "How this was computed"]
FITTED = ["How well each model predicts", "Measured and simulated over time", "Where they differ", "Parameters"]


FITTED += ["Spectrum of the error", "What cannot be told", *ALWAYS]


SECTIONS = {
    "no_mismatch": FITTED,
    "parameters": [*FITTED, "Explanations tried"],
    "missing_physics": [*FITTED, "Explanations tried", "What is missing"],
    "partly_explained": [*FITTED, "Explanations tried", "What is missing"],
    "ambiguous": [*FITTED, "Explanations tried", "What may be missing"],
    "unexplained": [*FITTED, "Explanations tried", "A law without a name"],
    "insufficient_data": ALWAYS,
}


@pytest.fixture(scope="module")
def pages(evidence, tmp_path_factory) -> dict[str, str]:
    """The page of every verdict, with the evidence that goes with it."""
    folder = tmp_path_factory.mktemp("reports")
    before = {name: output for name, output in evidence.models.items() if name != "augmented"}
    without = replace(evidence, models=before, friction=None, restoring=None)
    shown = {"insufficient_data": [], "no_mismatch": [without], "parameters": [without]}
    paths = {v: write_report(diagnosis_of(v), shown.get(v, [evidence]), folder / v / "report.html") for v in TITLES}
    return {verdict: path.read_text() for verdict, path in paths.items()}


@pytest.mark.parametrize("verdict", TITLES)
def test_the_title_and_a_coloured_strip_say_the_verdict(pages, verdict):
    page = Page(pages[verdict])
    title, banner, tone = TITLES[verdict]
    assert page.of("h1") == page.of("title") == [title]
    assert banner in page.of("div")
    assert ("div", "class", f"banner {tone}") in page.attributes
    assert f".{tone} {{" in page.of("style")[0]


@pytest.mark.parametrize("verdict", TITLES)
def test_the_page_has_the_sections_of_its_verdict_and_no_empty_one(pages, verdict):
    page = Page(pages[verdict])
    first, plain = page.of("h2")[:3], page.of("h2")[3:]
    assert first == [BUDGET, NEXT, SOURCES]
    assert sorted(title for title in plain if title != "Restoring force and friction") == sorted(SECTIONS[verdict])
    for part in re.findall(r"<section.*?</section>", pages[verdict], re.DOTALL):
        assert re.search(r"<(p|figure|table|pre|div|ul|dl)[ >]", part), part[:200]


@pytest.mark.parametrize("verdict", TITLES)
def test_the_page_fetches_nothing_and_is_small_enough_to_be_sent(pages, verdict):
    text = pages[verdict]
    page = Page(text)
    assert page.open == []
    targets = [value for _, name, value in page.attributes if name in ("src", "href", "srcset", "action", "data")]
    assert all(target.startswith("#") for target in targets)
    written = re.sub(r'<script[^>]*id="packed">[^<]*<', "", text)  # the library; below, what it is asked to do
    assert not re.search(r"https?:|//[a-z]|@import|url\(|<link|<iframe|fetch\(|XMLHttp", written)
    assert all("source" not in image for image in figures_of(text))
    assert len(text) < 3e6


def figures_of(text: str) -> list[dict]:
    packed = re.search(r'id="packed">([^<]*)<', text)
    return unpacked(packed.group(1)) if packed else []


@pytest.mark.parametrize("verdict", TITLES)
def test_every_figure_has_its_place_and_shows_something(pages, verdict):
    drawn = figures_of(pages[verdict])
    assert len(drawn) == pages[verdict].count('class="plot"')
    assert (len(drawn) > 0) == (verdict != "insufficient_data")
    for figure in drawn:
        assert len(figure["data"]) > 0 and figure["layout"]["height"] > 200


def test_what_was_handed_in_is_shown_as_text_and_not_as_markup(pages):
    assert "What was found, and &lt;what&gt; to do &amp; when." in pages["missing_physics"]
    assert "What was found, and <what> to do & when." in Page(pages["missing_physics"]).of("p")


def test_a_named_effect_comes_with_its_law_its_source_and_its_numbers(pages):
    page = Page(pages["missing_physics"])
    law = LIBRARY["static_friction"]
    assert law.equation in page.of("pre")
    assert law.source in page.text
    assert "Static friction" in page.of("h3")
    cells = page.of("td")
    start = cells.index("Fs")
    assert cells[start : start + 4] == ["Fs", "0.98", "0.95 to 1.01", "N"]
    assert cells[cells.index("k2") :][:5] == ["k2", "500", "612", "608 to 616", "N/m"]


def test_every_candidate_is_listed_by_its_held_out_error_with_what_became_of_it_and_why(pages):
    cells = Page(pages["missing_physics"]).of("td")
    assert cells[cells.index("Coulomb friction + contact gap") :][:4] == [
        "Coulomb friction + contact gap",
        "0.062",  # N: 0.031 of a spread of 2 N
        "not taken",
        "the gap adds nothing",
    ]
    assert cells[cells.index("Time delay") :][:2] == ["Time delay", "–"]
    tried = replace(diagnosis_of("missing_physics"), candidates=diagnosis_of("missing_physics").candidates[::-1])
    (table,) = [candidate_table(tried)]
    errors = [row[1] for row in table.rows]
    assert errors[:-1] == sorted(errors[:-1]) and errors[-1] is None


def test_as_many_explanations_are_counted_as_were_tried_and_not_as_are_told(pages):
    text = Page(pages["missing_physics"]).text
    assert "Explanations tried: 61." in text
    assert "Of 61, the 5 that came out best." in text
    assert "Explanations tried: " not in Page(pages["no_mismatch"]).text  # none was


def test_fitted_numbers_of_what_is_not_explained_are_not_the_system_s_own(pages):
    said = "Something is missing. So the numbers that fit best"
    assert said in pages["unexplained"]
    assert said not in pages["parameters"]


def test_of_a_station_every_block_is_told_and_which_of_them_differ(tmp_path):
    replays = (
        BlockReplay(
            "to_telerobot", "position", 0.08, 0.02, {}, 0.0, True, "Off by 0.08 of its spread; it is 20 ms late."
        ),
        BlockReplay("environment", "force", 0.0, 0.0, {}, 0.0, False, "The replay gives it again to the last bit."),
        BlockReplay("detector", "detected_contact", None, note="Not replayed: position not recorded."),
    )
    found = replace(diagnosis_of("missing_physics"), replays=replays)
    page = Page(write_report(found, [], tmp_path / "report.html").read_text())
    assert "Block by block" in page.of("h2")
    assert "noise: to telerobot. Right, whatever was handed in: environment. Not recorded: detector." in page.text
    cells = page.of("td")
    assert cells[cells.index("to_telerobot") :][:4] == ["to_telerobot", "position", "0.08", replays[0].note]


def test_what_cannot_be_told_apart_is_said_and_so_is_what_to_record(pages):
    text = Page(pages["ambiguous"]).text
    assert "This recording cannot tell static friction from Stribeck friction." in text
    assert "Slow strokes below 5 mm/s, 20 s: operator file next.csv." in text
    assert "Found:" not in text


def test_errors_are_told_with_their_unit_beside_the_noise_floor(pages):
    page = Page(pages["missing_physics"])
    assert "varies by 2 N (standard deviation)" in page.text
    assert "Noise alone leaves 0.0322 N: the best model is at 1.07 times that." in page.text
    assert {"0.824 N", "0.246 N", "0.0344 N", "0.0322 N"} <= {text.strip() for text in page.of("span")}
    assert "warning" not in page.text


def test_an_error_below_the_noise_floor_is_a_warning(tmp_path):
    found = diagnosis_of("missing_physics")
    found = replace(found, fit=replace(found.fit, heldout_nrmse=HeldoutNrmse(0.4, 0.1, 0.013)))
    text = write_report(found, [], tmp_path / "report.html").read_text()
    assert "An error below the noise floor is a warning" in text


def test_findings_of_the_check_are_listed_worst_first(pages):
    cells = Page(pages["parameters"]).of("td")
    assert cells.index("force bias") < cells.index("clock")
    assert "the probe is never below the surface" in Page(pages["insufficient_data"]).of("td")


def test_an_effect_of_the_user_s_own_has_a_page_too(tmp_path):
    mine = NamedEffect("magnet_rail", "magnet_rail", "body", "law", {"F0": EffectParameter(0.3, "N")})
    found = replace(diagnosis_of("missing_physics"), effects=(mine,))
    page = Page(write_report(found, [], tmp_path / "report.html").read_text())
    assert page.of("h1") == ["The model leaves out magnet rail"]
    assert "Magnet rail" in page.of("h3")


def test_a_page_of_many_recordings_shows_the_first_and_says_how_many_are_left(evidence, tmp_path):
    many = [replace(evidence, recording=f"run {k}") for k in range(OVERVIEWS + 3)]
    text = write_report(diagnosis_of("missing_physics"), many, tmp_path / "report.html").read_text()
    titles = [title for title in Page(text).of("div") if title.startswith("run ")]
    assert f"run {OVERVIEWS - 1}, y" in titles
    assert not any(title.startswith(f"run {OVERVIEWS},") for title in titles)
    assert sum(title.endswith("furthest off") for title in titles) == DETAILED
    assert f"The first {OVERVIEWS} are shown; 3 more were used." in text
    assert len(text) < 3e6
