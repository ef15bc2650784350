"""Every verdict makes one page that stands alone, says what was found, and shows what it was found in."""

import base64
import io
import re
from dataclasses import replace
from html.parser import HTMLParser

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from scipy.signal import welch

from mmt_drake.diagnosis import figures, figures_summary
from mmt_drake.diagnosis.block_replay import BlockReplay
from mmt_drake.diagnosis.figures_common import binned
from mmt_drake.diagnosis.report import DETAILED, OVERVIEWS, write_report
from mmt_drake.diagnosis.result import (
    Alternative,
    BlockShare,
    Candidate,
    Curve,
    Dependence,
    Diagnosis,
    EffectParameter,
    Evidence,
    Finding,
    Fit,
    FittedParameter,
    HeldoutNrmse,
    Mismatch,
    NamedEffect,
    Signal,
    Spectrum,
)
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput

NOISE = 0.02
RATE = 500.0
HELDOUT = ((6.0, 9.0), (18.0, 21.0))
LEARNED = (-0.7, -0.9, 0.1, 0.8, 0.6)
TABLE = NamedEffect(
    "tabulated_force",
    "friction",
    {
        "of": EffectParameter("sliding_velocity", ""),
        "at": EffectParameter((-0.2, -0.1, 0.0, 0.1, 0.2), "m/s"),
        "value": EffectParameter(
            (-0.7, -0.9, 0.1, 0.8, 0.6), "N", ((-0.8, -1.0, 0.0, 0.7, 0.5), (-0.6, -0.8, 0.2, 0.9, 0.7))
        ),
    },
)


def evidence_with_friction(seconds: float = 30.0) -> Evidence:
    """A body dragged with 60 N s/m and 0.8 N of friction, which the nominal and the refitted model lack."""
    noise = np.random.default_rng(7)
    time = np.arange(0.0, seconds, 1.0 / RATE)
    velocity = sum(0.06 / k * np.sin(2 * np.pi * 0.41 * k**1.3 * time + k) for k in range(1, 8))
    velocity[(time % 11.0) > 9.8] = 0.0
    counted = (time > 1.5) & (np.abs(time - 15.0) > 0.8)
    friction = 0.8 * np.tanh(velocity / 0.002)
    load = Signal("normal load", "N", 3.0 + np.sin(1.7 * time))
    force = np.where(counted, -(60.0 * velocity + friction), 0.0) + noise.normal(0.0, NOISE, len(time))
    b = -float(velocity[counted] @ force[counted]) / float(velocity[counted] @ velocity[counted])
    outputs = {"nominal": -55.0 * velocity, "refit": -b * velocity, "augmented": -(60.0 * velocity + friction)}
    outputs = {name: np.where(counted, output, 0.0) for name, output in outputs.items()}
    frequency, _ = welch(force, RATE, nperseg=4096)
    densities = {name: welch(force - output, RATE, nperseg=4096)[1] for name, output in outputs.items()}
    speed = Signal("sliding velocity", "m/s", velocity)
    deflection = Signal("deflection", "m", force / 500.0)
    position = Signal("position", "m", np.cumsum(velocity) / RATE)
    kept = {name: output[counted] for name, output in outputs.items()}
    return Evidence(
        "strokes.mcap",
        "y",
        time,
        Signal("force on the probe", "N", force),
        counted,
        HELDOUT,
        **outputs,
        noise=NOISE,
        states={"sliding_velocity": speed, "deflection": deflection, "load": load, "position": position},
        restoring=Curve(
            replace(deflection, values=deflection.values[counted]),
            Signal("restoring force", "N", force[counted]),
            500.0 * deflection.values[counted],
        ),
        friction=Curve(
            replace(speed, values=velocity[counted]),
            Signal("friction", "N", force[counted] + 60.0 * velocity[counted]),
            kept["refit"] + 60.0 * velocity[counted],
            kept["augmented"] + 60.0 * velocity[counted],
        ),
        spectrum=Spectrum(frequency, **densities, noise=np.full(len(frequency), 2 * NOISE**2 / RATE)),
    )


