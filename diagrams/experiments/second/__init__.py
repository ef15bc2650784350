"""Experiment 2 of the thesis: can a real contact be estimated?

`known_contacts` are what there is to estimate from, `run_second` runs the estimators over them, `write_second` leaves
a page.
"""

from mmt_drake.diagrams.experiments.second.contacts import Contact, known_contacts
from mmt_drake.diagrams.experiments.second.report import findings, second_table, write_second
from mmt_drake.diagrams.experiments.second.run import SecondResult, run_second

__all__ = ["Contact", "SecondResult", "findings", "known_contacts", "run_second", "second_table", "write_second"]
