"""The fault table of the whole: every kind of fault at random moments, from a device's motors to a recording's end."""

from mmt_drake.diagrams.faults.row import Row
from mmt_drake.diagrams.faults.table import PLACES, fault_table

__all__ = ["PLACES", "Row", "fault_table"]
