"""Every verdict makes one page that stands alone, says what was found, and shows what it was found in."""

import base64
import io
import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from report_samples import diagnosis_of

from mmt_drake.analysis import page
from mmt_drake.diagnosis.decide.block_replay import BlockReplay
from mmt_drake.diagnosis.tell import figures
from mmt_drake.diagnosis.tell.report import DETAILED, OVERVIEWS, write_report
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


FITTED += ["What the model's error is made of", "Spectrum of the error", "What cannot be told", *ALWAYS]


SECTIONS = {
    "no_mismatch": FITTED,
    "parameters": [*FITTED, "Explanations tried"],
    "missing_physics": [*FITTED, "Explanations tried", "What is missing"],
    "partly_explained": [*FITTED, "Explanations tried", "What is missing"],
    "ambiguous": [*FITTED, "Explanations tried", "What may be missing", "What to record next"],
    "unexplained": [*FITTED, "Explanations tried", "A law without a name"],
    "insufficient_data": [*ALWAYS, "What to record next"],
}


class Page(HTMLParser):
    """A page's texts by tag, attributes, and the tags left open."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.texts: dict[str, list[str]] = {}
        self.attributes: list[tuple[str, str, str]] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in ("meta", "img"):
            self.open.append(tag)
            self.texts.setdefault(tag, []).append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open:
            self.texts[self.open[-1]][-1] += data

    def of(self, tag):
        return self.texts.get(tag, [])

    @property
    def text(self) -> str:
        return " ".join(" ".join(texts) for tag, texts in self.texts.items() if tag not in ("style", "html"))


def once(make: Callable[..., Any]) -> Callable[..., Any]:
    """The same picture of the same thing is made once, whichever page shows it."""
    made: dict[tuple[object, ...], tuple[object, Any]] = {}

    def again(of: object, *how: object) -> Any:
        key = (id(of), *how)
        if key not in made:
            made[key] = of, make(of, *how)  # kept beside it, for nothing else to have its id
        return made[key][1]

    return again


@pytest.fixture(scope="module")
def pages(evidence, tmp_path_factory) -> dict[str, str]:
    """The page of every verdict, with the evidence that goes with it."""
    folder, drawn = (
        tmp_path_factory.mktemp("reports"),
        ("overview", "zooms", "residual_over_states", "curves", "spectra"),
    )
    before = {name: output for name, output in evidence.models.items() if name != "augmented"}
    without = replace(evidence, models=before, friction=None, restoring=None)
    shown = {"insufficient_data": [], "no_mismatch": [without], "parameters": [without]}
    with pytest.MonkeyPatch.context() as patch:
        for module, names in ((figures, drawn), (page, ("png",))):
            for name in names:
                patch.setattr(module, name, once(getattr(module, name)))
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
    plain = [title for title in page.of("h2") if title != "Restoring force and friction"]
    assert sorted(plain) == sorted(SECTIONS[verdict])
    for part in re.findall(r"<section.*?</section>", pages[verdict], re.DOTALL):
        assert re.search(r"<(p|figure|table|pre)[ >]", part), part[:200]


@pytest.mark.parametrize("verdict", TITLES)
def test_the_page_stands_alone_and_is_small_enough_to_be_sent(pages, verdict):
    text = pages[verdict]
    page = Page(text)
    assert page.open == []
    targets = [value for _, name, value in page.attributes if name in ("src", "href", "srcset", "action", "data")]
    assert all(target.startswith(("data:image/png;base64,", "#")) for target in targets)
    assert not re.search(r"https?:|//[a-z]|@import|url\(|<script|<link|<iframe", re.sub('base64,[^"]*', "", text))
    assert len(text) < 3e6


@pytest.mark.parametrize("verdict", TITLES)
def test_every_picture_is_whole_has_a_caption_and_shows_something(pages, verdict):
    pictures = re.findall(r'src="data:image/png;base64,([^"]*)"', pages[verdict])
    assert len(pictures) == len(Page(pages[verdict]).of("figcaption")) == pages[verdict].count('alt="')
    assert (len(pictures) > 0) == (verdict != "insufficient_data")
    for picture in pictures:
        pixels = imread(io.BytesIO(base64.b64decode(picture, validate=True)))
        assert pixels.shape[1] > 1000
        assert 0.005 < np.mean(pixels[..., :3].min(axis=2) < 0.9) < 0.7, "blank, or nothing but ink"


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
    assert cells[start : start + 5] == ["Fs", "0.98", "N", "0.95", "1.01"]
    assert cells[cells.index("k2") :][:6] == ["k2", "500", "612.3", "N/m", "608", "616.5"]


def test_every_candidate_is_listed_with_what_became_of_it_and_why(pages):
    cells = Page(pages["missing_physics"]).of("td")
    assert cells[cells.index("Coulomb friction + contact gap") :][:6] == [
        "Coulomb friction + contact gap",
        "3.1",
        "9.2",
        "0.001",
        "rejected",
        "the gap adds nothing",
    ]
    assert cells[cells.index("time delay") :][:4] == ["time delay", "–", "–", "–"]


def test_as_many_explanations_are_counted_as_were_tried_and_not_as_are_told(pages):
    text = Page(pages["missing_physics"]).text
    assert "Explanations tried: 61." in text
    assert "Of 61, the 5 that came out best." in text
    assert "Explanations tried: " not in Page(pages["no_mismatch"]).text  # none was


def test_of_a_station_every_block_is_told_and_which_of_them_differ(tmp_path):
    replays = (
        BlockReplay("to_telerobot", "position", 0.08, 0.02, {}, 0.0, True, "8 % off; it is 20 ms late."),
        BlockReplay("environment", "force", 0.0, 0.0, {}, 0.0, False, "The replay gives it again to the last bit."),
        BlockReplay("detector", "detected_contact", None, note="Not replayed: position not recorded."),
    )
    found = replace(diagnosis_of("missing_physics"), replays=replays)
    page = Page(write_report(found, [], tmp_path / "report.html").read_text())
    assert "Block by block" in page.of("h2")
    assert "noise: to telerobot. Right, whatever was handed in: environment. Not recorded: detector." in page.text
    cells = page.of("td")
    assert cells[cells.index("to_telerobot") :][:4] == ["to_telerobot", "position", "8", replays[0].note]


def test_what_cannot_be_told_apart_is_said_and_so_is_what_to_record(pages):
    text = Page(pages["ambiguous"]).text
    assert "This recording cannot tell static friction from Stribeck friction." in text
    assert "Slow strokes below 5 mm/s, 20 s: operator file next.csv." in text
    assert "Found:" not in text


def test_errors_are_said_in_words_beside_the_noise_floor(pages):
    text = Page(pages["missing_physics"]).text
    assert "is off by 41.2 % of the measured signal's spread" in text
    assert "12.3 % remain. With static friction, 1.72 %." in text
    assert "Sensor noise alone leaves 1.61 %: the best model is at 1.07 times that." in text
    assert "warning" not in text


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
    captions = " ".join(Page(text).of("figcaption"))
    assert f"Recording run {OVERVIEWS - 1}, y:" in captions
    assert f"run {OVERVIEWS}," not in captions
    assert captions.count("furthest off") == DETAILED
    assert f"The first {OVERVIEWS} are shown; 3 more were used." in text
    assert len(text) < 3e6
