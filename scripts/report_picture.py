"""Writes the picture of a diagnosis report in the README: `python scripts/report_picture.py docs/images/report.png`."""

import subprocess
import sys
import tempfile
from pathlib import Path

from chromium import Chromium, find_chromium

EXAMPLES = Path(__file__).parents[1] / "examples"
SIZE = (1280, 1210)


def main(target: Path) -> None:
    """Diagnose the example and take the picture of the report's first screen and its first figure."""
    program = find_chromium()
    if program is None:
        sys.exit("no Chromium on the path (MMT_CHROMIUM names one)")
    with tempfile.TemporaryDirectory() as folder, Chromium(program, size=SIZE) as browser:
        told = ["contact.csv", "--model", "contact.yaml", "--out", folder]
        subprocess.run(["mmt-drake", "diagnose", *told], cwd=EXAMPLES, check=True)
        browser.narrow(*SIZE)
        browser.open((Path(folder) / "report.html").as_uri())
        browser.wait_for("document.documentElement.dataset.drawn", "file://")
        shown = "mmt-drake diagnose contact.csv --model contact.yaml --out out/diagnosis"
        command = f"[...document.querySelectorAll('dd')][2].textContent = '{shown}'"
        browser.evaluate(command, "file://")  # not where this script has put it
        browser.evaluate("document.documentElement.style.overflow = 'hidden'", "file://")  # no bar to scroll with
        browser.picture(target)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
