"""Pages of figures: `figures.py NAME ...` runs experiments and writes docs/figures/NAME.md of each."""

import sys
from pathlib import Path

from mmt_drake.diagrams.experiments import study_of
from mmt_drake.diagrams.studies import Asked
from mmt_drake.processors import processors

PAGES = Path(__file__).resolve().parents[1] / "docs" / "figures"


def main(names: list[str]) -> None:
    """Run each and write its page."""
    for name in names:
        asked = Asked(Path("out") / name, jobs=processors())
        report = study_of(name).run(asked, lambda done: print(end=".", flush=True))
        PAGES.mkdir(exist_ok=True)
        (PAGES / f"{name}.md").write_text(report.markdown(f"mmt-drake experiment {name}"))


if __name__ == "__main__":
    main(sys.argv[1:])
