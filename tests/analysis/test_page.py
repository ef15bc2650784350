"""The page holds all it shows, says what it was given, and stands or falls as one file."""

import base64
import re
from html.parser import HTMLParser

import pytest
from matplotlib.figure import Figure

from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.page import Picture, Section, write_page
from mmt_drake.analysis.summary import error_table, lines
from mmt_drake.analysis.table import Table
from mmt_drake.errors import BadInput

VOID = {"meta", "img", "br", "link"}


class Outline(HTMLParser):
    """Open tags checked against closing ones; attributes and texts by tag."""

    def __init__(self, page: str):
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.texts: list[tuple[str, str]] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if data.strip():
            self.texts.append((self.open[-1], data.strip()))

    def of(self, tag):
        return [text for where, text in self.texts if where == tag]


@pytest.fixture
def page(tmp_path):
    figure = Figure(figsize=(2, 1))
    figure.subplots().plot([0, 1])
    sections = [
        Section(
            "Errors & <lags>",
            "First\nparagraph.\n\nSecond.",
            [Picture(figure, 'Force "y" [N]')],
            Table(["case", "error [%]", "lag"], [["a", 12.34567, None], ["b", 0.5, 3]], "In contact."),
        ),
        Section("More"),
        Section("End", "Done."),
    ]
    return write_page(tmp_path / "out" / "page.html", "Set-up <1>", sections, "What this is.").read_text()


def test_the_page_parses_and_says_what_it_was_given(page):
    outline = Outline(page)
    assert outline.open == []
    assert outline.of("h1") == ["Set-up <1>"]
    assert outline.of("h2") == ["Errors & <lags>", "More", "End"]
    assert outline.of("p") == ["What this is.", "First paragraph.", "Second.", "Done."]
    assert outline.of("figcaption") == ['Force "y" [N]']
    assert outline.of("th") == ["case", "error [%]", "lag"]
    assert outline.of("td") == ["a", "12.35", "–", "b", "0.5", "3"]
    assert [value for tag, name, value in outline.attributes if (tag, name) == ("td", "class")] == ["number"] * 4


def test_the_page_needs_nothing_from_outside(page):
    outline = Outline(page)
    targets = [value for _, name, value in outline.attributes if name in ("src", "href", "srcset", "action")]
    assert targets and all(target.startswith(("data:image/png;base64,", "#")) for target in targets)
    assert not re.search(r"https?:|//[a-z]|@import|url\(|<script", page)
    anchors = {value for _, name, value in outline.attributes if name == "id"}
    assert {target[1:] for target in targets if target.startswith("#")} <= anchors


def test_pictures_are_embedded_whole(page):
    (source,) = re.findall(r'src="data:image/png;base64,([^"]*)"', page)
    assert base64.b64decode(source, validate=True).endswith(b"IEND\xaeB`\x82")


def test_a_picture_with_a_name_is_drawn_once_for_the_page_and_the_file_beside_it(tmp_path, monkeypatch):
    drawn, draw = [], Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda *given, **options: drawn.append(draw(*given, **options)))
    page = write_page(tmp_path / "page.html", "t", [Section("s", figures=[Picture(Figure((1, 1)), "c", name="one")])])
    assert base64.b64encode((tmp_path / "one.png").read_bytes()).decode() in page.read_text()
    assert len(drawn) == 1


def test_a_ragged_table_is_refused():
    with pytest.raises(BadInput, match="table: row 1: found 1 cells, expected 2"):
        Table(["a", "b"], [["1", "2"], ["1"]])


def test_a_page_that_cannot_be_written_leaves_nothing(tmp_path):
    (tmp_path / "page.html").mkdir()
    with pytest.raises(BadInput, match=r"page\.html"):
        write_page(tmp_path / "page.html", "t", [])
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


def test_the_summary_of_a_run_says_its_figures(stroke_run):
    found = measure(stroke_run, delay_s=0.4)
    told = "\n".join(lines(found))
    assert f"rendered force: error {100 * found.rendered_error.tangential['all']:.3g} %" in told
    assert "estimated force: error 2 % (below 0.3 Hz 2 %, 0.3 to 3 Hz 2 %, 3 to 10 Hz 2 %); normal 2 %" in told
    assert "touch lag: 800 ms (median of 4, of 4 in all)" in told
    late = measure(stroke_run, delay_s=0.4, after_s=found.contact_s / 2)
    table = error_table({"run": found}, {"run": late})
    row = table.rows[0]
    assert row[0] == "run"
    assert row[1] == pytest.approx(100 * found.rendered_error.tangential["all"])
    assert row[table.headers.index("2nd half [%]")] == pytest.approx(100 * late.rendered_error.tangential["all"])
    assert row[-2:] == pytest.approx([800.0, 800.0])