def diagnosis_of(verdict: str) -> Diagnosis:
    """A plausible diagnosis with that verdict."""
    karnopp = {
        "Fs": EffectParameter(0.98, "N", (0.95, 1.01)),
        "Fd": EffectParameter(0.79, "N", (0.76, 0.83)),
        "v_d": EffectParameter(0.004, "m/s", (0.0031, 0.0052)),
    }
    stick = NamedEffect("static_friction", "friction", karnopp, 0.99)
    stribeck = Alternative("stribeck_friction", 0.0182, verdict == "ambiguous", "the same above 5 mm/s")
    fit = Fit(("y",), HELDOUT, 0.0161, HeldoutNrmse(0.412, 0.123, 0.0172))
    base = Diagnosis(
        verdict="no_mismatch",
        summary="What was found, and <what> to do & when.",
        fit=fit,
        recordings=("strokes.mcap",),
        preflight=(
            Finding("clock", "note", "1000 Hz, no gap"),
            Finding("force_bias", "warn", "the force reads 0.03 N in free space", {"bias_n": 0.03}),
        ),
        seconds=12.7,
        model="augmented_model.yaml",
    )
    mismatch = Mismatch(
        (BlockShare("friction", 0.93), BlockShare("contact", 0.07)),
        ((3.1, 4.0), (9.5, 10.25)),
        (0.1, 3.6),
        (Dependence("sliding_velocity", 0.77, "|v| < 0.005 m/s"), Dependence("load", 0.12, "")),
    )
    k2 = {"k2": FittedParameter(500.0, 612.3, "N/m", (608.0, 616.5)), "b1": FittedParameter(60.0, 57.0, "N s/m", None)}
    tried = (
        Candidate(("static_friction",), 0.0172, 0.106, 0.0005, "accepted", "best on held-out data"),
        Candidate(("stribeck_friction",), 0.0182, 0.105, 0.0005, "ambiguous", "0.6 noise floors behind"),
        Candidate(("coulomb_friction", "contact_gap"), 0.031, 0.092, 0.001, "rejected", "the gap adds nothing"),
        Candidate(("hunt_crossley_damping",), 0.118, 0.005, 0.21, "at a bound", "lambda at 1e4 1/m"),
        Candidate(("time_delay",), None, None, None, "rejected", "no gain when scored"),
    )
    found = replace(base, mismatch=mismatch, parameters=k2, candidates=tried, tried=61)
    match verdict:
        case "no_mismatch":
            return replace(base, fit=replace(fit, heldout_nrmse=HeldoutNrmse(0.0163, 0.0162, None)))
        case "parameters":
            return replace(base, verdict="parameters", parameters=k2, candidates=tried[2:])
        case "missing_physics":
            return replace(found, verdict="missing_physics", effects=(stick,))
        case "ambiguous":
            what = "Slow strokes below 5 mm/s, 20 s: operator file next.csv."
            return replace(found, verdict="ambiguous", effects=(stick,), alternatives=(stribeck,), next_recording=what)
        case "unexplained":
            return replace(found, verdict="unexplained", effects=(TABLE,), candidates=tried[2:])
        case _:
            why = Finding("no_contact", "refuse", "the probe is never below the surface")
            return Diagnosis("insufficient_data", "No contact.", preflight=(why,), next_recording="Press down.")


