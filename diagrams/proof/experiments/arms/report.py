"""What real arms came to, as text, page and document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Final

from mmt_drake.analysis.page import Section
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Reached, Report, Study, Target
from mmt_drake.diagrams.proof.trial.real.arm_cases import CASES, ArmResult, run_case
from mmt_drake.effects.wording import words

WITHIN: Final = 1.02
"""A joint may be so many times as far off as the better of two simple fits."""
_JOINTS: Final = Target("joints more than 2 % worse than the better simple fit", unit="joints", to_reach=0.0)
_MASS: Final = Target("mass of the load off", unit="%", to_reach=15.0)
_DRY: Final = Target("moving joints of the UR10e without dry friction", unit="joints", to_reach=0.0)


def report_of(results: Sequence[ArmResult]) -> Report:
    """What it comes to."""
    tables = [_errors_table(results), _names_table(results)]
    data = {"experiment": "arms", "cases": [asdict(result) for result in results]}
    return Report(
        data,
        "Real arms",
        (
            "Public recordings of arms. Each model is diagnosed on one log, then predicts the torque of another one "
            "from its motion alone; errors are RMS over the torque's spread, below 8 Hz, while a joint moves. Simple "
            "fits, viscous and Coulomb, are those that the recordings' notes print. The KR300, the PSM, the Schunk and "
            "the Kinova come without a file: their lengths are published, their masses guessed."
        ),
        "Arms",
        tables,
        [f"{result.name}: {result.verdict}." for result in results],
        [Section("By joint", table=tables[0]), Section("By arm", table=tables[1])],
        _reached(results),
    )


def _reached(results: Sequence[ArmResult]) -> list[Reached]:
    reached = []
    for result in results:
        known = [(f, s) for f, s in zip(result.found, result.simple, strict=True) if s is not None]
        if known:
            worse = sum(found > WITHIN * simple for found, simple in known)
            reached.append(Reached(f"{result.name}, {len(known)} joints", _JOINTS, float(worse)))
        if result.name == "UR10e":
            reached.append(Reached(result.name, _DRY, float(len(result.joints) - len(result.dry))))
        if result.load_kg is not None:
            off = None if result.payload_kg is None else 100.0 * abs(result.payload_kg / result.load_kg - 1.0)
            reached.append(Reached(result.name, _MASS, off, never=True))
    return reached


def _errors_table(results: Sequence[ArmResult]) -> Table:
    rows: list[list[Cell]] = []
    for result in results:
        for j, joint in enumerate(result.joints):
            errors = (result.handed_in[j], result.simple[j], result.found[j])
            rows.append([result.name if j == 0 else "", joint, *errors, _said(result.dry.get(joint, ""))])
    headers = ("arm", "joint", "as handed in", "simple fit", "with what was found", "dry friction")
    return Table(headers, rows, "Error of the torque over its spread, on a log that was not fitted.", digits=3)


def _said(name: str) -> str:
    return words(name) if name else "–"


def _names_table(results: Sequence[ArmResult]) -> Table:
    rows: list[list[Cell]] = [
        [r.name, ", ".join(r.fitted), r.tested or "blocks held out", words(r.verdict), r.payload_kg, r.seconds]
        for r in results
    ]
    headers = ("arm", "fitted to", "held to", "verdict", "payload [kg]", "time [s]")
    return Table(headers, rows, "What was diagnosed, and how long it took.", digits=3)


def _run(asked: Asked, progress: Progress) -> Report:
    return report_of(results_of([partial(run_case, case) for case in CASES], asked.jobs, progress, compile_first=True))


STUDIES: Final = {"arms": Study("arms", (), lambda asked: float(len(CASES)), _run)}
