"""In a real browser: a report draws its figures without asking for anything, and fits a phone."""

from pathlib import Path

import pytest
from chromium import Chromium
from report_samples import diagnosis_of

from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.report import write_report

SIZES = {"desktop": (1280, 900), "phone": (390, 844)}


@pytest.mark.parametrize("screen", SIZES)
def test_figures_are_drawn_nothing_is_asked_for_and_nothing_sticks_out(
    browser: Chromium, screen: str, evidence: Evidence, tmp_path: Path
) -> None:
    page = write_report(diagnosis_of("missing_physics"), [evidence], tmp_path / "report.html").as_uri()
    browser.narrow(*SIZES[screen])
    browser.open(page)
    browser.wait_for("document.documentElement.dataset.drawn == 'yes'", "file://")
    places, drawn = (
        browser.evaluate(f"document.querySelectorAll('{of}').length", "file://") for of in (".plot", ".plot .main-svg")
    )
    assert places > 5 and drawn >= places
    assert browser.evaluate("document.documentElement.scrollWidth", "file://") <= SIZES[screen][0]
    assert [asked for asked in browser.requested if not asked.startswith(("data:", "blob:"))] == [page]
    assert browser.complaints == []