TITLES = {
    "no_mismatch": ("The model explains the recording to its noise", "No mismatch beyond noise", "good"),
    "parameters": ("The structure is right, parameter values are not", "Wrong parameter values", "fair"),
    "missing_physics": ("The model leaves out static friction", "Physics is missing", "bad"),
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
    "insufficient_data": (
        "This recording cannot tell whether the model is right",
        "Not enough data to say",
        "neutral",
    ),
}
ALWAYS = ["State of the recording", "How this was computed"]
FITTED = ["How well each model predicts", "Measured and simulated over time", "Where they differ", "Parameters"]
FITTED += ["Spectrum of the error", "What cannot be told", *ALWAYS]
SECTIONS = {
    "no_mismatch": FITTED,
    "parameters": [*FITTED, "Explanations tried"],
    "missing_physics": [*FITTED, "Explanations tried", "What is missing"],
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


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return evidence_with_friction()


@pytest.fixture(scope="module")
def pages(evidence, tmp_path_factory) -> dict[str, str]:
    """The page of every verdict, with the evidence that goes with it."""
    folder = tmp_path_factory.mktemp("reports")
    without = replace(evidence, augmented=None, friction=None, restoring=None)
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
    mine = NamedEffect("magnet_rail", "body", {"F0": EffectParameter(0.3, "N")})
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


def test_the_worst_windows_lie_where_the_error_is_and_in_held_out_blocks_if_these_are_long_enough():
    time = np.arange(0.0, 20.0, 0.01)
    measured, counted = Signal("force", "N", np.zeros(len(time))), np.ones(len(time), dtype=bool)
    burst = 0.01 + 1.0 * ((time > 4.0) & (time < 4.5)) + 0.6 * ((time > 12.0) & (time < 13.0))
    free = Evidence("a", "y", time, measured, counted, nominal=10.0 * np.ones(len(time)), refit=burst)
    louder, longer = figures.worst_windows(free, count=2, length_s=2.0)
    assert louder[0] <= 4.01 and louder[1] >= 4.49
    assert longer[0] <= 12.01 and longer[1] >= 12.99
    held = replace(free, heldout_s=((10.0, 14.0),))
    assert all(start >= 10.0 and end <= 14.0 + 1e-9 for start, end in figures.worst_windows(held, 5, 2.0))
    unseen = replace(free, counted=(time > 6.0))
    assert figures.worst_windows(unseen, 1, 2.0)[0][0] == pytest.approx(12.0, abs=1.1)


def test_no_window_is_worst_where_no_model_is_off():
    time = np.arange(0.0, 5.0, 0.01)
    right = Evidence("a", "", time, Signal("x", "m", time), np.ones(len(time), dtype=bool), nominal=time)
    assert figures.worst_windows(right) == []
    with pytest.raises(BadInput, match="no window with an error"):
        figures.zooms(right)


def test_binned_medians_are_the_quantiles_of_a_known_law():
    over = np.repeat(np.linspace(-1.0, 1.0, 2001), 11)
    values = 0.3 * over + np.tile(np.linspace(-0.5, 0.5, 11), 2001)
    centre, low, median, high = binned(over, values)
    np.testing.assert_allclose(median, 0.3 * centre, atol=0.01)
    np.testing.assert_allclose(high - median, 0.4, atol=0.01)
    np.testing.assert_allclose(median - low, 0.4, atol=0.01)


def test_drawn_errors_are_measured_minus_simulated_where_samples_count(evidence):
    _, nominal, refit, augmented, enlarged = figures.overview(evidence).axes
    for panel, name in ((nominal, "nominal"), (refit, "refit"), (augmented, "augmented"), (enlarged, "augmented")):
        drawn = panel.get_lines()[0]
        at = np.searchsorted(evidence.time, np.asarray(drawn.get_xdata()))
        expected = np.where(evidence.counted, evidence.residuals[name], np.nan)[at]
        np.testing.assert_array_equal(np.asarray(drawn.get_ydata()), expected)
        assert np.nanmax(drawn.get_ydata()) == evidence.residuals[name][evidence.counted].max()
    assert nominal.get_ylim() == refit.get_ylim() == augmented.get_ylim()


def test_a_spectrum_keeps_its_level_when_it_is_averaged_for_drawing(evidence):
    flat = Spectrum(np.arange(0.0, 250.0, 0.1), nominal=np.full(2500, 3e-4))
    (panel,) = figures.spectra(replace(evidence, spectrum=flat)).axes
    np.testing.assert_allclose(panel.get_lines()[0].get_ydata(), 3e-4)


def test_figures_touch_no_global_state(evidence):
    before = mpl.rcParams.copy()
    found = diagnosis_of("missing_physics")
    drawn = [
        figures.overview(evidence),
        figures.zooms(evidence),
        figures.residual_over_states(evidence),
        figures.curves(evidence),
        figures.spectra(evidence, (0.1, 3.0)),
        figures_summary.heldout_errors(found.fit),
        figures_summary.where(found.mismatch),
        figures_summary.rivals(found),
        figures_summary.parameters(found),
        figures_summary.learned_law(TABLE),
    ]
    assert all(type(figure) is Figure for figure in drawn)
    assert mpl.rcParams == before
    assert not mpl._pylab_helpers.Gcf.figs  # what pyplot would keep


def test_a_picture_of_what_is_not_there_is_refused(evidence):
    bare = Evidence("a", "y", evidence.time, evidence.measured, evidence.counted)
    for draw in (figures.zooms, figures.residual_over_states, figures.curves, figures.spectra):
        with pytest.raises(BadInput, match="evidence a, y"):
            draw(bare)
    nothing = diagnosis_of("insufficient_data")
    for draw in (figures_summary.rivals, figures_summary.parameters):
        with pytest.raises(BadInput, match="diagnosis"):
            draw(nothing)
    with pytest.raises(BadInput, match="mismatch"):
        figures_summary.where(nothing.mismatch)
    with pytest.raises(BadInput, match="heldout_nrmse"):
        figures_summary.heldout_errors(Fit((), (), None, HeldoutNrmse(None, None, None)))
    with pytest.raises(BadInput, match="static_friction"):
        figures_summary.learned_law(diagnosis_of("missing_physics").effects[0])


def test_a_recording_alone_can_be_looked_at(evidence):
    bare = Evidence("a", "", evidence.time, evidence.measured, evidence.counted)
    (panel,) = figures.overview(bare).axes
    assert panel.get_title(loc="left") == "a"
