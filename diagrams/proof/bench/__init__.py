"""The figures of `mmt-drake bench`, measured here and now, each with its target and, where there is one, a peer."""

from collections.abc import Iterator
from functools import partial
from importlib import import_module

from mmt_drake.diagrams.proof.studies.columns import tabled
from mmt_drake.diagrams.proof.studies.measurement import COLUMNS, Measurement, figures_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Report, Study

GROUPS = {
    "quick": {"setup": 14, "kernels": 14, "accuracy": 7, "repeatability": 2, "viewer": 2},
    "diagnosis": {"diagnosis": 17},
    "pacing": {"pacing": 20},
    "haptics": {"haptics": 9},
    "learning": {"learning": 7},
    "arms": {"arms": 2},
}
"""Group -> the modules here that measure it, and how many figures each gives."""

_LEADS = {
    "quick": "The stations, their kernels, how accurate and repeatable they are, and the live view.",
    "diagnosis": "How long `diagnose` takes on 30 s at 1 kHz with the whole library, and what a cluster makes of it.",
    "pacing": "Set-up 1 at 1 kHz by the wall clock, in turns with a loop that does nothing.",
    "haptics": "Set-ups 1 and 4 with an emulated device in the hand at 1 kHz.",
    "learning": "A learner beside set-up 1: its cost by the wall clock, repetition, energy, silence where nothing is.",
    "arms": "How long `diagnose` takes on a minute of a Panda's joints at 1 kHz.",
}


def measurements(group: str = "quick", **options: float) -> Iterator[Measurement]:
    """Every figure of one of `GROUPS`, as it comes; options are those of its module."""
    for part in GROUPS[group]:
        # Imported late: the first figure should not wait for what the last one needs.
        yield from import_module(f"mmt_drake.diagrams.proof.bench.{part}").measurements(**options)


def _run(group: str, options: dict[str, float], asked: Asked, progress: Progress) -> Report:
    command = "mmt-drake bench" if group == "quick" else f"mmt-drake bench {group}"
    measured = []
    for one in measurements(group, **options):
        measured.append(one)
        asked.say(str(one))
        progress(len(measured))
    missed = ", ".join(one.name for one in measured if one.met is False)
    return Report(
        {"figures": figures_of(measured, command)},
        title=f"Bench: {group}",
        lead=f"{_LEADS[group]} A figure with a peer was measured beside it in the same minute.",
        heading="",
        own_tables=[tabled(measured, COLUMNS)],
        sentences=[f"targets missed: {missed}" if missed else "all targets reached"],
    )


def bench_study(group: str, **options: float) -> Study:
    """The study of one of `GROUPS`; each figure is said as it comes."""
    return Study(
        f"bench {group}, figures", (), lambda asked: sum(GROUPS[group].values()), partial(_run, group, options)
    )
