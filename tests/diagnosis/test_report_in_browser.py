"""In a real browser: a report draws its figures without asking for anything, and fits a phone."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from chromium import Chromium, find_chromium
from report_samples import diagnosis_of

from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.report import write_report

SIZES = {"desktop": (1280, 900), "phone": (390, 844)}


@pytest.fixture
def tab() -> Iterator[Chromium]:
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium on the path (MMT_CHROMIUM names one)")
    with Chromium(program) as chromium:
        yield chromium


@pytest.mark.parametrize("screen", SIZES)
def test_figures_are_drawn_nothing_is_asked_for_and_nothing_sticks_out(
    tab: Chromium, screen: str, evidence: Evidence, tmp_path: Path
) -> None:
    page = write_report(diagnosis_of("missing_physics"), [evidence], tmp_path / "report.html").as_uri()
    tab.narrow(*SIZES[screen])
    tab.open(page)
    tab.wait_for("document.documentElement.dataset.drawn == 'yes'", "file://")
    places, drawn = (
        tab.evaluate(f"document.querySelectorAll('{of}').length", "file://") for of in (".plot", ".plot .main-svg")
    )
    assert places > 5 and drawn >= places
    assert tab.evaluate("document.documentElement.scrollWidth", "file://") <= SIZES[screen][0]
    assert [asked for asked in tab.requested if not asked.startswith(("data:", "blob:"))] == [page]
    assert tab.complaints == []
