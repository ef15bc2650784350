"""Experiment 2 of the thesis: can a real contact be estimated?

`known_contacts` are what there is to estimate from, `run_second` runs the estimators over them, `report` leaves
a page.
"""

from mmt_drake.diagrams.experiments.second.contacts import Contact, known_contacts
from mmt_drake.diagrams.experiments.second.report import findings, report_of, second_table
from mmt_drake.diagrams.experiments.second.run import SecondResult, run_second

__all__ = ["Contact", "SecondResult", "findings", "known_contacts", "report_of", "run_second", "second_table"]
