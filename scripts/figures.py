"""Pages of figures: `figures.py NAME ...` runs studies and writes docs/figures/NAME.md of each.

NAME: of an experiment; `bench`, `bench-diagnosis`, `bench-pacing`, `bench-haptics` or `bench-faults`; of `TRIALS`.
"""

import os
import platform
import subprocess
import sys
import time
from datetime import date
from functools import partial
from pathlib import Path

from mmt_drake import __version__
from mmt_drake.cli.main import parser
from mmt_drake.cli.trial import trial_study
from mmt_drake.diagrams.proof.bench import GROUPS, bench_study
from mmt_drake.diagrams.proof.experiments import study_of
from mmt_drake.diagrams.proof.faults.table import faults_study
from mmt_drake.diagrams.proof.studies import Asked, Study
from mmt_drake.processors import processors

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "docs" / "figures"
BENCHES = {"bench": partial(bench_study, "quick"), "bench-faults": partial(faults_study, 5)}
BENCHES |= {f"bench-{group}": partial(bench_study, group) for group in GROUPS if group != "quick"}
OPTIONS = {"bench-faults": " --moments 5"}
_REAL = (
    *("emps", "silverbox", "bam_servo", "mr_damper", "brfd_friction_damper", "davinci_tool", "hsm150_motor"),
    *("carter_pendulum", "ur10e_jointwise", "kinova_gen3_joint7", "pork_indentation", "silicone_tensile"),
    *("falling_balls", "haptic_force_field"),
)
"""Data sets whose known physics acts along one axis; scans of palpation and arms have pages of their own."""
TRIALS = {
    "trial": "trial --seed 328 --per-effect 4",
    "trial-remainder": "trial --seed 77 --per-effect 3 --remainder 0.2",
    "trial-foreign": "trial --seed 316 --per-effect 1 --plant foreign",
    "trial-surfaces": "trial --seed 91 --per-effect 3 --plant palpation",
    "trial-arms": "trial --arms --seed 49 --per-effect 20",
    "trial-real": f"trial --real recordings{''.join(f' --only {name}' for name in _REAL)}",
    "trial-palpation": "trial --real recordings --only dvrk_palpation",
    "trial-further": "trial --real recordings --further",
}
"""Trials that have a page, each of a seed that nobody had looked at, and the command of it."""
_WRITTEN = "Written by the command above"
COUNTS = {"adequacy": 5, "late": 2, "fit": 20, "learning": 5, "scene": 10}
"""Cases, where a page has another number than the experiment by itself."""


def main(names: list[str]) -> None:
    """Run each and write its page."""
    describe = ["git", "-C", ROOT, "describe", "--always", "--dirty"]
    commit = subprocess.run(describe, capture_output=True, text=True, check=True).stdout.strip()
    for name in names:
        if name in TRIALS:
            study, seed = _trial(name)
        else:
            study, seed = BENCHES[name]() if name in BENCHES else study_of(name), 0
        asked = Asked(Path("out") / name, seed=seed, jobs=processors(), count=COUNTS.get(name), say=print)
        begun = time.perf_counter()
        report = study.run(asked, lambda done: print(end=".", flush=True))
        option = OPTIONS.get(name, "") if asked.count is None else f" --count {asked.count}"
        command = (name.replace("-", " ") if name in BENCHES else TRIALS.get(name, f"experiment {name}")) + option
        PAGES.mkdir(exist_ok=True)
        page = report.markdown(f"mmt-drake {command}") + "\n" + _made(time.perf_counter() - begun, commit)
        (PAGES / f"{name}.md").write_text(page)
        (PAGES / "index.md").write_text(_index())
        print(f" {name}", flush=True)


def _trial(name: str) -> tuple[Study, int]:
    """The study and its seed; the recordings of a trial of real ones are where `MMT_RECORDINGS` says."""
    arguments = parser("trial").parse_args(TRIALS[name].split())
    arguments.real = arguments.real and os.environ["MMT_RECORDINGS"]
    return trial_study(arguments), arguments.seed


def _index() -> str:
    """All pages: how many figures are reached and missed on each."""
    rows = []
    for page in sorted(PAGES.glob("*.md")):
        title, *lines = page.read_text().splitlines()
        reached, missed = (sum(line.count(mark) for line in lines if line.startswith("|")) for mark in "✓✗")
        when = lines[-1].rpartition("), ")[2].rstrip(".") if lines[-1].startswith(_WRITTEN) else "–"
        link = f"[{title.removeprefix('# ')}]({page.name})"
        if page.name != "index.md":
            rows.append(f"| {link} | {reached or '–'} | {missed or '–'} | {when} |\n")
    head = "# Figures\n\nEvery page was written by the command on it, and this one by `python scripts/figures.py`.\n"
    head += "Missed are also figures of the thesis's estimator and of peers, which stand beside ours.\n\n"
    return head + "| page | reached | missed | written |\n| --- | --- | --- | --- |\n" + "".join(rows)


def _made(seconds: float, commit: str) -> str:
    """By what, when and in how long a page was made."""
    took = f"{seconds / 60.0:.0f} min" if seconds > 90.0 else f"{seconds:.0f} s"
    return (
        f"{_WRITTEN} in {took} on {processors()} processors ({platform.machine()}), {date.today()}, "
        f"version {__version__}, commit {commit}.\n"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
