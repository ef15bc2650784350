"""Public recordings of real systems: models with known physics left out of them, diagnosed and scored."""

from mmt_drake.diagrams.trial.real.case import HeldOut, Published, RealCase, RealPart
from mmt_drake.diagrams.trial.real.data_sets import CASES, real_cases, without_a_case
from mmt_drake.diagrams.trial.real.run import (
    Diagnose,
    Diagnosed,
    Errors,
    RealResult,
    diagnosed_table,
    real_table,
    run_real,
)

__all__ = [
    "CASES",
    "Diagnose",
    "Diagnosed",
    "Errors",
    "HeldOut",
    "Published",
    "RealCase",
    "RealPart",
    "RealResult",
    "diagnosed_table",
    "real_cases",
    "real_table",
    "run_real",
    "without_a_case",
]
