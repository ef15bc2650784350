"""Pages of figures: `figures.py NAME ...` runs studies and writes docs/figures/NAME.md of each.

NAME: of an experiment; `bench`, `bench-diagnosis`, `bench-pacing`, `bench-haptics` or `bench-faults`.
"""

import sys
from functools import partial
from pathlib import Path

from mmt_drake.diagrams.proof.bench import GROUPS, bench_study
from mmt_drake.diagrams.proof.experiments import study_of
from mmt_drake.diagrams.proof.faults.table import faults_study
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.processors import processors

PAGES = Path(__file__).resolve().parents[1] / "docs" / "figures"
BENCHES = {"bench": partial(bench_study, "quick"), "bench-faults": partial(faults_study, 2)}
BENCHES |= {f"bench-{group}": partial(bench_study, group) for group in GROUPS if group != "quick"}
OPTIONS = {"bench-faults": " --moments 2"}


def main(names: list[str]) -> None:
    """Run each and write its page."""
    for name in names:
        study = BENCHES[name]() if name in BENCHES else study_of(name)
        report = study.run(Asked(Path("out") / name, jobs=processors()), lambda done: print(end=".", flush=True))
        command = name.replace("-", " ") + OPTIONS.get(name, "") if name in BENCHES else f"experiment {name}"
        PAGES.mkdir(exist_ok=True)
        (PAGES / f"{name}.md").write_text(report.markdown(f"mmt-drake {command}"))


if __name__ == "__main__":
    main(sys.argv[1:])
