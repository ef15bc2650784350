"""Experiments 1 and 3 of the thesis and the demo: cases that are run, measured, drawn and put into words.

`run_experiment` runs and measures; all that it gives is computed from the recordings it leaves. `report` draws
the figures and the page, `findings` says in sentences what the numbers say. `run_demo` is the main job on one page.
"""

from mmt_drake.diagrams.experiments.demo import Demo, run_demo
from mmt_drake.diagrams.experiments.findings import findings
from mmt_drake.diagrams.experiments.plans import PLANS, Plan
from mmt_drake.diagrams.experiments.reaching import figures_to_reach, reached_table
from mmt_drake.diagrams.experiments.report import parameter_table, report_of
from mmt_drake.diagrams.experiments.runs import Case, ExperimentResult, run_experiment

__all__ = [
    "PLANS",
    "Case",
    "Demo",
    "ExperimentResult",
    "Plan",
    "figures_to_reach",
    "findings",
    "parameter_table",
    "reached_table",
    "report_of",
    "run_demo",
    "run_experiment",
]
