"""Experiments 1 and 3 of the thesis and the demo: cases that are run, measured, drawn and put into words.

`run_experiment` runs and measures; what it gives is computed from the recordings that it leaves. `write_report` draws
the figures and the page.
"""

from diagrams.experiments.plans import PLANS, Plan
from diagrams.experiments.report import write_report
from diagrams.experiments.runs import Case, ExperimentResult, run_experiment

__all__ = ["PLANS", "Case", "ExperimentResult", "Plan", "run_experiment", "write_report"]
