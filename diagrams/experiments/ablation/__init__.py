"""The thesis's open question: what makes its rendered force wrong while its estimated force follows?

`causes` are changes of a scenario that has none of them, `claims` what the thesis's figures show as something that runs
either show too or do not; `run_ablation` puts in one cause after the other and judges.
"""

from mmt_drake.diagrams.experiments.ablation.causes import CAUSES, Cause
from mmt_drake.diagrams.experiments.ablation.claims import CLAIMS, Claim
from mmt_drake.diagrams.experiments.ablation.report import findings, report_of, short_table
from mmt_drake.diagrams.experiments.ablation.run import RUNS, AblationResult, Verdict, run_ablation

__all__ = [
    "CAUSES",
    "CLAIMS",
    "RUNS",
    "AblationResult",
    "Cause",
    "Claim",
    "Verdict",
    "findings",
    "report_of",
    "run_ablation",
    "short_table",
]
